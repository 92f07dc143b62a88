// The page: receives the messages of a source and draws the newest picture once per screen frame.

import { Arena } from "/arena.js";
import { Controls } from "/controls.js";
import { Events, Faults } from "/events.js";
import { Fingers, forces } from "/fingers.js";
import { Robot } from "/robot.js";
import { Recorded, live } from "/source.js";
import { Timing } from "/timing.js";
import { Traces } from "/traces.js";

/** Screen frames between updates of slow plots. */
const SLOWLY = 3;
/** Interval of number updates, ms: long enough to read them. */
const READABLE = 100;

const by = (id) => document.getElementById(id);

class Page {
  constructor(scene) {
    this.robot = new Robot(by("robot"));
    this.traces = new Traces(by("traces"), by("traces-legend"));
    this.show(scene);
    this.eventLines = new Events(by("events"));
    this.faultList = new Faults(by("faults"), by("flight"), () => this.scene.fingers);
    this.timing = new Timing(by("histogram"), by("services"));
    this.arenaView = new Arena();
    this.frames = 0;
    this.toldAt = this.arenaToldAt = 0;
    this.origin = 0;
    for (const event of ["resize", "themechange"]) addEventListener(event, () => this.redraw());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => setTimeout(() => this.redraw()));
    requestAnimationFrame(() => this.draw());
  }

  /** Sets the displayed robot. */
  show(scene) {
    this.scene = scene;
    this.robot.take(scene);
    this.fingers = new Fingers(by("skin"), by("skin-scale"), scene);
    this.traces.take(scene);
    by("robot-name").textContent = (scene.robot ?? "").replace(/^.*\/|\.toml$/g, "");
    by("robot-note").textContent = scene.note;
    by("robot-note").hidden = !scene.note;
    this.newest = this.drawn = this.told = this.traced = null;
  }

  /** Processes a scene of the server; shows it if it has changed. */
  named(scene) {
    const { recording, bus } = this.scene;
    const said = JSON.stringify(scene);
    if (said !== this.said) this.show({ ...scene, recording, bus });
    this.said = said;
  }

  /** Processes the history before the page was opened. */
  past({ scene, moments, events, status, faults }) {
    if (scene) this.named(scene);
    // Times are relative to the start of the daemon or of the recording.
    if (this.scene.recording) this.origin = moments[0][0];
    else if (status?.alive) this.origin = status.started_ns * 1e-9;
    this.traces.begin(moments, this.origin);
    this.events(events);
    this.faults(faults);
    if (status) this.status(status);
  }

  picture(picture) {
    this.arrange("hands");
    this.newest = picture;
    if (!this.scene.recording) this.traces.add(picture);
  }

  events(events) {
    this.eventLines.add(events, this.origin);
    this.traces.happened(events);
  }

  faults(faults) {
    this.faultList.show(faults, this.origin);
  }

  arena(arena) {
    this.arrange("swarm");
    this.newestArena = arena;
    this.arenaView.take(arena);
  }

  /** Shows the sections of hands or swarm when their first data arrive. */
  arrange(what) {
    const shown = by("main").classList;
    if (shown.contains(what)) return;
    shown.add(what);
    by("arena").hidden = !shown.contains("swarm");
    const first = shown.contains("hands") ? "events" : "arena";
    by("skip").href = `#${first}`;
    by("skip").textContent = `Skip to the ${first}`;
    this.redraw();
  }

  /** Shows the state without a daemon: that of a swarm, if there is one. */
  absent() {
    const arena = this.newest ? null : this.newestArena;
    this.mode(arena ? "swarm" : "no daemon");
    this.sentence(arena ? this.arenaView.sentence() : this.reported.why);
    if (arena) by("where").textContent = `bus ${this.scene.bus} · field ${arena.preset}`;
  }

  status(status) {
    this.reported = status;
    if (!status.alive) return this.absent();
    this.arrange("hands");
    this.timing.show(status);
    const { goal, reason, mode } = status;
    const name = goal.task || goal.kind;
    const told = goal.goal_id ? [`goal ${name} ${goal.state}`, goal.step && `step ${goal.step}`, goal.reason?.sentence] : ["no goal yet"];
    const frozen = status.standstill_s && `no tick for ${status.standstill_s.toFixed(1)} s`;
    this.sentence([frozen, ...told, reason?.sentence].filter(Boolean).join(" · "));
    this.mode(mode);
    by("where").textContent = `bus ${this.scene.bus} · atasd ${status.version} · ${status.rate_hz} Hz` +
      (status.lockstep ? " · lock-step" : "") + (status.degraded ? " · DEGRADED" : "");
  }

  /** Writes the sentence about the goal; the header shows two lines of it, its tooltip everything. */
  sentence(text) {
    by("goal").textContent = by("goal").title = text;
  }

  mode(mode) {
    const shown = by("mode");
    if (shown.textContent === mode) return;
    shown.textContent = mode;
    shown.dataset.mode = mode;
  }

  /** Draws new data, once per screen frame. */
  draw() {
    requestAnimationFrame(() => this.draw());
    this.drawArena();
    const picture = this.newest;
    if (!picture) return;
    if (picture !== this.drawn) {
      this.drawn = picture;
      this.robot.show(picture, forces(picture, this.scene.layouts));
      this.fingers.draw(picture);
    }
    // Slow updates also run without a new picture, so that the last picture is shown completely.
    if (picture !== this.told && (performance.now() - this.toldAt > READABLE || this.scene.recording)) this.tell(picture);
    if (picture !== this.traced && (this.frames++ % SLOWLY === 0 || this.scene.recording)) {
      this.traced = picture;
      this.traces.draw(picture.t_s, !this.scene.recording);
    }
  }

  drawArena() {
    const arena = this.newestArena;
    if (!arena) return;
    if (arena !== this.drawnArena) {
      this.drawnArena = arena;
      this.arenaView.draw();
    }
    if (arena !== this.toldArena && performance.now() - this.arenaToldAt > READABLE) {
      this.toldArena = arena;
      this.arenaToldAt = performance.now();
      this.arenaView.tell();
      if (this.reported && !this.reported.alive) this.absent();
    }
  }

  tell(picture) {
    this.told = picture;
    this.toldAt = performance.now();
    this.fingers.tell(picture);
    by("tick").textContent = String(picture.tick);
    if (this.scene.recording) this.mode(picture.mode);
  }

  redraw() {
    this.drawn = this.traced = this.drawnArena = null;
    this.frames = 0;
    this.timing.draw();
    this.faultList.draw();
  }
}

async function begin() {
  const scene = await (await fetch("/scene.json")).json();
  const page = new Page(scene);
  if (!scene.recording) {
    new Controls();
    live(page);
    return;
  }
  // A recording has no controls and no service rates.
  by("controls").hidden = by("timing").hidden = true;
  by("main").classList.add("recorded");
  const recording = await (await fetch("/recording.json")).json();
  by("where").textContent = recording.name;
  page.sentence(recording.events.filter((event) => event.kind === "goal").at(-1)?.sentence ?? "");
  page.past({ moments: recording.moments, events: recording.events, faults: recording.faults });
  page.recorded = new Recorded(page, recording);
}

begin();
