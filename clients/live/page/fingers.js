// The fingertips: each element as a dot coloured by normal force, with an arrow for its shear force.

import { arrow, begin, number, palette } from "/canvas.js";
import { add, scale } from "/geometry.js";

const HANDS = ["left", "right"];
/** Cividis: readable with any colour vision (Nunez, Anderton and Renslow 2018). */
const RAMP = [[0, 34, 78], [53, 69, 108], [102, 105, 112], [148, 142, 119], [200, 184, 102], [254, 232, 56]];
/** Minimum force of full colour, N, and decay factor of the colour scale per picture. */
const LEAST = 0.05;
const FORGET = 0.995;

export class Fingers {
  constructor(parent, scale, scene) {
    this.scale = scale;
    this.layouts = scene.layouts;
    this.full = LEAST;
    const most = Math.max(2, ...scene.fingers);
    parent.replaceChildren();
    parent.dataset.columns = most;
    this.tips = HANDS.map((hand, side) => [...Array(scene.fingers[side]).keys()].map((finger) => tip(parent, hand, finger + 1)));
  }

  /** Writes all numbers of one picture. */
  tell(picture) {
    this.each(picture, (tip, finger) => {
      tip.normal.textContent = number(finger.normal_n, 2);
      tip.tangential.textContent = number(finger.tangential_n, 2);
      tip.utilisation.textContent = number(finger.utilisation, 2);
    });
    this.scale.textContent = `brightest ${number(this.full, 2)} N; arrows: shear; S: friction utilisation, 1 is slip`;
  }

  draw(picture) {
    let largest = LEAST;
    this.each(picture, (_, finger) => {
      for (const force of finger.elements) if (force) largest = Math.max(largest, force[0]);
    });
    this.full = Math.max(largest, this.full * FORGET);
    this.each(picture, (tip, finger, hand) => this.drawTip(tip.canvas, finger.elements, this.layouts[hand]));
  }

  each(picture, act) {
    this.tips.forEach((tips, hand) => tips.forEach((tip, finger) => {
      const felt = picture.hands[hand].fingers[finger];
      if (felt) act(tip, felt, hand);
    }));
  }

  drawTip(canvas, elements, layout) {
    const { context, width, height } = begin(canvas);
    const colours = palette();
    if (!elements.length || elements.length !== layout.normal.length) {
      context.fillStyle = colours.soft;
      context.fillText(elements.length ? "layout mismatch" : "no frame yet", 8, 18);
      return;
    }
    // View from outside with the hand hanging: up is −x of the tip frame, right is y.
    const spread = Math.max(0.0045, ...layout.position_m.map(([x, y]) => Math.hypot(x, y)));
    const size = Math.min(width, height) / 2 - 10;
    const middle = [width / 2, height / 2];
    const at = ([x, y]) => [middle[0] + (y / spread) * size, middle[1] + (x / spread) * size];
    const dot = Math.max(3, Math.min(16, size / Math.sqrt(elements.length) / 1.15));
    elements.forEach((force, index) => {
      const [x, y] = at(layout.position_m[index]);
      context.beginPath();
      context.arc(x, y, dot, 0, 2 * Math.PI);
      context.strokeStyle = colours.line;
      context.lineWidth = 1;
      context.stroke();
      if (!force) return;
      const share = Math.min(1, Math.max(0, force[0] / this.full));
      context.fillStyle = ramp(share);
      if (share > 0.01) context.fill();
    });
    context.strokeStyle = context.fillStyle = colours.e;
    context.lineWidth = 1.6;
    elements.forEach((force, index) => {
      if (!force) return;
      const shear = add(scale(layout.tangent1[index], force[1]), scale(layout.tangent2[index], force[2]));
      const from = at(layout.position_m[index]);
      const by = (1.6 * dot) / (0.4 * this.full);
      arrow(context, from, [from[0] + shear[1] * by, from[1] + shear[0] * by], 3.5);
    });
  }
}

/** Creates the display of a fingertip. */
function tip(parent, hand, finger) {
  const figure = document.createElement("figure");
  const name = `${hand} finger ${finger}`;
  const number = (what) => `<b id="${hand}-${finger}-${what}">–</b>`;
  figure.innerHTML = `<figcaption>${name} <span>F_n ${number("normal")} N, F_t ${number("tangential")} N, S ${number("utilisation")}</span></figcaption>`;
  const canvas = document.createElement("canvas");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `Normal and shear force on the elements of ${name}`);
  figure.prepend(canvas);
  parent.append(figure);
  const text = (what) => document.getElementById(`${hand}-${finger}-${what}`);
  return { canvas, normal: text("normal"), tangential: text("tangential"), utilisation: text("utilisation") };
}

/** Returns the total force on each fingertip in its tip frame, N. */
export function forces(picture, layouts) {
  return picture.hands.map((hand, side) => hand.fingers.map(({ elements }) => {
    const { normal, tangent1, tangent2 } = layouts[side];
    return elements.reduce((sum, force, index) => {
      if (!force || !normal[index]) return sum;
      const [n, t1, t2] = force;
      return add(sum, add(scale(normal[index], -n), add(scale(tangent1[index], t1), scale(tangent2[index], t2))));
    }, [0, 0, 0]);
  }));
}

function ramp(share) {
  const place = share * (RAMP.length - 1);
  const index = Math.min(RAMP.length - 2, Math.floor(place));
  const mixed = RAMP[index].map((low, part) => low + (RAMP[index + 1][part] - low) * (place - index));
  return `rgba(${mixed.map(Math.round).join(",")}, ${0.25 + 0.75 * Math.min(1, share * 3)})`;
}
