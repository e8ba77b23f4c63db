// What is narrower than a pixel, before a room that is lit from above, half of it in the shadow of a
// shelf: wires in the air, and a fence of laths. The shapes are made here (CC0).
import { glbOf } from "./glb.mjs";
import { light } from "./light.mjs";
import { box, join, quad, stick } from "./mesh.mjs";

const WHITE = [0.72, 0.72, 0.72], RED = [0.63, 0.065, 0.05], GREEN = [0.14, 0.45, 0.09];

const room = () => [
  { name: "left", color: RED, mesh: quad([-1, 0, -1], [0, 2, 0], [0, 0, 2]) },
  { name: "right", color: GREEN, mesh: quad([1, 0, -1], [0, 0, 2], [0, 2, 0]) },
  { name: "back", color: [0.2, 0.22, 0.3], mesh: quad([-1, 0, -1], [2, 0, 0], [0, 2, 0]) },
  { name: "floor", color: [0.3, 0.3, 0.3], mesh: quad([-1, 0, -1], [0, 0, 2], [2, 0, 0]) },
  { name: "shelf", color: WHITE, mesh: box([-0.9, 1.5, -0.5], [-0.05, 1.53, 0.6]) }];

// Of a picture 256 pixels high a pixel is 0.0105 wide there.
export function wires(radius = 0.0025) {
  const rods = [];
  for (let i = 0; i < 22; i++) {
    const x = -0.93 + 0.0871 * i;
    rods.push(stick([x, 0.1, 0.3], [x + 0.11 * Math.sin(3 * i), 1.45, 0.25], radius, 12));
  }
  for (let i = 0; i < 6; i++) rods.push(stick([-0.95, 0.2 + 0.19 * i, 0.35], [0.95, 0.27 + 0.17 * i, 0.2], radius, 12));
  return glbOf([...room(), { name: "wires", color: WHITE, mesh: join(rods) }]);
}

// Laths turned this way and that, so that their sides show.
export function fence(width = 0.005) {
  const laths = [];
  for (let i = 0; i < 60; i++) {
    const x = -0.95 + 0.0321 * i, turn = 0.012 * Math.sin(5 * i);
    laths.push(box([x, 0.05, 0.3 + turn], [x + width, 0.9 + 0.06 * Math.sin(2 * i), 0.3 + turn + width]));
  }
  for (const y of [0.25, 0.75]) laths.push(box([-0.97, y, 0.29], [0.97, y + width, 0.295]));
  return glbOf([...room(), { name: "fence", color: WHITE, mesh: join(laths) }]);
}

// A job of either file.
export const job = (file, side = 256) => ({
  scene: { file, lights: false, camera: { eye: [0.037, 1.023, 3.4], target: [0.013, 0.93, 0], yfov_deg: 40 } },
  image: { width: side, height: side }, sampling: { spp: 9, seed: 5 }, effects: { indirect_bounces: 2 },
  lights: [light({ center: [0, 1.97, 0.1], target: [0, 0, 0.1], halfU: 0.25, level: [14, 13, 11] })] });
