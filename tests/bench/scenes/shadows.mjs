// Soft shadows: pure Lambert, lit by rectangles alone, so that light fields cover them. The shapes
// are made here (CC0); gazebo and fence are not shipped.
import { readFileSync } from "node:fs";
import { join as path } from "node:path";
import { glbOf, lambertOf } from "./glb.mjs";
import { light } from "./light.mjs";
import { box, floor, hills, join, quad, sphere, stick } from "./mesh.mjs";

const GREY = [0.6, 0.6, 0.6], SAND = [0.7, 0.62, 0.5], RED = [0.7, 0.25, 0.2], BLUE = [0.25, 0.35, 0.65];

const row = (count, make) => join(Array.from({ length: count }, (_, i) => make(i)));

// Occluders at all heights above a floor with a ball as a second receiver: contact, thin and wide
// penumbrae side by side.
function medley() {
  const sticks = [
    [[0.2, 0, 2.4], [0.2, 2, 2.4], 0.04], [[-0.6, 0.5, 3.4], [1.6, 0.5, 3.6], 0.04],
    [[-0.6, 1, 1], [1.2, 1, 1.4], 0.04], [[-1.5, 2, -1.2], [0.6, 2, -0.2], 0.05],
    [[-4.5, 0.15, 3.5], [-2.5, 0.15, 4.2], 0.05], [[-4.5, 0, 2.2], [-3.6, 3.2, 1.2], 0.05],
    [[-5.2, 2.6, -1.9], [-1.9, 2.4, -2.3], 0.07], [[2.6, 0.1, 1], [4.4, 2.4, -0.9], 0.05]];
  return glbOf([
    { name: "floor", color: GREY, mesh: floor(14) },
    { name: "balls", color: SAND, mesh: join([sphere([-3.3, 0.2, -2.6], 1.5), sphere([-1.7, 2.4, 2.3], 0.7),
      sphere([4.3, 0.5, 0.4], 0.5)]) },
    { name: "boxes", color: BLUE, mesh: join([box([1, 1.4, -1.3], [2.6, 1.7, -0.3]),
      box([2.7, 0, 1.8], [3.5, 1.2, 2.6]), box([-0.6, 0, -4], [-0.2, 0.5, -2.2])]) },
    { name: "sticks", color: RED, mesh: join([...sticks.map((s) => stick(...s)),
      row(6, (i) => stick([0.4 + 0.35 * i, 2.4, -1.6], [1 + 0.35 * i, 2.6, -4], 0.06))]) }]);
}

// Everything stands on the floor: penumbrae start at nothing.
function contacts() {
  return glbOf([
    { name: "floor", color: GREY, mesh: floor(12) },
    { name: "boxes", color: BLUE, mesh: join([box([-2.4, 0, -0.6], [-1.2, 1.4, 0.4]), box([1.2, 0, 1.1], [2, 0.25, 2.1]),
      box([0.4, 0, -2], [0.7, 2.2, -1.7]), box([-3.2, 0, 2], [-2.9, 0.6, 2.9])]) },
    { name: "sticks", color: RED, mesh: row(9, (i) => stick([-1.6 + 0.45 * i, 0, 1.4 - 0.12 * i],
      [-1.5 + 0.45 * i, 0.5 + 0.16 * i, 1.2 - 0.12 * i], 0.03)) },
    { name: "leaning", color: SAND, mesh: join([stick([2.2, 0, -0.6], [0.72, 2, -1.85], 0.05),
      stick([-0.4, 0, 2.6], [-1.2, 1.3, 0.1], 0.04), sphere([2.6, 0.4, -0.2], 0.4), sphere([0.2, 0.15, 2.9], 0.15)]) }]);
}

// Receivers that bend: hills and balls under slats and sticks.
function curved() {
  const height = (x, z) => 0.45 * Math.sin(1.1 * x + 0.4) * Math.cos(0.9 * z) + 0.15 * Math.sin(2.3 * z + x);
  return glbOf([
    { name: "hills", color: GREY, mesh: hills(9, 128, height) },
    { name: "balls", color: SAND, mesh: join([sphere([-1.9, 0.9, 0.3], 1.1), sphere([1.7, 0.6, 1.3], 0.8),
      sphere([0.6, 1.2, -2.2], 0.9)]) },
    { name: "slats", color: BLUE, mesh: row(6, (i) => box([-3.1 + 0.5 * i, 2.7, -0.6], [-2.9 + 0.5 * i, 2.76, 1.9])) },
    { name: "sticks", color: RED, mesh: join([stick([0.4, 2.1, 2.6], [3.4, 2.3, 0.2], 0.05),
      stick([-0.6, 2.6, -3.4], [2, 2.4, -1], 0.06), stick([0.1, -0.6, 2.2], [0.5, 1.9, 2], 0.04)]) }]);
}

// A lattice and a table between two lights.
function pergola() {
  const legs = [[-1.3, -0.8], [1.3, -0.8], [-1.3, 0.8], [1.3, 0.8]];
  return glbOf([
    { name: "floor", color: GREY, mesh: floor(12) },
    { name: "wall", color: SAND, mesh: quad([-6, 0, -3.5], [12, 0, 0], [0, 5, 0]) },
    { name: "table", color: RED, mesh: join([box([-1.5, 0.95, -1], [1.5, 1.05, 1]),
      ...legs.map(([x, z]) => box([x - 0.06, 0, z - 0.06], [x + 0.06, 0.95, z + 0.06]))]) },
    { name: "lattice", color: BLUE, mesh: join([row(8, (i) => box([-2.6 + 0.7 * i, 2.6, -2.4], [-2.5 + 0.7 * i, 2.75, 2.2])),
      row(5, (i) => box([-2.8, 2.75, -2.2 + i], [2.6, 2.82, -2.1 + i]))]) },
    { name: "balls", color: SAND, mesh: join([sphere([0.3, 1.4, 0.1], 0.35), sphere([-3, 0.5, 1], 0.5)]) }]);
}

const above = { eye: [0, 9, 11.5], target: [0, 0.2, 0.2], yfov_deg: 42 };
const shared = (name, without) => (folder) =>
  lambertOf(readFileSync(path(folder, "glb", name, `${name}.glb`)), without);

export const shadows = [
  { name: "gazebo", about: "lattice and bars, light from the side", glb: shared("gazebo", /light/),
    camera: { eye: [-6.5, 5.2, 5], target: [-0.9, 0.7, -0.4], yfov_deg: 42 }, crop: [20, 230, 128, 128],
    lights: [light({ center: [5, 5.5, 4], target: [0, 0.5, 0], halfU: 0.6, turn: 0.3 })] },
  { name: "fence", about: "thin slats, their shadows on the ground", glb: shared("fence", /light|metal/),
    camera: { eye: [-5, 6.5, -9.5], target: [0.2, 0, -1.6], yfov_deg: 38 }, crop: [130, 180, 128, 128],
    lights: [light({ center: [1.5, 5, 6], target: [0, 0, -1], halfU: 0.5, halfV: 0.8, turn: 0.4 })] },
  { name: "contacts", about: "boxes and sticks that stand on the floor", glb: contacts,
    camera: { eye: [0.6, 5.2, 7.4], target: [0, 0.3, 0.3], yfov_deg: 40 }, crop: [110, 180, 128, 128],
    lights: [light({ center: [-4, 6, 3], target: [0, 0, 0], halfU: 0.7, turn: 0.5 })] },
  { name: "two_lights", about: "a large warm light and a small cold one", glb: pergola,
    camera: { eye: [1.5, 4.4, 9], target: [0, 1, -0.4], yfov_deg: 40 }, crop: [140, 270, 128, 128],
    lights: [light({ center: [-2, 7, 3], target: [0, 0, 0], halfU: 1.4, halfV: 1, turn: 0.2, level: [0.7, 0.6, 0.45] }),
      light({ center: [4, 6, 2.5], target: [0, 0, 0], halfU: 0.3, turn: 0.7, level: [0.25, 0.35, 0.5] })] },
  { name: "small_light", about: "half side 0.35 at a height of 8, Gaussian", glb: medley, camera: above, crop: [280, 100, 128, 128],
    lights: [light({ center: [-1.2, 8, -0.6], target: [0, 0, 0.2], halfU: 0.35, turn: 0.5, profile: "gaussian" })] },
  { name: "large_light", about: "half side 2 at a height of 8", glb: medley, camera: above, crop: [110, 300, 128, 128],
    lights: [light({ center: [-1.2, 8, -0.6], target: [0, 0, 0.2], halfU: 2, turn: 0.5 })] },
  { name: "tilted_light", about: "low, turned by 50 degrees, Gaussian", glb: medley, camera: above, crop: [240, 230, 128, 128],
    lights: [light({ center: [-6.5, 5.8, 3.5], target: [0.5, 0.4, 0], halfU: 1, halfV: 0.8, turn: 0.9, profile: "gaussian" })] },
  { name: "curved", about: "hills and balls under slats", glb: curved,
    camera: { eye: [0.5, 6, 8], target: [0, 0.4, 0.1], yfov_deg: 42 }, crop: [60, 180, 128, 128],
    lights: [light({ center: [1.5, 7, 1.5], target: [0, 0, 0], halfU: 0.8, turn: 0.35 })] },
].map((scene) => ({ ...scene, effect: "shadows" }));
