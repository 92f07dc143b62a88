// Fingertips, closing axis and held object of each hand, in the base frame.

import { add, cross, dot, scale, sub, then, turn, unit } from "/geometry.js";

/** Force of a grasp side that counts as contact, N (the controller's default). */
const TOUCHED = 0.1;
/** Length of the closing axis beyond the fingertips, m. */
const BEYOND = 0.03;
/** Drawn extent of a held object across the closing axis, m: it is not measured. */
const ACROSS = 0.03;

/** Returns the tip frames of both hands for the poses of the links. */
export function tipFrames(scene, tips, places) {
  return tips.map((hand, side) => hand.flatMap((tip, finger) => {
    const frame = scene.tip_frames?.[side]?.[finger];
    if (tip < 0 || !frame) return [];
    return [{ ...then(places[tip], frame.at), side: frame.side, radius: frame.radius_m, finger }];
  }));
}

/** Returns the middle of each grasp side, or null without a fingertip on one. */
function sides(frames) {
  const middles = [0, 1].map((side) => {
    const own = frames.filter((frame) => frame.side === side);
    return own.length ? scale(own.reduce((sum, { xyz }) => add(sum, xyz), [0, 0, 0]), 1 / own.length) : null;
  });
  return middles.every(Boolean) ? middles : null;
}

/** Returns the ends of the closing axis, or null. */
export function closingAxis(frames) {
  const middles = sides(frames);
  if (!middles) return null;
  const along = unit(sub(middles[1], middles[0]));
  return [sub(middles[0], scale(along, BEYOND)), add(middles[1], scale(along, BEYOND))];
}

/**
 * Returns the held object as measured by the hand: a block between the sensing faces if both grasp sides touch, or null. Its width
 * is the distance between the faces; its other extents are not measured.
 */
export function heldObject(frames, fingers) {
  const middles = sides(frames);
  if (!middles) return null;
  const pressed = [0, 1].map((side) => frames.filter((frame) => frame.side === side)
    .reduce((sum, { finger }) => sum + (fingers[finger]?.normal_n ?? 0), 0));
  if (!pressed.every((force) => force >= TOUCHED)) return null;
  const along = unit(sub(middles[1], middles[0]));
  const faces = [0, 1].map((side) => {
    const own = frames.filter((frame) => frame.side === side);
    const reach = own.reduce((sum, { q, radius }) => sum + radius * Math.abs(dot(turn(q, [0, 0, 1]), along)), 0) / own.length;
    return add(middles[side], scale(along, side === 0 ? reach : -reach));
  });
  const width = dot(sub(faces[1], faces[0]), along);
  if (!(width > 0)) return null;
  return { width, middle: scale(add(...faces), 0.5), along, across: ACROSS };
}

/** Returns the corners of a held object and its faces, counter-clockwise from outside. */
export function block({ width, middle, along, across }) {
  const upright = Math.abs(along[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const second = unit(cross(along, upright));
  const third = cross(along, second);
  const points = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [[i & 1, along, width], [i & 2, second, across], [i & 4, third, across]]
    .reduce((point, [isFar, axis, extent]) => add(point, scale(axis, (isFar ? 0.5 : -0.5) * extent)), middle));
  return { points, faces: [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] };
}
