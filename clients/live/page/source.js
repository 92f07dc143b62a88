// Sources of pictures: the server's feed, or a recording with a time line.

/** Delay before a reconnection to the feed, ms. */
const AGAIN = 400;

/** Passes the messages of the feed to `page`; reconnects when the feed ends. */
export function live(page) {
  const socket = new WebSocket(`ws://${location.host}/feed`);
  socket.addEventListener("message", ({ data }) => {
    const [[kind, value]] = Object.entries(JSON.parse(data));
    if (kind === "scene") page.named(value);
    else page[kind]?.(value);
  });
  socket.addEventListener("close", () => {
    page.status({ alive: false, why: "no connection to the server; restart `atas dashboard`" });
    setTimeout(() => live(page), AGAIN);
  });
}

/** Pictures per request. */
const BLOCK = 120;

/** A recording: random access to pictures, and playback in real time. */
export class Recorded {
  constructor(page, recording) {
    this.page = page;
    this.recording = recording;
    this.blocks = new Map();
    this.scrub = document.getElementById("scrub");
    this.button = document.getElementById("play");
    this.scrub.max = recording.count - 1;
    this.scrub.addEventListener("input", () => this.seek(Number(this.scrub.value)));
    this.button.addEventListener("click", () => this.play(!this.playing));
    document.getElementById("timeline").hidden = false;
    this.seek(this.first());
  }

  /** Returns the index of the first moment of interest: first touch, else first fault, else first step of a task; 0 without any. */
  first() {
    const { events, faults, moments } = this.recording;
    const of = (wanted) => events.filter(({ kind }) => kind === wanted);
    const found = [of("touch-on"), faults, of("step")].find((moment) => moment.length);
    const from = Math.min(...(found ?? []).map(({ t_s }) => t_s));
    return Math.max(0, moments.findIndex(([t]) => t >= from));
  }

  async picture(index) {
    const from = index - (index % BLOCK);
    if (!this.blocks.has(from)) {
      if (this.blocks.size > 40) this.blocks.delete(this.blocks.keys().next().value);
      this.blocks.set(from, fetch(`/pictures/${from}/${BLOCK}`).then((answer) => answer.json()));
    }
    return (await this.blocks.get(from))[index - from];
  }

  async seek(index) {
    this.index = Math.min(this.recording.count - 1, Math.max(0, index));
    const wanted = this.index;
    const picture = await this.picture(wanted);
    if (wanted !== this.index || !picture) return;
    this.scrub.value = wanted;
    const seconds = picture.t_s - this.recording.moments[0][0];
    document.getElementById("at").value = `${seconds.toFixed(2)} s`;
    this.scrub.setAttribute("aria-valuetext", `${seconds.toFixed(2)} seconds`);
    this.page.picture(picture);
  }

  play(playing) {
    this.playing = playing;
    this.button.textContent = playing ? "Pause" : "Play";
    if (!playing) return;
    if (this.index >= this.recording.count - 1) this.index = 0;
    const [began, first] = [performance.now(), this.index];
    const step = async () => {
      if (!this.playing) return;
      const index = first + Math.floor((performance.now() - began) / 1000 / this.recording.period_s);
      if (index >= this.recording.count) return this.play(false);
      await this.seek(index);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}
