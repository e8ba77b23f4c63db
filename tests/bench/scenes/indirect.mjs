// Indirect light: boxes and rooms under lights of the job, one bounce or several, Lambert and not. The
// shapes are made here (CC0); the living room and the helmet are not shipped.
import { readFileSync } from "node:fs";
import { join as path } from "node:path";
import { glbOf, gltfBase } from "./glb.mjs";
import { light } from "./light.mjs";
import { box, floor, join, quad, sphere, turned } from "./mesh.mjs";
import { checkerboard } from "./png.mjs";

const WHITE = [0.72, 0.72, 0.72], RED = [0.63, 0.065, 0.05], GREEN = [0.14, 0.45, 0.09], ONE = [1, 1, 1];

// Five walls of a room that is open towards +z: x within +-half, y from 0 to height, z from back to front.
const walls = (half, height, back, front, { left = WHITE, right = WHITE, rest = WHITE } = {}) => [
  { name: "left", color: left, mesh: quad([-half, 0, back], [0, height, 0], [0, 0, front - back]) },
  { name: "right", color: right, mesh: quad([half, 0, back], [0, 0, front - back], [0, height, 0]) },
  { name: "back", color: rest, mesh: quad([-half, 0, back], [2 * half, 0, 0], [0, height, 0]) },
  { name: "ceiling", color: rest, mesh: quad([-half, height, back], [2 * half, 0, 0], [0, 0, front - back]) }];
const ground = (half, back, front) => quad([-half, 0, back], [0, 0, front - back], [2 * half, 0, 0]);

// The box of the papers: coloured walls, a chequered floor, two boxes, two balls.
export function cornell() {
  return glbOf([...walls(1, 2, -1, 1, { left: RED, right: GREEN }),
    { name: "floor", color: ONE, texture: checkerboard(8, 8, [0.3, 0.3, 0.35], [0.75, 0.75, 0.75]), mesh: ground(1, -1, 1) },
    { name: "tall", color: WHITE, mesh: turned(box([-0.28, 0, -0.28], [0.28, 1.2, 0.28]), -0.3, [-0.42, 0, -0.35]) },
    { name: "low", color: [0.7, 0.6, 0.2], mesh: turned(box([-0.25, 0, -0.12], [0.25, 0.24, 0.12]), 0.35, [0.12, 0, 0.55]) },
    { name: "ball", color: WHITE, mesh: sphere([0.45, 0.38, -0.05], 0.38) },
    { name: "small ball", color: [0.2, 0.3, 0.75], mesh: sphere([-0.62, 0.16, 0.55], 0.16) }]);
}

// A chequered board 0.05 to 0.3 above a floor, sloping up towards a lamp beyond the floor's edge that
// shines under it: the floor is lit by the board.
function reflector() {
  const board = quad([-1, 0.05, -1], [2, 0.25, 0], [0, 0, 2]);
  return glbOf([{ name: "floor", color: [0.6, 0.6, 0.6], mesh: quad([-1.6, 0, -1.5], [0, 0, 3], [2.85, 0, 0]) },
    { name: "board", color: ONE, texture: checkerboard(8, 8, [0.05, 0.05, 0.06], [0.85, 0.8, 0.7]), mesh: board },
    { name: "kerb", color: [0.6, 0.6, 0.6], mesh: box([-1.6, 0, -1.1], [-1.5, 0.12, 1.1]) }]);
}

// Coloured things above a floor that shines like varnish.
function glossy() {
  return glbOf([{ name: "floor", color: [0.35, 0.3, 0.25], mesh: floor(3), material: { roughness: 0.2, specular: 1 } },
    { name: "back", color: WHITE, mesh: quad([-3, 0, -1.6], [6, 0, 0], [0, 3, 0]) },
    { name: "ball", color: [0.75, 0.15, 0.1], mesh: sphere([-0.9, 0.5, 0], 0.5) },
    { name: "block", color: [0.1, 0.3, 0.7], mesh: turned(box([-0.35, 0, -0.35], [0.35, 0.7, 0.35]), 0.5, [0.3, 0, -0.4]) },
    { name: "shelf", color: [0.75, 0.6, 0.1], mesh: box([0.7, 0.25, 0.2], [1.7, 0.35, 0.7]) },
    { name: "pearl", color: [0.2, 0.6, 0.25], mesh: sphere([0.1, 0.2, 0.7], 0.2) }]);
}

// The helmet on the floor of a room.
function helmet(shared) {
  return glbOf([...walls(0.8, 1.3, -0.7, 1.5, { left: [0.6, 0.25, 0.15], right: [0.15, 0.3, 0.55] }),
    { name: "floor", color: [0.6, 0.55, 0.45], mesh: ground(0.8, -0.7, 1.5) }],
  gltfBase(path(shared, "gltf/FlightHelmet/FlightHelmet.gltf"), /Lenses/));
}

// A little off the axis: seen from there, the room's edges would lie on the centres of pixels.
export const inside = { eye: [0.037, 1.023, 3.4], target: [0.013, 1.007, 0], yfov_deg: 44.6 };
const bulb = { type: "point", position: [0.05, 1.6, 0.1], intensity: [1.8, 1.71, 1.53] };

//   bounces, sides: pixels across and down as parts of the bench's side, 1 and 1 unless said
//   environment(shared): as in a job document
export const indirect = [
  { name: "box", about: "coloured box, one bounce under a small light", glb: cornell, bounces: 1,
    camera: inside, lights: [bulb], crop: [60, 300, 128, 128] },
  { name: "box_4", about: "the same with four bounces", glb: cornell, bounces: 4,
    camera: inside, lights: [bulb], crop: [60, 300, 128, 128] },
  { name: "living_room", about: "its own materials, a sky through its windows, six bounces", bounces: 6, sides: [1, 0.5625],
    glb: (shared) => readFileSync(path(shared, "glb/living-room/living-room.glb")),
    environment: (shared) => ({ file: path(shared, "glb/living-room/living-room_env.hdr"), intensity: 1, rotation_deg: 0 }),
    lights: [], crop: [200, 150, 128, 128] },
  { name: "reflector", about: "a chequered board above a floor, lit from the side", glb: reflector, bounces: 1,
    camera: { eye: [0.5, 0.2, 0.1], target: [-0.12, -0.02, 0], yfov_deg: 58 },
    lights: [{ type: "point", position: [3, 0.03, -0.4], intensity: [30, 30, 30] }], crop: [100, 160, 128, 128] },
  { name: "glossy_floor", about: "coloured things on a floor of roughness 0.2, two bounces", glb: glossy, bounces: 2,
    camera: { eye: [0.4, 1.5, 4], target: [0.1, 0.35, 0], yfov_deg: 36 },
    lights: [light({ center: [-2, 3.2, 2.5], target: [0, 0, 0], halfU: 0.4 })], crop: [120, 260, 128, 128] },
  { name: "helmet", about: "FlightHelmet without its lenses in a room, four bounces", glb: helmet, bounces: 4,
    camera: { eye: [0.15, 0.5, 1.45], target: [0, 0.38, 0], yfov_deg: 48 },
    lights: [light({ center: [0.2, 1.28, 0.3], target: [0.2, 0, 0.3], halfU: 0.2, level: [0.8, 0.75, 0.65] })],
    crop: [190, 200, 128, 128] },
].map((scene) => ({ ...scene, effect: "indirect" }));
