// What real scenes are made of, small and from nothing but the repository: the shipped box, and blocks, sticks and
// balls of glTF's default material and of metals under a sky with a bright patch. For the small bench.
import { mkdirSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { glbOf } from "./glb.mjs";
import { radiance } from "./hdr.mjs";
import { box, floor, join, sphere, stick, turned, unit } from "./mesh.mjs";
import { checkerboard } from "./png.mjs";

const DEFAULT = { specular: 1 }; // as a file has it that says nothing of the specular layer
const PATCH = unit([0.5, 0.6, 0.62]);

export function blocks() {
  const sticks = Array.from({ length: 9 }, (_, i) => stick([-1.6 + 0.4 * i, 0, 0.9 - 0.05 * i], [-1.5 + 0.4 * i, 0.9, 0.8], 0.04));
  return [
    { name: "floor", color: [1, 1, 1], texture: checkerboard(12, 12, [0.35, 0.33, 0.3], [0.6, 0.6, 0.62]), mesh: floor(4), material: DEFAULT },
    { name: "tall", color: [0.55, 0.5, 0.45], mesh: turned(box([-0.35, 0, -0.35], [0.35, 1.5, 0.35]), 0.4, [-0.9, 0, -0.6]), material: DEFAULT },
    { name: "low", color: [0.6, 0.2, 0.15], mesh: turned(box([-0.4, 0, -0.3], [0.4, 0.5, 0.3]), -0.6, [0.9, 0, 0.2]), material: { ...DEFAULT, roughness: 0.5 } },
    { name: "sticks", color: [0.2, 0.4, 0.25], mesh: join(sticks), material: DEFAULT },
    { name: "ball", color: [0.25, 0.35, 0.7], mesh: sphere([0.1, 0.45, -0.5], 0.45), material: { ...DEFAULT, roughness: 0.3 } },
    { name: "metal", color: [0.9, 0.75, 0.5], mesh: sphere([1.2, 0.9, -0.7], 0.4), material: { metallic: 1, roughness: 0.35 } }];
}

// Blue above, grey below, and a window's worth of light.
function sky(direction) {
  const up = Math.max(direction[1], 0), facing = direction.reduce((sum, v, i) => sum + v * PATCH[i], 0);
  const bright = 40 * Math.max(0, Math.min(1, (facing - 0.93) / 0.03));
  return direction[1] < 0 ? [0.15, 0.14, 0.13] : [0.35 + bright, 0.45 + 0.2 * up + 0.95 * bright, 0.55 + 0.45 * up + 0.85 * bright];
}

export const SMALL_NAMES = ["real_box", "real_blocks"];

// Writes what has to be written to `folder`; width: of the pictures.
export function smallScenes(folder, width) {
  mkdirSync(folder, { recursive: true });
  const glb = `${folder}/real_blocks.glb`, hdr = `${folder}/real_sky.hdr`, image = { width, height: Math.round(0.75 * width) };
  writeFileSync(glb, glbOf(blocks()));
  writeFileSync(hdr, radiance(64, 32, sky));
  return [
    { name: SMALL_NAMES[0], about: "the shipped Cornell box, four bounces",
      job: { scene: { file: resolve("tests/scenes/cornell-box/cornell-box.glb") }, image, effects: { indirect_bounces: 4 }, layers: ["beauty"] } },
    { name: SMALL_NAMES[1], about: "blocks, sticks and balls of glTF's materials under a sky with a bright patch, two bounces",
      job: { scene: { file: glb, camera: { eye: [0.6, 1.9, 4.6], target: [0.1, 0.5, 0], yfov_deg: 40 } }, environment: { file: hdr }, image,
        effects: { indirect_bounces: 2 }, layers: ["beauty"] } }];
}
