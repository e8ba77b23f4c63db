// A room as people furnish them: a window, a glossy floor, a glass table with a vase, gold and a mirror; and a lamp in a
// globe of frosted glass, so that no light sample finds it and all its light comes by rare paths. By day and by night.
import { mkdirSync, writeFileSync } from "node:fs";
import { glbOf } from "./glb.mjs";
import { radiance } from "./hdr.mjs";
import { box, join, quad, sphere, unit } from "./mesh.mjs";
import { checkerboard } from "./png.mjs";

const SUN = unit([0.8, 0.5, 0.35]);
const CAMERA = { eye: [0.6, 1.5, 4.4], target: [-0.1, 1.05, -1], yfov_deg: 50 };
const METAL = (roughness) => ({ metallic: 1, roughness });
const DEFAULT = (roughness) => ({ specular: 1, roughness });
const glass = (roughness, attenuationDistance, attenuationColor) => ({ ...DEFAULT(roughness), extensions: {
  KHR_materials_transmission: { transmissionFactor: 1 }, KHR_materials_ior: { ior: 1.5 },
  KHR_materials_volume: { thicknessFactor: 1, attenuationDistance, attenuationColor } } });

const wall = (name, color, mesh) => ({ name, color, mesh, material: DEFAULT(0.9) });
const walls = () => [
  wall("back", [0.75, 0.72, 0.68], quad([-3, 0, -3], [6, 0, 0], [0, 3, 0])),
  wall("left", [0.6, 0.25, 0.2], quad([-3, 0, 3], [0, 0, -6], [0, 3, 0])),
  wall("window", [0.8, 0.8, 0.8], join([quad([3, 0, -3], [0, 0, 6], [0, 0.8, 0]), quad([3, 2.4, -3], [0, 0, 6], [0, 0.6, 0]),
    quad([3, 0.8, -3], [0, 0, 2], [0, 1.6, 0]), quad([3, 0.8, 1.5], [0, 0, 1.5], [0, 1.6, 0])])),
  wall("ceiling", [0.85, 0.85, 0.85], quad([-3, 3, -3], [6, 0, 0], [0, 0, 8])),
  wall("behind", [0.8, 0.8, 0.8], join([quad([3, 0, 5], [-6, 0, 0], [0, 3, 0]), quad([-3, 0, 5], [0, 0, -2], [0, 3, 0]), quad([3, 0, 3], [0, 0, 2], [0, 3, 0])])),
  { name: "floor", color: [1, 1, 1], texture: checkerboard(16, 16, [0.25, 0.14, 0.07], [0.4, 0.25, 0.13]),
    mesh: quad([-3, 0, 5], [6, 0, 0], [0, 0, -8]), material: DEFAULT(0.2) }];

const leg = (x, z) => box([x, 0, z], [x + 0.05, 0.8, z + 0.05]);
const furniture = () => [
  { name: "table", color: [0.9, 0.95, 0.93], mesh: box([-1, 0.8, -1], [1, 0.84, 0.4]), material: glass(0, 2, [0.8, 0.95, 0.9]) },
  { name: "legs", color: [0.8, 0.8, 0.8], mesh: join([leg(-0.95, -0.95), leg(0.9, -0.95), leg(-0.95, 0.3), leg(0.9, 0.3)]), material: METAL(0.2) },
  { name: "vase", color: [1, 1, 1], mesh: sphere([-0.4, 1.14, -0.3], 0.3), material: glass(0, 1, [0.6, 0.8, 1]) },
  { name: "gold", color: [1, 0.76, 0.34], mesh: sphere([0.4, 1.06, -0.5], 0.22), material: METAL(0.15) },
  { name: "cup", color: [0.9, 0.9, 0.85], mesh: sphere([0.5, 0.98, 0.1], 0.14), material: DEFAULT(0.3) },
  { name: "sofa", color: [0.2, 0.3, 0.45], mesh: join([box([-2.9, 0, -2.6], [-2, 0.5, 0]), box([-2.9, 0.5, -2.6], [-2.6, 1, 0])]), material: DEFAULT(0.8) },
  { name: "mirror", color: [0.95, 0.95, 0.95], mesh: quad([0.8, 1.2, -2.98], [1.2, 0, 0], [0, 1.2, 0]), material: METAL(0) },
  { name: "lamp", color: [0, 0, 0], emission: [25, 20, 13], mesh: sphere([-2.3, 1.7, -2.3], 0.18) },
  { name: "globe", color: [1, 1, 1], mesh: sphere([-2.3, 1.7, -2.3], 0.26), material: glass(0.3, 3, [1, 0.95, 0.85]) }];

// A grey green garden under a sky; the sun is five degrees wide.
function garden(direction) {
  const facing = direction.reduce((sum, v, i) => sum + v * SUN[i], 0), sun = facing > 0.99905 ? 900 : 0;
  return direction[1] < 0 ? [0.1, 0.14, 0.08] : [0.4 + sun, 0.5 + 0.9 * sun, 0.7 + 0.75 * sun];
}

export const ROOM_NAMES = ["room", "room_night"];

// Writes what has to be written to `folder`; width: of the pictures.
export function roomScenes(folder, width) {
  const file = `${folder}/room.glb`, hdr = `${folder}/room.hdr`;
  mkdirSync(folder, { recursive: true });
  writeFileSync(file, glbOf([...walls(), ...furniture()]));
  writeFileSync(hdr, radiance(256, 128, garden));
  const job = { scene: { file, camera: CAMERA }, image: { width, height: Math.round(0.75 * width) },
    effects: { indirect_bounces: 8 }, layers: ["beauty"] };
  return [{ name: ROOM_NAMES[0], about: "a room by day, a lamp in frosted glass, eight bounces", job: { ...job, environment: { file: hdr } } },
    { name: ROOM_NAMES[1], about: "the same at night", job }];
}
