// What product pictures are made of: balls of glass, metals, plastic and lacquer on a glossy table, under two softboxes
// and under a low sun. Their caustics, small highlights and mirrored lamps are what few paths know least of.
import { mkdirSync, writeFileSync } from "node:fs";
import { glbOf } from "./glb.mjs";
import { radiance } from "./hdr.mjs";
import { box, floor, quad, sphere, unit } from "./mesh.mjs";
import { checkerboard } from "./png.mjs";

const SUN = unit([-0.55, 0.45, 0.7]);
const CAMERA = { eye: [0, 2.4, 8], target: [0, 0.8, 0], yfov_deg: 35 };

const GLASS = { KHR_materials_transmission: { transmissionFactor: 1 }, KHR_materials_ior: { ior: 1.5 },
  KHR_materials_volume: { thicknessFactor: 1, attenuationDistance: 2, attenuationColor: [0.7, 0.9, 0.8] } };
const LACQUER = { KHR_materials_clearcoat: { clearcoatFactor: 1, clearcoatRoughnessFactor: 0.03 } };

const products = () => [
  { name: "lacquer", color: [0.6, 0.02, 0.02], mesh: sphere([-2.2, 1, 0], 1), material: { specular: 1, roughness: 0.5, extensions: LACQUER } },
  { name: "gold", color: [1, 0.76, 0.34], mesh: sphere([0, 1, -0.6], 1), material: { metallic: 1, roughness: 0.2 } },
  { name: "glass", color: [1, 1, 1], mesh: sphere([2.2, 1, 0], 1), material: { specular: 1, roughness: 0, extensions: GLASS } },
  { name: "plastic", color: [0.1, 0.3, 0.7], mesh: sphere([-1, 0.5, 1.8], 0.5), material: { specular: 1, roughness: 0.35 } },
  { name: "chrome", color: [0.9, 0.9, 0.9], mesh: sphere([1.1, 0.5, 1.8], 0.5), material: { metallic: 1, roughness: 0.05 } },
  { name: "chalk", color: [0.8, 0.8, 0.75], mesh: box([-0.3, 0, 2.7], [0.3, 0.6, 3.3]), material: { specular: 1, roughness: 0.9 } }];

const tiles = { name: "table", color: [1, 1, 1], texture: checkerboard(64, 64, [0.1, 0.1, 0.1], [0.5, 0.5, 0.5]), mesh: floor(8), material: { specular: 1, roughness: 0.15 } };
const plain = { name: "table", color: [0.8, 0.8, 0.8], mesh: floor(8), material: { specular: 1, roughness: 0.6 } };
const softboxes = [
  { name: "left", color: [0, 0, 0], emission: [12, 11, 10], mesh: quad([-5, 4.5, 2], [3, 0, 0], [0, 1, -3]) },
  { name: "right", color: [0, 0, 0], emission: [4, 5, 7], mesh: quad([2, 4.5, -1], [3, 0, 0], [0, -1, -3]) }];

const dim = () => [0.05, 0.055, 0.06];

// Blue above and green below; the sun is five degrees wide.
function evening(direction) {
  const facing = direction.reduce((sum, v, i) => sum + v * SUN[i], 0), sun = facing > 0.99905 ? 900 : 0;
  const up = Math.max(direction[1], 0);
  return direction[1] < 0 ? [0.12, 0.2, 0.06] : [0.5 - 0.2 * up + sun, 0.6 - 0.1 * up + 0.85 * sun, 0.75 + 0.1 * up + 0.6 * sun];
}

export const TABLE_NAMES = ["table", "table_sun"];

// Writes what has to be written to `folder`; width: of the pictures.
export function tableScenes(folder, width) {
  mkdirSync(folder, { recursive: true });
  const scene = (name, about, parts, light) => {
    const glb = `${folder}/${name}.glb`, hdr = `${folder}/${name}.hdr`;
    writeFileSync(glb, glbOf(parts));
    writeFileSync(hdr, radiance(256, 128, light));
    return { name, about, job: { scene: { file: glb, camera: CAMERA }, environment: { file: hdr },
      image: { width, height: Math.round(0.75 * width) }, effects: { indirect_bounces: 6 }, layers: ["beauty"] } };
  };
  return [scene(TABLE_NAMES[0], "balls of glass, metal and lacquer under softboxes, six bounces", [tiles, ...products(), ...softboxes], dim),
    scene(TABLE_NAMES[1], "the same under a low sun, six bounces", [plain, ...products()], evening)];
}
