// Blocks, a ball and a lamp under a sky, of which one thing moves: the camera, the lamp, a block, or nothing.
import { animated, facing, glbOf } from "./glb.mjs";
import { quad } from "./mesh.mjs";
import { blocks } from "./real.mjs";

const CAMERA = { eye: [0.6, 1.9, 4.6], target: [0.1, 0.5, 0], yfov_deg: 40 };
export const FPS = 24;

const room = () => glbOf([...blocks(),
  { name: "lamp", color: [0, 0, 0], mesh: quad([-0.4, 3, 1.2], [0.8, 0, 0], [0, 0, 0.8]), emission: [9, 8.5, 7.5], oneSided: true }]);

// One second of linear motion, by which a thing has gone at its end.
const goes = (node, by) => [{ node, path: "translation", times: [0, 1], values: [0, 0, 0, ...by] }];
function flies(by) {
  const end = CAMERA.eye.map((v, i) => v + by[i]);
  return [{ node: "camera", path: "translation", times: [0, 1], values: [...CAMERA.eye, ...end] },
    { node: "camera", path: "rotation", times: [0, 1], values: [...facing(CAMERA.eye, CAMERA.target), ...facing(end, CAMERA.target)] }];
}

// about: what moves, and how fast in pictures of 320 pixels.
export const moving = [
  { name: "still", about: "nothing moves", tracks: [] },
  { name: "camera", about: "the camera goes round, about 3 px a frame", tracks: flies([2.2, 0.3, -0.6]) },
  { name: "light", about: "the lamp goes across, its shadows 2 px a frame", tracks: goes("lamp", [2.2, 0, 0]) },
  { name: "object", about: "a block goes across, 2 px a frame", tracks: goes("low", [-1.1, 0, 0.9]) },
].map((one) => ({ ...one, glb: () => animated(room(), CAMERA, one.tracks) }));

// A job of its first frames.
export const movingJob = (file, frames, width, spp, more = {}) => ({
  scene: { file }, image: { width, height: Math.round(0.75 * width) }, environment: { radiance: [0.5, 0.6, 0.75] },
  effects: { indirect_bounces: 2 }, sampling: { spp, seed: 1 }, layers: ["beauty", "motion.backward"],
  frames: { first: 1, last: frames }, fps: FPS, ...more });
