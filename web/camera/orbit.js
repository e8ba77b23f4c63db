// The mathematics of a camera that is moved by hand: {eye, target, up, yfov_deg} as the job document
// has it. Every function gives a new camera. Angles in radians, lengths in scene units.

const POLE = 0.02; // radians: how near the view may come to `up`
const FOV_MIN = 1, FOV_MAX = 150;

const add = (a, b) => a.map((v, i) => v + b[i]);
const sub = (a, b) => a.map((v, i) => v - b[i]);
const scale = (a, f) => a.map((v) => v * f);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const unit = (a) => scale(a, 1 / length(a));

// Rodrigues: v turned about a unit axis.
function turned(v, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(scale(v, c), scale(cross(axis, v), s)), scale(axis, dot(axis, v) * (1 - c)));
}

// {forward, right, up, distance}: unit vectors, right-handed, and how far the target is.
export function basis({ eye, target, up }) {
  const view = sub(target, eye), forward = unit(view), right = unit(cross(forward, up));
  return { forward, right, up: cross(right, forward), distance: length(view) };
}

// Goes around the target: `right` about the axis up, `over` above or below it. Stops before the poles,
// where right and left would change places.
export function orbit(camera, right, over) {
  const axis = unit(camera.up), away = sub(camera.eye, camera.target);
  const level = turned(away, axis, right), side = unit(cross(axis, level));
  const polar = Math.acos(Math.max(-1, Math.min(1, dot(unit(level), axis))));
  const next = Math.max(POLE, Math.min(Math.PI - POLE, polar - over));
  return { ...camera, eye: add(camera.target, turned(level, side, next - polar)) };
}

// Moves eye and target along the picture: so far, in heights of the picture at the target's distance.
export function pan(camera, right, over) {
  const b = basis(camera), height = 2 * b.distance * Math.tan(camera.yfov_deg * Math.PI / 360);
  const by = add(scale(b.right, right * height), scale(b.up, over * height));
  return { ...camera, eye: add(camera.eye, by), target: add(camera.target, by) };
}

// Brings the eye to `factor` times its distance from the target.
export function dolly(camera, factor) {
  const away = sub(camera.eye, camera.target), least = 1e-5 * (1e-3 + length(camera.target));
  return { ...camera, eye: add(camera.target, scale(away, Math.max(factor, least / length(away)))) };
}

export function zoom(camera, factor) {
  const half = Math.atan(Math.tan(camera.yfov_deg * Math.PI / 360) * factor);
  return { ...camera, yfov_deg: Math.max(FOV_MIN, Math.min(FOV_MAX, half * 360 / Math.PI)) };
}

// The camera that looks as the plan's does, {eye, forward, up, yfov_deg}, at a target so far away. The
// world's up is kept where the horizon is level.
export function cameraOf({ eye, forward, up, yfov_deg }, distance) {
  const right = cross(forward, up), level = Math.abs(right[1]) < 1e-4 && Math.abs(forward[1]) < 0.999 && up[1] > 0;
  return { eye: [...eye], target: add(eye, scale(forward, distance)), up: level ? [0, 1, 0] : [...up], yfov_deg };
}

// How far along the view lies what is `depth` away along the ray through the middle of pixel (x, y).
export function distanceAlongView(depth, x, y, { width, height }, yfov_deg) {
  const tall = Math.tan(yfov_deg * Math.PI / 360), wide = tall * width / height;
  return depth / Math.hypot(1, ((x + 0.5) / width * 2 - 1) * wide, ((y + 0.5) / height * 2 - 1) * tall);
}

// The ray {eye, along} through a point of the picture, in pixels.
export function rayThrough(camera, { x, y }, { width, height }) {
  const { forward, right, up } = basis(camera), tall = Math.tan(camera.yfov_deg * Math.PI / 360), wide = tall * width / height;
  return { eye: camera.eye, along: add(forward, add(scale(right, (x / width * 2 - 1) * wide), scale(up, (1 - y / height * 2) * tall))) };
}

// Where a ray meets the level y; null where it does not, or so far away that a pixel is a leap.
export function dropOnLevel({ eye, along }, y) {
  const t = (y - eye[1]) / along[1];
  return t > 0 && Math.abs(along[1]) > 0.01 * length(along) ? add(eye, scale(along, t)) : null;
}

// The first of some boxes {lowest, highest} that a ray meets; null: none.
export function nearestBox({ eye, along }, boxes) {
  let best = null, nearest = Infinity;
  for (const box of boxes) {
    const ends = eye.map((v, i) => [box.lowest[i], box.highest[i]].map((side) => (side - v) / along[i]).sort((a, b) => a - b));
    const from = Math.max(0, ...ends.map(([near]) => near)), to = Math.min(...ends.map(([, far]) => far));
    if (from <= to && from < nearest) { best = box; nearest = from; }
  }
  return best;
}

// The numbers that the server keeps are floats: as short as they can be told apart.
export function shortest(v) {
  const float = Math.fround(v);
  for (let digits = 1; digits < 9; digits++) {
    const text = Number(float.toPrecision(digits));
    if (Math.fround(text) === float) return text;
  }
  return Number(float.toPrecision(9));
}

export const rounded = ({ eye, target, up, yfov_deg }) =>
  ({ eye: eye.map(shortest), target: target.map(shortest), up: up.map(shortest), yfov_deg: shortest(yfov_deg) });
