// Histogram of tick timing, and the rate of each service.

import { begin, palette, number } from "/canvas.js";

export class Timing {
  constructor(canvas, body) {
    this.canvas = canvas;
    this.body = body;
    this.before = null;
  }

  show(status) {
    this.status = status;
    this.draw();
    const rows = services(status, this.before);
    this.before = status;
    this.body.replaceChildren(...rows.map((cells) => {
      const row = document.createElement("tr");
      for (const text of cells) row.insertCell().textContent = text;
      return row;
    }));
  }

  draw() {
    if (!this.status?.histogram) return;
    const { context, width, height } = begin(this.canvas);
    const colours = palette();
    const { edges_us: edges, wake, body } = this.status.histogram;
    const most = Math.log1p(Math.max(...wake, ...body, 1));
    const bin = (width - 8) / wake.length;
    const floor = height - 16;
    wake.forEach((count, index) => {
      const bar = (value, by, colour) => {
        const tall = (Math.log1p(value) / most) * (floor - 4);
        context.fillStyle = colours[colour];
        context.fillRect(4 + index * bin + by * bin, floor - tall, bin * 0.42, tall);
      };
      bar(count, 0.06, "a");
      bar(body[index], 0.5, "e");
      context.fillStyle = colours.soft;
      const edge = edges[index];
      const label = edge === undefined ? "" : edge < 1000 ? `${edge}` : `${edge / 1000}m`;
      context.fillText(label, 4 + (index + 1) * bin - context.measureText(label).width / 2, height - 3);
    });
  }
}

function services(now, before) {
  const seconds = before ? (now.captured_ns - before.captured_ns) * 1e-9 : 0;
  const rate = (count, counted) => (seconds > 0 && before?.pid === now.pid ? number((count - counted) / seconds, 0) : "–");
  const age = (ns) => (ns === null ? "–" : number(ns * 1e-6, 1));
  const hands = now.hands.map((hand, index) => [
    `frames, ${hand.hand} hand`, rate(hand.frames, before?.hands[index].frames), age(hand.age_ns), String(hand.lost),
  ]);
  return [
    ...hands,
    ["joint states", rate(now.joints.states, before?.joints.states), age(now.joints.age_ns), String(now.joints.lost)],
    ["ticks", rate(now.ticks, before?.ticks), "–", `${now.missed_ticks} missed`],
    ["wake-up latency, p99 µs", "", number(now.wake.p99_ns * 1e-3, 1), ""],
    ["tick body, p99 µs", "", number(now.tick.p99_ns * 1e-3, 1), ""],
  ];
}
