// 3D view of the robot: the shapes of its URDF, sorted by depth, lines for links without shapes, fingertips with their forces, closing
// axes and held objects.

import { begin, arrow, palette, number } from "/canvas.js";
import { Camera, add, cross, dot, length, placed, scale, sub, then, turn, unit } from "/geometry.js";
import { block, closingAxis, heldObject, tipFrames } from "/hand.js";

const SIDES = 12;
const LIGHT = unit([0.4, -0.5, 0.9]);
/** Arrow length per newton, m. */
const PER_NEWTON = 0.03;
/** Minimum camera distance, m, and its ratio to the size of the robot. */
const NEAREST = 0.5;
const AROUND = 1.4;
const TABLE = { from: [0.05, -0.45], to: [0.65, 0.45], step: 0.1 };
/** Width of a link without shapes, m. */
const STICK = 0.008;
/** Growth of a fingertip over its link's shape of equal size, so that it is seen. */
const GROWTH = 1.04;
const FINGERTIP = [0, 0.62, 0.45, 1];
const STICKS = [0.65, 0.65, 0.68, 1];
const OBJECT = [0.34, 0.71, 0.91, 1];

export class Robot {
  constructor(canvas) {
    this.canvas = canvas;
    this.camera = new Camera();
    this.listen();
  }

  /** Sets the robot; a scene without links draws nothing. */
  take(scene) {
    this.scene = scene;
    this.joints = this.forces = null;
    this.isFramed = false;
    this.shapes = scene.limbs.flatMap((limb, index) => limb.shapes.map((shape) => ({ index, ...shape, mesh: mesh(shape.form) })));
    this.tips = scene.tips.map((hand) => hand.map((name) => scene.limbs.findIndex((limb) => limb.name === name)));
    this.draw();
  }

  /** Fits the camera to the robot in its first pose. */
  frame(places) {
    this.isFramed = true;
    const points = places.map(({ xyz }) => xyz);
    const ends = [Math.min, Math.max].map((end) => [0, 1, 2].map((axis) => end(...points.map((point) => point[axis]))));
    this.camera.at = scale(add(...ends), 0.5);
    this.camera.distance = Math.max(NEAREST, AROUND * length(sub(ends[1], ends[0])));
  }

  listen() {
    const { canvas, camera } = this;
    let held = null;
    const turned = (x, y) => {
      camera.azimuth -= x;
      camera.height = Math.min(1.5, Math.max(-0.2, camera.height + y));
      this.draw();
    };
    const zoomed = (by) => {
      camera.distance = Math.min(6, Math.max(0.25, camera.distance * by));
      this.draw();
    };
    canvas.addEventListener("pointerdown", (event) => {
      held = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      turned((event.clientX - held[0]) * 0.008, (event.clientY - held[1]) * 0.008);
      held = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointerup", () => { held = null; });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoomed(Math.exp(event.deltaY * 0.001));
    }, { passive: false });
    const keys = {
      ArrowLeft: () => turned(0.1, 0), ArrowRight: () => turned(-0.1, 0),
      ArrowUp: () => turned(0, 0.1), ArrowDown: () => turned(0, -0.1),
      "+": () => zoomed(0.9), "=": () => zoomed(0.9), "-": () => zoomed(1.1),
    };
    canvas.addEventListener("keydown", (event) => {
      if (!keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    });
  }

  show(picture, forces) {
    this.joints = picture.q;
    this.hands = picture.hands;
    this.forces = forces;
    this.draw();
  }

  draw() {
    const { context, width, height } = begin(this.canvas);
    const colours = palette();
    this.camera.aim(width, height);
    this.drawTable(context, colours);
    const missing = !this.scene.limbs.length ? "" : !this.joints?.length ? "no joint state yet" : null;
    if (missing !== null) {
      context.fillStyle = colours.soft;
      context.fillText(missing, 12, 20);
      return;
    }
    const places = placed(this.scene.limbs, this.joints);
    if (!this.isFramed) {
      this.frame(places);
      return this.draw();
    }
    const frames = tipFrames(this.scene, this.tips, places);
    const objects = frames.map((hand, side) => heldObject(hand, this.hands?.[side]?.fingers ?? []));
    const faces = [
      ...this.shapes.flatMap((shape) => this.faces(shape, then(places[shape.index], shape.at))),
      ...this.sticks(places),
      ...frames.flat().map(({ xyz, radius }) => this.ball(xyz, radius * GROWTH, FINGERTIP)),
      ...objects.filter(Boolean).flatMap((object) => this.facesOf(block(object), OBJECT)),
    ];
    faces.sort((a, b) => b.depth - a.depth);
    for (const face of faces) paint(context, face);
    this.drawAxes(context, colours, frames, objects);
    this.drawForces(context, colours, frames);
    context.fillStyle = colours.soft;
    context.fillText("grid 100 mm", 8, height - 8);
  }

  /** Draws closing axes, and the measured width of held objects. */
  drawAxes(context, colours, frames, objects) {
    context.strokeStyle = colours.e;
    context.lineWidth = 1.5;
    context.setLineDash([5, 4]);
    for (const axis of frames.map(closingAxis).filter(Boolean)) {
      context.beginPath();
      for (const end of axis) context.lineTo(...this.camera.seen(end).slice(0, 2));
      context.stroke();
    }
    context.setLineDash([]);
    context.fillStyle = colours.ink;
    for (const object of objects.filter(Boolean)) {
      const [x, y] = this.camera.seen(add(object.middle, [0, 0, -object.across]));
      const text = `object ${number(object.width * 1e3, 0)} mm`;
      context.fillText(text, x - context.measureText(text).width / 2, y + 22);
    }
  }

  /** Returns lines from parent links to links without shapes. */
  sticks(places) {
    return this.scene.limbs.flatMap((limb, index) => {
      if (limb.parent === null || limb.shapes.length) return [];
      const [a, b] = [this.camera.seen(places[limb.parent].xyz), this.camera.seen(places[index].xyz)];
      return [{ line: [a, b], width: STICK * (a[3] + b[3]) / 2, depth: (a[2] + b[2]) / 2, rgba: STICKS }];
    });
  }

  ball(xyz, radius, rgba) {
    const [x, y, depth, by] = this.camera.seen(xyz);
    return { ball: [x, y, radius * by], depth: depth - radius, rgba };
  }

  drawTable(context, colours) {
    context.strokeStyle = colours.line;
    context.lineWidth = 1;
    const { from, to, step } = TABLE;
    const lineTo = (a, b) => {
      const [p, q] = [this.camera.seen(a), this.camera.seen(b)];
      context.beginPath();
      context.moveTo(p[0], p[1]);
      context.lineTo(q[0], q[1]);
      context.stroke();
    };
    for (let x = from[0]; x <= to[0] + 1e-9; x += step) lineTo([x, from[1], 0], [x, to[1], 0]);
    for (let y = from[1]; y <= to[1] + 1e-9; y += step) lineTo([from[0], y, 0], [to[0], y, 0]);
  }

  faces(shape, place) {
    if (shape.mesh.radius) return [this.ball(place.xyz, shape.mesh.radius, shape.rgba)];
    const points = shape.mesh.points.map((point) => add(place.xyz, turn(place.q, point)));
    return this.facesOf({ points, faces: shape.mesh.faces }, shape.rgba);
  }

  /** Returns the faces that the camera sees, with their brightness. */
  facesOf({ points, faces: all }, rgba) {
    const { camera } = this;
    const seen = points.map((point) => camera.seen(point));
    const faces = [];
    for (const corners of all) {
      const [a, b, c] = corners.map((index) => points[index]);
      const normal = unit(cross(sub(b, a), sub(c, a)));
      if (dot(normal, sub(camera.eye, a)) <= 0) continue;
      const depth = corners.reduce((sum, index) => sum + seen[index][2], 0) / corners.length;
      faces.push({ corners: corners.map((index) => seen[index]), depth, rgba, light: 0.55 + 0.45 * Math.max(0, dot(normal, LIGHT)) });
    }
    return faces;
  }

  drawForces(context, colours, frames) {
    context.strokeStyle = context.fillStyle = colours.e;
    context.lineWidth = 3;
    context.font = "600 12px system-ui, sans-serif";
    frames.forEach((hand, side) => hand.forEach(({ xyz: from, q: orientation, finger }) => {
      const force = this.forces?.[side]?.[finger];
      if (!force) return;
      const newtons = length(force);
      if (newtons < 0.2) return;
      const along = turn(orientation, force);
      const to = add(from, scale(along, PER_NEWTON * Math.min(1, 4 / newtons)));
      const [p, q] = [this.camera.seen(from), this.camera.seen(to)];
      arrow(context, p, q, 7);
      context.fillText(`${number(newtons, 1)} N`, q[0] + 6, q[1] - 4);
    }));
  }
}

function paint(context, face) {
  const [r, g, b] = face.rgba.map((part) => part * 255);
  if (face.line) {
    context.strokeStyle = `rgb(${r}, ${g}, ${b})`;
    context.lineWidth = face.width;
    context.lineCap = "round";
    context.beginPath();
    for (const [x, y] of face.line) context.lineTo(x, y);
    context.stroke();
    context.lineCap = "butt";
    return;
  }
  if (face.ball) {
    const [x, y, radius] = face.ball;
    const shade = context.createRadialGradient(x - radius * 0.35, y - radius * 0.4, radius * 0.1, x, y, radius);
    shade.addColorStop(0, `rgb(${r * 0.6 + 102}, ${g * 0.6 + 102}, ${b * 0.6 + 102})`);
    shade.addColorStop(1, `rgb(${r * 0.6}, ${g * 0.6}, ${b * 0.6})`);
    context.fillStyle = shade;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fill();
    return;
  }
  const fill = `rgb(${r * face.light}, ${g * face.light}, ${b * face.light})`;
  context.fillStyle = context.strokeStyle = fill;
  context.lineWidth = 0.7;
  context.beginPath();
  for (const [x, y] of face.corners) context.lineTo(x, y);
  context.closePath();
  context.fill();
  // Closes gaps between adjacent faces.
  context.stroke();
}

/** Returns points and faces of a shape, counter-clockwise from outside. */
function mesh(form) {
  if (form.mesh) return form.mesh;
  if (form.sphere) return { radius: form.sphere };
  if (form.box) {
    const [x, y, z] = form.box.map((size) => size / 2);
    const points = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z]);
    return { points, faces: [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] };
  }
  const [radius, full] = form.cylinder;
  const points = [];
  const faces = [];
  for (let i = 0; i < SIDES; i++) {
    const angle = (2 * Math.PI * i) / SIDES;
    const [x, y] = [radius * Math.cos(angle), radius * Math.sin(angle)];
    points.push([x, y, -full / 2], [x, y, full / 2]);
    const [a, b] = [2 * i, 2 * ((i + 1) % SIDES)];
    faces.push([a, b, b + 1, a + 1]);
  }
  const ring = [...Array(SIDES).keys()];
  faces.push(ring.map((i) => 2 * i + 1), ring.map((i) => 2 * (SIDES - 1 - i)));
  return { points, faces };
}
