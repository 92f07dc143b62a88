// Vectors, quaternions (x, y, z, w), poses, and the link poses of the robot.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.sqrt(dot(a, a));
export const unit = (a) => scale(a, 1 / (length(a) || 1));

const times = ([ax, ay, az, aw], [bx, by, bz, bw]) => [
  aw * bx + ax * bw + ay * bz - az * by,
  aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw,
  aw * bw - ax * bx - ay * by - az * bz,
];

/** Rotates a vector by a quaternion. */
export function turn([x, y, z, w], v) {
  const t = scale(cross([x, y, z], v), 2);
  return add(add(v, scale(t, w)), cross([x, y, z], t));
}

/** Composes pose a with pose b, which is given in the frame of a. */
export const then = (a, b) => ({ xyz: add(a.xyz, turn(a.q, b.xyz)), q: times(a.q, b.q) });

const aboutAxis = (axis, angle) => [...scale(axis, Math.sin(angle / 2)), Math.cos(angle / 2)];

/** Returns the pose of each link in the base frame. */
export function placed(limbs, joints) {
  const places = [];
  for (const limb of limbs) {
    const value = limb.joint === null ? 0 : limb.ratio * (joints[limb.joint] ?? 0) + limb.offset;
    const moved = limb.slides
      ? { xyz: scale(limb.axis, value), q: [0, 0, 0, 1] }
      : { xyz: [0, 0, 0], q: aboutAxis(limb.axis, value) };
    const own = then(limb.at, moved);
    places.push(limb.parent === null ? own : then(places[limb.parent], own));
  }
  return places;
}

/** A camera that orbits a point. */
export class Camera {
  constructor() {
    this.at = [0.2, -0.02, 0.2];
    this.azimuth = 0.62;
    this.height = 0.42;
    this.distance = 1.12;
  }

  /** Sets up the projection for a picture size. */
  aim(width, height) {
    const [ca, sa, ch, sh] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.height), Math.sin(this.height)];
    this.back = [ca * ch, sa * ch, sh];
    this.right = [-sa, ca, 0];
    this.up = cross(this.back, this.right);
    this.eye = add(this.at, scale(this.back, this.distance));
    this.focal = 1.15 * Math.min(width * 0.9, height);
    this.middle = [width / 2, height / 2];
  }

  /** Projects a point: screen x and y, depth, scale. */
  seen(point) {
    const from = sub(point, this.eye);
    const depth = Math.max(-dot(from, this.back), 0.05);
    const by = this.focal / depth;
    return [this.middle[0] + dot(from, this.right) * by, this.middle[1] - dot(from, this.up) * by, depth, by];
  }
}
