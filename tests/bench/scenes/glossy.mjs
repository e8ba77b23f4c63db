// Metals that show what stands on and around them, to compare filters of glossy lobes. In each scene the first
// instances are the metals: what is judged. All else is Lambert, in a room with chequered walls.
import { glbOf } from "./glb.mjs";
import { light } from "./light.mjs";
import { box, bumpyBall, groovedDisc, quad, sphere, turned } from "./mesh.mjs";
import { checkerboard } from "./png.mjs";

const GREY = [0.6, 0.6, 0.6], ONE = [1, 1, 1], STEEL = [0.8, 0.78, 0.75];
const metal = (roughness) => ({ metallic: 1, roughness, specular: 1 });
const chequers = (a, b) => checkerboard(12, 6, a, b);

const room = [
  { name: "back", color: ONE, texture: chequers([0.1, 0.15, 0.4], [0.8, 0.75, 0.6]), mesh: quad([-2.5, 0, -2], [5, 0, 0], [0, 2.5, 0]) },
  { name: "left", color: ONE, texture: chequers([0.6, 0.1, 0.05], [0.75, 0.7, 0.65]), mesh: quad([-2.5, 0, -2], [0, 2.5, 0], [0, 0, 5]) },
  { name: "right", color: ONE, texture: chequers([0.1, 0.4, 0.1], [0.7, 0.75, 0.65]), mesh: quad([2.5, 0, -2], [0, 0, 5], [0, 2.5, 0]) },
  { name: "front", color: GREY, mesh: quad([-2.5, 0, 3], [0, 2.5, 0], [5, 0, 0]) }];
const ground = { name: "ground", color: ONE, texture: chequers([0.15, 0.15, 0.15], [0.75, 0.7, 0.65]), mesh: quad([-2.5, -0.001, -2], [0, 0, 5], [5, 0, 0]) };
const things = [
  { name: "red", color: [0.75, 0.1, 0.08], mesh: turned(box([-0.2, 0, -0.2], [0.2, 0.6, 0.2]), 0.5, [-0.95, 0, 0.1]) },
  { name: "blue", color: [0.1, 0.2, 0.75], mesh: sphere([0, 0.3, -0.3], 0.3) },
  { name: "yellow", color: [0.8, 0.65, 0.1], mesh: turned(box([-0.15, 0, -0.15], [0.15, 0.8, 0.15]), -0.3, [0.95, 0, 0.1]) }];

// Plates of the floor from front to back, the sharper ones nearer, with things that stand on their edges.
const PLATES = [0.12, 0.2, 0.32, 0.5];
const plates = () => glbOf([...PLATES.map((roughness, i) => ({ name: `plate ${roughness}`, color: STEEL, material: metal(roughness),
  mesh: quad([-1.6 + 0.8 * i, 0, -1.4], [0, 0, 2.8], [0.78, 0, 0]) })), ...room, ground, ...things]);

// Balls in booths of their own: what they saw of lamps in each other would be the noise of those.
const BALLS = [0.15, 0.25, 0.4, 0.6];
const boards = BALLS.slice(1).map((_, i) => ({ name: `board ${i}`, color: i % 2 ? [0.7, 0.2, 0.1] : [0.15, 0.35, 0.6],
  mesh: box([-0.93 + 0.9 * i, 0, -0.7], [-0.87 + 0.9 * i, 1, 0.8]) }));
const spheres = () => glbOf([...BALLS.map((roughness, i) => ({ name: `ball ${roughness}`, color: STEEL, material: metal(roughness),
  mesh: sphere([-1.35 + 0.9 * i, 0.38, 0.1], 0.38, 128) })), ...room, ground, ...boards]);

const disc = () => glbOf([{ name: "disc", color: STEEL, material: metal(0.3), mesh: groovedDisc([0, 0.02, 0.2], 1.5, 0.15, 0.08) }, ...room, ground, ...things]);

// Turned on a lathe: facets are spread most across the grooves, which are finer than can be seen.
const brushed = () => glbOf([{ name: "disc", color: STEEL, material: { ...metal(0.2), anisotropy: [0.5, Math.PI / 2] },
  mesh: groovedDisc([0, 0.02, 0.2], 1.5, 0.15, 0) }, ...room, ground, ...things]);

// Plates of the other reflection models.
const MODELS = [{ model: "beckmann", alpha: 0.06, eta: [0.2, 0.92, 1.1], k: [3.9, 2.45, 2.14] }, { model: "ward", alpha_u: 0.06, alpha_v: 0.24, specular: STEEL },
  { model: "ashikhmin_shirley", exponent_u: 20, exponent_v: 600, specular: STEEL }, { model: "kelemen", alpha: 0.15, specular: STEEL }];
const models = () => glbOf([...MODELS.map((model, i) => ({ name: model.model, color: [0, 0, 0], material: { model },
  mesh: quad([-1.6 + 0.8 * i, 0, -1.4], [0, 0, 2.8], [0.78, 0, 0]) })), ...room, ground, ...things]);

const bumpy = () => glbOf([{ name: "body", color: STEEL, material: metal(0.3), mesh: bumpyBall([0, 0.85, 0], 0.8, 0.02, 8) }, ...room, ground]);

const eye = [0.15, 1.6, 2.85];
const over = { eye, target: [0, 0.05, 0.1], yfov_deg: 52 }, along = { eye, target: [0, 0.45, 0], yfov_deg: 62 }, at = { eye, target: [0, 0.8, 0], yfov_deg: 46 };
const lights = [light({ center: [0.3, 2.45, 1], target: [0, 0, 0], halfU: 0.5, level: [1, 0.95, 0.9] })];

// metals: how many of the first instances are judged.
export const glossy = [
  { name: "plates", about: `flat metals of roughness ${PLATES.join(", ")}, things on them`, glb: plates, metals: PLATES.length, camera: over },
  { name: "spheres", about: `metal balls of roughness ${BALLS.join(", ")}`, glb: spheres, metals: BALLS.length, camera: along },
  { name: "disc", about: "a grooved metal disc of roughness 0.3, things on it", glb: disc, metals: 1, camera: over },
  { name: "brushed", about: "a metal disc of roughness 0.2, brushed round, things on it", glb: brushed, metals: 1, camera: over },
  { name: "models", about: `plates of ${MODELS.map((m) => m.model).join(", ")}, things on them`, glb: models, metals: MODELS.length, camera: over },
  { name: "bumpy", about: "a bumpy metal body of roughness 0.3", glb: bumpy, metals: 1, camera: at },
].map((scene) => ({ ...scene, bounces: 1, lights }));
