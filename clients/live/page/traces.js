// Plots per hand over the last seconds: forces with their limits, and a lane per module.

import { begin, palette } from "/canvas.js";

const HANDS = ["left", "right"];
/** Displayed time span, s. */
const WINDOW = 20;
const LEFT = 118;
const RIGHT = 8;
const LANE = 15;
/** Fingertip slots of a sample, and its values per hand: f1, f2, modules, then F_n and F_t of each fingertip. */
const FINGERS = 4;
const PER_HAND = 3 + 2 * FINGERS;
const LIMITS = [
  { of: (m) => m[0], name: "F_1", colour: "d", dash: [5, 4], width: 1.5 },
  { of: (m) => m[1], name: "F_2", colour: "e", dash: [5, 4], width: 1.5 },
];
/** Colours and line widths of the fingertips; later lines are drawn on top and thinner. */
const TINTS = ["a", "b", "f", "ink"];
const WIDTHS = [2.8, 1.6, 1.4, 1.2];

/** Force that counts as contact, N (the controller's default). */
const TOUCHED = 0.1;

const normals = (m, fingers) => [...Array(fingers).keys()].map((finger) => m[3 + 2 * finger]);

/** Returns the plot lines of a hand by its number of fingertips. */
function linesOf(fingers) {
  const each = [...Array(fingers).keys()];
  const mean = (m) => each.reduce((sum, finger) => sum + m[4 + 2 * finger], 0) / fingers;
  return [
    ...LIMITS,
    { of: mean, name: "F_t mean", colour: "c", dash: [], width: 1.8 },
    ...each.map((finger) => ({ of: (m) => m[3 + 2 * finger], name: `F_n finger ${finger + 1}`, colour: TINTS[finger], dash: [], width: WIDTHS[finger] })),
  ];
}

export class Traces {
  constructor(parent, legend) {
    this.parent = parent;
    this.legend = legend;
    this.moments = [];
    this.steps = [];
    this.origin = 0;
  }

  /** Creates a panel for each hand of the robot. */
  take(scene) {
    this.modules = scene.modules;
    this.parent.replaceChildren();
    const there = HANDS.map((_, hand) => hand).filter((hand) => scene.fingers[hand] > 0);
    this.working = null;
    this.panels = there.map((hand) => {
      const canvas = document.createElement("canvas");
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `Forces and active modules of the ${HANDS[hand]} hand over the last ${WINDOW} seconds`);
      this.parent.append(canvas);
      return { canvas, hand, fingers: scene.fingers[hand], lines: linesOf(scene.fingers[hand]) };
    });
    const most = Math.max(0, ...scene.fingers);
    this.legend.replaceChildren(...(most ? linesOf(most) : []).map(({ name, colour, dash }) => {
      const entry = document.createElement("span");
      const mark = document.createElement("i");
      mark.className = `${colour}${dash.length ? " dash" : ""}`;
      entry.append(mark, name);
      return entry;
    }));
  }

  /** Sets the history. */
  begin(moments, origin) {
    this.moments = moments;
    this.origin = origin;
  }

  /** Adds the sample of a picture. */
  add(picture) {
    const last = this.moments.at(-1);
    if (last && picture.t_s <= last[0]) this.moments = [];
    const hand = ({ f1_n, f2_n, modules, fingers }) => {
      const felt = fingers.flatMap((f) => [f.normal_n, f.tangential_n]);
      return [f1_n, f2_n, modules, ...felt, ...Array(2 * FINGERS - felt.length).fill(0)];
    };
    this.moments.push([picture.t_s, ...picture.hands.flatMap(hand)]);
    if (this.moments.length > 4000) this.moments.splice(0, 1000);
  }

  /** Adds task steps as markers. */
  happened(events) {
    for (const event of events) if (event.kind === "step") this.steps.push(event);
    if (this.steps.length > 400) this.steps.splice(0, 100);
  }

  /** Draws the time span before `until`, s. */
  draw(until, isLive) {
    const shown = { from: until - WINDOW, until, isLive };
    const first = lowerBound(this.moments, shown.from);
    const last = lowerBound(this.moments, until + 1e-6);
    const moments = this.moments.slice(Math.max(0, first - 1), last);
    this.arrange(moments.at(-1));
    for (const panel of this.panels) this.drawHand(panel, moments, shown);
  }

  /** Puts the chart of the working hand first: the last one that had an active module or a contact. */
  arrange(moment) {
    if (!moment || this.panels.length < 2) return;
    const works = ({ hand, fingers }) => {
      const values = moment.slice(1 + hand * PER_HAND, 1 + (hand + 1) * PER_HAND);
      return values[2] !== 0 || normals(values, fingers).some((force) => force >= TOUCHED);
    };
    const working = this.panels.filter(works);
    if (working.length !== 1 || working[0] === this.working) return;
    this.working = working[0];
    for (const panel of this.panels) panel.canvas.classList.toggle("working", panel === this.working);
  }

  drawHand({ canvas, hand, fingers, lines }, moments, shown) {
    const { context, width, height } = begin(canvas);
    const colours = palette();
    const of = (moment) => moment.slice(1 + hand * PER_HAND, 1 + (hand + 1) * PER_HAND);
    const samples = moments.map((moment) => [moment[0], of(moment)]);
    const lanes = this.lanes(samples);
    const bottom = height - 16 - LANE * Math.max(lanes.length, 1);
    const x = (t) => LEFT + ((t - shown.from) / (shown.until - shown.from)) * (width - LEFT - RIGHT);
    const highest = samples.reduce((most, [, m]) => Math.max(most, m[1] < 100 ? m[1] : 0, ...normals(m, fingers)), 0.5) * 1.12;
    const y = (n) => bottom - 6 - (n / highest) * (bottom - 26);
    this.drawGrid(context, colours, { hand, width, bottom, height, highest, x, y, shown });
    context.save();
    context.beginPath();
    context.rect(LEFT, 0, width - LEFT - RIGHT, height);
    context.clip();
    this.drawSteps(context, colours, hand, x, bottom, shown);
    for (const line of lines) {
      context.strokeStyle = colours[line.colour];
      context.lineWidth = line.width;
      context.setLineDash(line.dash);
      context.beginPath();
      for (const [t, m] of samples) {
        const value = line.of(m);
        if (Number.isFinite(value)) context.lineTo(x(t), y(value));
      }
      context.stroke();
    }
    context.setLineDash([]);
    context.restore();
    this.drawLanes(context, colours, lanes, samples, x, bottom, width);
  }

  drawGrid(context, colours, { hand, width, bottom, height, highest, x, y, shown }) {
    context.fillStyle = colours.ink;
    context.font = "600 12px system-ui, sans-serif";
    context.fillText(`${HANDS[hand]} hand`, 4, 14);
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = colours.soft;
    context.fillText("N", LEFT - 16, 14);
    context.strokeStyle = colours.line;
    context.lineWidth = 1;
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10].find((s) => highest / s <= 5) ?? 20;
    for (let n = 0; n <= highest; n += step) {
      context.beginPath();
      context.moveTo(LEFT, y(n));
      context.lineTo(width - RIGHT, y(n));
      context.stroke();
      context.fillText(String(Math.round(n * 10) / 10), LEFT - 26, y(n) + 4);
    }
    for (let ago = 0; ago <= WINDOW; ago += 5) {
      const at = shown.until - this.origin - ago;
      // No labels before the start of a recording.
      if (!shown.isLive && at < 0) break;
      const label = shown.isLive ? (ago ? `−${ago} s` : "now") : `${at.toFixed(1)} s`;
      context.fillText(label, Math.min(x(shown.until - ago), width - RIGHT - 34), height - 4);
    }
  }

  drawSteps(context, colours, hand, x, bottom, shown) {
    context.fillStyle = colours.soft;
    context.strokeStyle = colours.line;
    let free = -Infinity;
    const steps = this.steps.filter((event) => event.hand === HANDS[hand] && event.t_s < shown.until);
    steps.forEach((event, index) => {
      if ((steps[index + 1]?.t_s ?? Infinity) < shown.from) return;
      const at = Math.max(x(event.t_s), LEFT);
      context.beginPath();
      context.moveTo(at, 18);
      context.lineTo(at, bottom);
      context.stroke();
      if (at < free) return;
      context.fillText(event.text, at + 3, 14);
      free = at + 10 + context.measureText(event.text).width;
    });
  }

  /** Returns the modules active in the displayed samples. */
  lanes(samples) {
    const ever = samples.reduce((bits, [, m]) => bits | m[2], 0);
    return this.modules.filter(({ id }) => (ever >>> id) & 1);
  }

  drawLanes(context, colours, lanes, samples, x, bottom, width) {
    const tints = ["a", "e", "f", "d", "c", "b"];
    lanes.forEach(({ id, name }, index) => {
      const top = bottom + index * LANE;
      context.fillStyle = colours.ink;
      context.fillText(name.replace(/^module /, ""), 4, top + 11, LEFT - 10);
      context.fillStyle = colours.line;
      context.fillRect(LEFT, top + 7, width - LEFT - RIGHT, 1);
      context.fillStyle = colours[tints[id % tints.length]];
      let since = null;
      samples.forEach(([t, m], at) => {
        const active = (m[2] >>> id) & 1;
        if (active && since === null) since = t;
        if (since !== null && (!active || at === samples.length - 1)) {
          const from = Math.max(x(since), LEFT);
          context.fillRect(from, top + 2, Math.max(2, x(t) - from), LANE - 5);
          since = null;
        }
      });
    });
  }
}

function lowerBound(moments, t) {
  let [low, high] = [0, moments.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (moments[middle][0] < t) low = middle + 1;
    else high = middle;
  }
  return low;
}
