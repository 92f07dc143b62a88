// List of events, newest first, and of faults with the ticks before them.

import { begin, palette, number } from "/canvas.js";

/** Maximum number of events on the page. */
const LINES = 200;

export class Events {
  constructor(body) {
    this.body = body;
    this.seen = new Set();
  }

  clear() {
    this.body.replaceChildren();
    this.seen.clear();
  }

  /** Adds events, oldest first, and skips duplicates. Times are relative to `origin`, s. */
  add(events, origin) {
    for (const event of events) {
      const key = `${event.sequence}:${event.captured_ns}`;
      if (this.seen.has(key)) continue;
      this.seen.add(key);
      this.body.prepend(line(event, origin));
    }
    while (this.body.rows.length > LINES) this.body.deleteRow(-1);
  }
}

function line(event, origin) {
  const row = document.createElement("tr");
  row.className = severity(event);
  for (const text of [number(event.t_s - origin, 2), event.sentence, event.evidence ?? ""]) row.insertCell().textContent = text;
  return row;
}

function severity({ kind, mode, text }) {
  if (kind === "warning") return "warn";
  if (kind === "mode" && ["hold", "safe-stop", "fault"].includes(mode)) return "bad";
  return kind === "goal" && text === "failed" ? "bad" : "";
}

export class Faults {
  /** `fingers` returns the number of fingertips of each hand. */
  constructor(list, canvas, fingers) {
    this.list = list;
    this.canvas = canvas;
    this.fingers = fingers;
    this.show([]);
  }

  show(faults, origin = 0) {
    this.origin = origin;
    this.list.replaceChildren(...faults.map((fault) => this.item(fault)));
    if (!faults.length) this.list.append(Object.assign(document.createElement("li"), { textContent: "none" }));
  }

  item(fault) {
    const item = document.createElement("li");
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: `${number(fault.t_s - this.origin, 2)} s  ${fault.sentence}` });
    button.addEventListener("click", () => this.open(fault.number));
    item.append(button);
    return item;
  }

  async open(number) {
    const answer = await fetch(`/flight/${number}`);
    if (!answer.ok) return;
    this.flight = await answer.json();
    this.canvas.hidden = false;
    this.draw();
  }

  draw() {
    if (!this.flight) return;
    const { context, width, height } = begin(this.canvas);
    const colours = palette();
    const { before_ms: t, hands, late_us: late } = this.flight;
    if (!t.length) return;
    const x = (ms) => 34 + (1 - ms / t[0]) * (width - 44);
    const rows = [
      { top: 14, bottom: height * 0.55, label: "N", lines: hands.flatMap((hand, side) => hand.normal_n.slice(0, this.fingers()[side])), tints: ["a", "b", "c", "f"] },
      { top: height * 0.62, bottom: height - 16, label: "latency µs", lines: [late], tints: ["e"] },
    ];
    for (const { top, bottom, label, lines, tints } of rows) {
      const most = Math.max(...lines.flat(), 1e-3);
      context.fillStyle = colours.soft;
      context.fillText(`${label} ≤ ${number(most, 2)}`, 4, top - 2);
      lines.forEach((values, index) => {
        context.strokeStyle = colours[tints[index % tints.length]];
        context.lineWidth = 1.5;
        context.beginPath();
        values.forEach((value, at) => context.lineTo(x(t[at]), bottom - (value / most) * (bottom - top)));
        context.stroke();
      });
    }
    context.fillStyle = colours.soft;
    context.fillText(`${number(t[0], 0)} ms`, 34, height - 3);
    context.fillText("fault", width - 34, height - 3);
  }
}
