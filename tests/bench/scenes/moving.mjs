// Scenes of which one thing moves, the camera, the lamp, a block, or nothing: blocks, a ball and a lamp under a sky, whose
// light comes along paths; these through a lens; and the Cornell box, all of whose light fields bring.
import { readFileSync } from "node:fs";
import { animated, facing, glbOf } from "./glb.mjs";
import { quad } from "./mesh.mjs";
import { blocks } from "./real.mjs";

const CAMERA = { eye: [0.6, 1.9, 4.6], target: [0.1, 0.5, 0], yfov_deg: 40 };
export const FPS = 24;

const room = () => glbOf([...blocks(),
  { name: "lamp", color: [0, 0, 0], mesh: quad([-0.4, 3, 1.2], [0.8, 0, 0], [0, 0, 0.8]), emission: [9, 8.5, 7.5], oneSided: true }]);

// One second of linear motion, by which a thing has gone at its end.
const goes = (node, by) => [{ node, path: "translation", times: [0, 1], values: [0, 0, 0, ...by] }];
function flies(camera, by) {
  const end = camera.eye.map((v, i) => v + by[i]);
  return [{ node: "camera", path: "translation", times: [0, 1], values: [...camera.eye, ...end] },
    { node: "camera", path: "rotation", times: [0, 1], values: [...facing(camera.eye, camera.target), ...facing(end, camera.target)] }];
}

// about: what moves, and how fast in pictures of 320 pixels.
export const moving = [
  { name: "still", about: "nothing moves", tracks: [] },
  { name: "camera", about: "the camera goes round, about 3 px a frame", tracks: flies(CAMERA, [2.2, 0.3, -0.6]) },
  { name: "light", about: "the lamp goes across, its shadows 2 px a frame", tracks: goes("lamp", [2.2, 0, 0]) },
  { name: "object", about: "a block goes across, 2 px a frame", tracks: goes("low", [-1.1, 0, 0.9]) },
].map((one) => ({ ...one, glb: () => animated(room(), CAMERA, one.tracks) }));

const BOX = "tests/scenes/cornell-box/cornell-box.glb", BOX_CAMERA = { eye: [0, 1, 6.8], target: [0, 1, 0], yfov_deg: 20 };

// The same of the Cornell box, which is lit by one rectangle. job: what a job has of it.
export const movingBox = [
  { name: "box-still", about: "nothing moves", tracks: [] },
  { name: "box-camera", about: "the camera goes round, about 3 px a frame", tracks: flies(BOX_CAMERA, [1.4, 0.3, -0.4]) },
  { name: "box-light", about: "the lamp goes across, its shadows 2 px a frame", tracks: goes("Light_emitter_7", [-0.6, 0, 0]) },
  { name: "box-object", about: "a block goes across, 2 px a frame", tracks: goes("ShortBox", [-0.35, 0, 0.1]) },
].map((one) => ({ ...one, glb: () => animated(readFileSync(BOX), BOX_CAMERA, one.tracks), job: { environment: null, effects: { indirect_bounces: 4 } } }));

// The blocks through a lens that is in focus in their middle.
export const movingLens = moving.filter(({ name }) => name !== "light")
  .map((one) => ({ ...one, name: `lens-${one.name}`, job: { lens: { aperture_radius: 0.05, focus_distance: 4.6 } } }));

// A job of its first frames.
export const movingJob = (file, frames, width, spp, more = {}) => ({
  scene: { file }, image: { width, height: Math.round(0.75 * width) }, environment: { radiance: [0.5, 0.6, 0.75] },
  effects: { indirect_bounces: 2 }, sampling: { spp, seed: 1 }, layers: ["beauty", "motion.backward"],
  frames: { first: 1, last: frames }, fps: FPS, ...more });
