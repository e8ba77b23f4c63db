// What sharp and rough lobes show: balls of car paint on a polished floor between strip lights, and a corridor with a
// wall of rough metal, a pane of frosted glass and a polished floor that a sky lights from its end.
import { mkdirSync, writeFileSync } from "node:fs";
import { glbOf } from "./glb.mjs";
import { radiance } from "./hdr.mjs";
import { box, join, quad, sphere } from "./mesh.mjs";
import { checkerboard } from "./png.mjs";

const METAL = (roughness) => ({ metallic: 1, roughness });
const DEFAULT = (roughness) => ({ specular: 1, roughness });
const glass = (roughness, attenuationDistance, attenuationColor) => ({ ...DEFAULT(roughness), extensions: {
  KHR_materials_transmission: { transmissionFactor: 1 }, KHR_materials_ior: { ior: 1.5 },
  KHR_materials_volume: { thicknessFactor: 1, attenuationDistance, attenuationColor } } });
const PAINT = { ...DEFAULT(0.5), extensions: { KHR_materials_clearcoat: { clearcoatFactor: 1, clearcoatRoughnessFactor: 0.03 } } };
const shines = (name, emission, mesh) => ({ name, color: [0, 0, 0], emission, mesh });

const studio = () => [
  { name: "floor", color: [0.03, 0.03, 0.03], mesh: quad([-8, 0, 8], [16, 0, 0], [0, 0, -16]), material: DEFAULT(0.15) },
  { name: "back", color: [0.4, 0.4, 0.4], mesh: quad([-8, 0, -5], [16, 0, 0], [0, 8, 0]), material: DEFAULT(0.7) },
  { name: "body", color: [0.5, 0.02, 0.02], mesh: join([sphere([0, 0.7, 0], 0.7), sphere([0.9, 0.5, 0.2], 0.5), sphere([-0.9, 0.5, 0.2], 0.5)]), material: PAINT },
  { name: "rims", color: [0.9, 0.9, 0.9], mesh: join([sphere([-0.5, 0.2, 0.9], 0.2), sphere([0.5, 0.2, 0.9], 0.2)]), material: METAL(0.2) },
  { name: "glass", color: [1, 1, 1], mesh: sphere([1.7, 0.35, 0.6], 0.35), material: glass(0, 1, [0.7, 0.9, 0.8]) },
  shines("strips", [12, 12, 12], join([quad([-3, 4, -1], [6, 0, 0], [0, 0, 0.4]), quad([-3, 4, 1], [6, 0, 0], [0, 0, 0.4])])),
  shines("side", [5, 6, 8], quad([-5, 0, -2], [0, 0, 4], [0, 3, 0]))];

const corridor = () => [
  { name: "floor", color: [0.5, 0.5, 0.5], texture: checkerboard(16, 16, [0.6, 0.6, 0.6], [0.2, 0.2, 0.2]), mesh: quad([-1.5, 0, 2], [3, 0, 0], [0, 0, -10]), material: DEFAULT(0.1) },
  { name: "left", color: [0.7, 0.7, 0.7], mesh: quad([-1.5, 0, 2], [0, 0, -10], [0, 2.6, 0]), material: DEFAULT(0.6) },
  { name: "right", color: [0.9, 0.9, 0.92], mesh: quad([1.5, 0, -8], [0, 0, 10], [0, 2.6, 0]), material: METAL(0.3) },
  { name: "ceiling", color: [0.8, 0.8, 0.8], mesh: quad([-1.5, 2.6, -8], [3, 0, 0], [0, 0, 10]), material: DEFAULT(0.9) },
  { name: "pane", color: [1, 1, 1], mesh: box([-1.2, 0, -3.05], [0.2, 2.2, -3]), material: glass(0.25, 3, [0.8, 1, 0.9]) },
  { name: "ball", color: [0.9, 0.4, 0.1], mesh: sphere([0.6, 0.4, -1.5], 0.4), material: DEFAULT(0.05) },
  { name: "crate", color: [0.3, 0.5, 0.3], mesh: box([-1, 0, -1.6], [-0.4, 0.6, -1]), material: DEFAULT(0.7) }];

// Houses in the evening: windows of two colours below a sky that is brighter to one side.
function evening([x, y, z]) {
  const sky = 0.3 + 0.4 * Math.max(x, 0), window = Math.sin(23 * Math.atan2(z, x)) > 0.6 && Math.sin(40 * y) > 0.4;
  if (y > 0.45) return [0.6 * sky, 0.8 * sky, 1.4 * sky];
  if (y < 0) return [0.08, 0.08, 0.09];
  return window ? [3, x > 0 ? 2 : 1.2, 0.8] : [0.2, 0.15, 0.13];
}

export const GLOSS_NAMES = ["paint", "corridor"];

// Writes what has to be written to `folder`; width: of the pictures.
export function glossScenes(folder, width) {
  const hdr = `${folder}/evening.hdr`;
  mkdirSync(folder, { recursive: true });
  writeFileSync(hdr, radiance(256, 128, evening));
  const scene = (name, about, parts, camera, indirect_bounces, more) => {
    const file = `${folder}/${name}.glb`;
    writeFileSync(file, glbOf(parts));
    return { name, about, job: { scene: { file, camera }, image: { width, height: Math.round(0.75 * width) }, effects: { indirect_bounces }, layers: ["beauty"], ...more } };
  };
  return [scene(GLOSS_NAMES[0], "car paint between strip lights, six bounces", studio(), { eye: [1, 1.4, 5], target: [0.2, 0.5, 0], yfov_deg: 40 }, 6, {}),
    scene(GLOSS_NAMES[1], "a corridor of rough metal, eight bounces", corridor(), { eye: [0, 1.4, 2.5], target: [0, 1.1, -2], yfov_deg: 55 }, 8, { environment: { file: hdr } })];
}
