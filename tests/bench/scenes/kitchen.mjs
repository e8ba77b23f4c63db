// A kitchen: the sun falls through a pane of glass onto the floor, three small lamps hang over a worktop, and a glass table
// mirrors them. And what a shop photographs: glass, metals and lacquer between two softboxes in a white cove.
import { mkdirSync, writeFileSync } from "node:fs";
import { glbOf } from "./glb.mjs";
import { radiance } from "./hdr.mjs";
import { box, join, quad, sphere, unit } from "./mesh.mjs";
import { checkerboard } from "./png.mjs";

const SUN = unit([-0.85, 0.5, 0.2]);
const DEFAULT = (roughness, extensions) => ({ specular: 1, roughness, extensions });
const METAL = (roughness) => ({ metallic: 1, roughness });
const COAT = { KHR_materials_clearcoat: { clearcoatFactor: 1, clearcoatRoughnessFactor: 0.03 } };
const PANE = { KHR_materials_transmission: { transmissionFactor: 1 }, KHR_materials_ior: { ior: 1.5 } };
const SOLID = { ...PANE, KHR_materials_volume: { thicknessFactor: 1 } };

// From x = -3 to 3, z = -3 to 3; the window is in the wall at x = -3.
const rooms = () => [
  { name: "floor", color: [1, 1, 1], texture: checkerboard(16, 16, [0.2, 0.15, 0.1], [0.6, 0.52, 0.42]), mesh: quad([-3, 0, 3], [6, 0, 0], [0, 0, -6]), material: DEFAULT(0.2) },
  { name: "ceiling", color: [0.8, 0.78, 0.72], mesh: quad([-3, 2.8, -3], [6, 0, 0], [0, 0, 6]), material: DEFAULT(0.8) },
  { name: "walls", color: [0.8, 0.78, 0.72], material: DEFAULT(0.8), mesh: join([quad([-3, 0, -3], [6, 0, 0], [0, 2.8, 0]),
    quad([3, 0, -3], [0, 0, 6], [0, 2.8, 0]), quad([3, 0, 3], [-6, 0, 0], [0, 2.8, 0]), box([-3.1, 0, -3], [-3, 0.8, 3]),
    box([-3.1, 2.3, -3], [-3, 2.8, 3]), box([-3.1, 0.8, -3], [-3, 2.3, -1.6]), box([-3.1, 0.8, 1], [-3, 2.3, 3])]) },
  { name: "pane", color: [1, 1, 1], mesh: quad([-3.05, 0.8, 1], [0, 0, -2.6], [0, 1.5, 0]), material: DEFAULT(0, PANE) }];

const leg = (x, z) => box([x, 0, z], [x + 0.06, 0.7, z + 0.06]);
const furniture = () => [
  { name: "worktop", color: [0.45, 0.28, 0.15], mesh: box([-2.2, 0.84, -3], [2.2, 0.9, -2.2]), material: DEFAULT(0.3) },
  { name: "cupboards", color: [0.12, 0.25, 0.3], mesh: box([-2.1, 0, -3], [2.1, 0.84, -2.25]), material: DEFAULT(0.3) },
  { name: "table", color: [1, 1, 1], mesh: box([-0.7, 0.7, -0.4], [1.1, 0.74, 0.8]), material: DEFAULT(0, SOLID) },
  { name: "legs", color: [0.8, 0.8, 0.82], mesh: join([leg(-0.65, -0.35), leg(1, -0.35), leg(-0.65, 0.7), leg(1, 0.7)]), material: METAL(0.25) },
  { name: "pots", color: [0.85, 0.85, 0.87], mesh: join([-1.8, -0.5, 0.8].map((x) => sphere([x, 1.02, -2.6], 0.12))), material: METAL(0.2) },
  { name: "jars", color: [0.5, 0.15, 0.1], mesh: join([-1.15, 0.15, 1.5].map((x) => sphere([x, 1.02, -2.6], 0.12))), material: DEFAULT(0.3, COAT) },
  { name: "orange", color: [0.9, 0.45, 0.05], mesh: sphere([0.1, 0.86, 0.2], 0.12), material: DEFAULT(0.4) },
  { name: "apple", color: [0.3, 0.6, 0.1], mesh: sphere([0.5, 0.84, 0], 0.1), material: DEFAULT(0.2, COAT) },
  { name: "lamps", color: [0, 0, 0], emission: [30, 22, 13], mesh: join([-1, 0, 1].map((x) => sphere([x, 1.9, -2.4], 0.06, 24))) }];

function outside(direction) {
  const facing = direction.reduce((sum, v, i) => sum + v * SUN[i], 0), sun = facing > 0.99905 ? 1500 : 0;
  return direction[1] < 0 ? [0.1, 0.12, 0.07] : [0.5 + sun, 0.65 + 0.85 * sun, 0.9 + 0.65 * sun];
}

const cove = () => [
  { name: "cove", color: [0.85, 0.85, 0.85], mesh: join([quad([-5, 0, 5], [10, 0, 0], [0, 0, -8]), quad([-5, 0, -3], [10, 0, 0], [0, 6, 0])]), material: DEFAULT(0.5) },
  { name: "softboxes", color: [0, 0, 0], emission: [8, 8, 8], mesh: join([quad([-3.1, 1.7, 1.8], [1.2, 1.6, 0], [0, 0, -1.6]), quad([2.7, 2, 1.6], [0, 0, -1.6], [-1, 1.6, 0])]) },
  { name: "glass", color: [1, 1, 1], mesh: sphere([-0.7, 0.5, 0], 0.5), material: DEFAULT(0, SOLID) },
  { name: "copper", color: [0.95, 0.64, 0.54], mesh: sphere([0.45, 0.4, 0.35], 0.4), material: METAL(0.2) },
  { name: "chrome", color: [0.9, 0.9, 0.9], mesh: sphere([1.3, 0.3, 0.3], 0.3), material: METAL(0.05) },
  { name: "lacquer", color: [0.05, 0.2, 0.6], mesh: sphere([-0.1, 0.22, 0.75], 0.22), material: DEFAULT(0.3, COAT) },
  { name: "box", color: [0.7, 0.05, 0.05], mesh: box([0.15, 0, -1.15], [0.85, 1.2, -0.45]), material: DEFAULT(0.25) }];

export const KITCHEN_NAMES = ["kitchen", "shop"];

// Writes what has to be written to `folder`; width: of the pictures.
export function kitchenScenes(folder, width) {
  const kitchen = `${folder}/kitchen.glb`, shop = `${folder}/shop.glb`, hdr = `${folder}/kitchen.hdr`;
  mkdirSync(folder, { recursive: true });
  writeFileSync(kitchen, glbOf([...rooms(), ...furniture()]));
  writeFileSync(shop, glbOf(cove()));
  writeFileSync(hdr, radiance(256, 128, outside));
  const job = { image: { width, height: Math.round(0.75 * width) }, effects: { indirect_bounces: 8 }, layers: ["beauty"] };
  return [{ name: KITCHEN_NAMES[0], about: "a kitchen, the sun through a pane, lamps in a glass table",
    job: { ...job, scene: { file: kitchen, camera: { eye: [1.9, 1.6, 2.6], target: [-0.5, 0.8, -1], yfov_deg: 55 } }, environment: { file: hdr, rotation_deg: 180 } } },
  { name: KITCHEN_NAMES[1], about: "glass, metals and lacquer between softboxes",
    job: { ...job, scene: { file: shop, camera: { eye: [0, 1.2, 4], target: [0, 0.5, 0], yfov_deg: 34 } } } }];
}
