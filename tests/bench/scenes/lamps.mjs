// A hundred lights of all kinds over a yard: strings of bulbs, lanterns, discs, panels, points and spots. No one of
// them lights much of what is seen, and each lights something strongly.
import { mkdirSync, writeFileSync } from "node:fs";
import { glbOf } from "./glb.mjs";
import { box, floor, join, quad, sphere, stick, turned, unit } from "./mesh.mjs";
import { checkerboard } from "./png.mjs";

const DEFAULT = { specular: 1 }; // as a file has it that says nothing of the specular layer
const TINTS = [[1, 0.72, 0.42], [1, 0.85, 0.65], [0.65, 0.8, 1], [1, 0.4, 0.3], [0.5, 1, 0.6]];

// Fractions of i times an irrational number: even, and the same everywhere.
const even = (i, by) => (i * by) % 1;
const spread = (i) => [even(i + 1, 0.7548776662), even(i + 1, 0.5698402910), even(i + 1, 0.6180339887)];
const tinted = (i, level) => TINTS[i % TINTS.length].map((c) => c * level);

function yard() {
  const sticks = Array.from({ length: 12 }, (_, i) => stick([-3.3 + 0.6 * i, 0, -2.2], [-3.3 + 0.6 * i, 1.1, -2.2], 0.05, 12));
  const blocks = Array.from({ length: 14 }, (_, i) => {
    const [a, b, c] = spread(i), s = 0.16 + 0.22 * c;
    return turned(box([-s, 0, -s], [s, 0.3 + 1.1 * b, s]), 3 * c, [-3.4 + 6.8 * a, 0, -1.8 + 3.8 * b]);
  });
  return [
    { name: "floor", color: [1, 1, 1], texture: checkerboard(16, 16, [0.35, 0.33, 0.3], [0.6, 0.6, 0.62]), mesh: floor(4), material: DEFAULT },
    { name: "back", color: [0.6, 0.58, 0.55], mesh: quad([-4, 0, -3], [8, 0, 0], [0, 4, 0]), material: DEFAULT },
    { name: "side", color: [0.5, 0.55, 0.6], mesh: quad([-4, 0, 4], [0, 0, -7], [0, 4, 0]), material: DEFAULT },
    { name: "sticks", color: [0.2, 0.4, 0.25], mesh: join(sticks), material: DEFAULT },
    { name: "blocks", color: [0.55, 0.5, 0.45], mesh: join(blocks), material: { ...DEFAULT, roughness: 0.5 } },
    { name: "ball", color: [0.25, 0.35, 0.7], mesh: sphere([0.4, 0.5, 0.6], 0.5), material: { ...DEFAULT, roughness: 0.3 } },
    { name: "metal", color: [0.9, 0.75, 0.5], mesh: sphere([2.2, 0.45, 1.3], 0.45), material: { metallic: 1, roughness: 0.35 } }];
}

// Forty bulbs on two strings, one along each wall.
function bulbs() {
  return Array.from({ length: 40 }, (_, i) => {
    const t = (i % 20 + 0.5) / 20, sag = 2.6 - 1.2 * 4 * t * (1 - t) * (i < 20 ? 0.5 : 0.8);
    const at = i < 20 ? [-3.8 + 7.6 * t, sag, -2.75] : [-3.75, sag, -2.8 + 6.4 * t];
    return { name: `bulb ${i}`, emission: tinted(i, 60), mesh: sphere(at, 0.035, 8) };
  });
}

// Fifteen lanterns between the blocks.
const lanterns = () => Array.from({ length: 15 }, (_, i) => {
  const [a, b, c] = spread(i + 40);
  return { name: `lantern ${i}`, emission: tinted(i + 1, 12), mesh: sphere([-3.4 + 6.8 * a, 0.08 + 0.3 * c, -1.9 + 4.4 * b], 0.07, 16) };
});

// A round plate around `at` that shines along `normal`.
function disc(at, normal, radius) {
  const whole = stick(at.map((x, k) => x - 1e-3 * normal[k]), at, radius, 16), plate = { positions: [], normals: [], uvs: [], indices: [] };
  const first = 34, count = 34; // its upper end
  plate.positions = whole.positions.slice(3 * first, 3 * (first + count));
  plate.normals = whole.normals.slice(3 * first, 3 * (first + count));
  plate.uvs = whole.uvs.slice(2 * first, 2 * (first + count));
  plate.indices = whole.indices.slice(96, 192).map((i) => i - first);
  return plate;
}

// Fifteen discs under the sky that look down, aslant.
const discs = () => Array.from({ length: 15 }, (_, i) => {
  const [a, b, c] = spread(i + 60), normal = unit([a - 0.5, -1, c - 0.5]);
  return { name: `disc ${i}`, emission: tinted(i + 2, 7), mesh: disc([-3.5 + 7 * a, 2.2 + c, -2.5 + 5 * b], normal, 0.12 + 0.1 * c), oneSided: true };
});

// Ten panels on the walls, which are recognised as rectangles.
const panels = () => Array.from({ length: 10 }, (_, i) => {
  const x = -3.4 + 0.75 * i, y = 0.25 + 0.2 * (i % 3);
  return { name: `panel ${i}`, emission: tinted(i, 5), mesh: quad([x, y, -2.98], [0.3, 0, 0], [0, 0.12, 0]), oneSided: true };
});

// Twelve points and eight spots of the job.
function listed() {
  const points = Array.from({ length: 12 }, (_, i) => {
    const [a, b, c] = spread(i + 80);
    return { type: "point", position: [-3.6 + 7.2 * a, 0.25 + 1.2 * c, -2.4 + 5 * b], intensity: tinted(i, 0.12) };
  });
  const spots = Array.from({ length: 8 }, (_, i) => {
    const [a, b] = spread(i + 95), direction = unit([0.4 - a, -1, b - 0.6]);
    return { type: "spot", position: [-3 + 6 * a, 3, -1.8 + 3.4 * b], direction, inner_deg: 10, outer_deg: 18, intensity: tinted(i + 3, 3) };
  });
  return [...points, ...spots];
}

export const LAMPS = "lamps";

// Writes what has to be written to `folder`; width: of the picture.
export function lampsScene(folder, width) {
  mkdirSync(folder, { recursive: true });
  const glb = `${folder}/lamps.glb`;
  writeFileSync(glb, glbOf([...yard(), ...bulbs(), ...lanterns(), ...discs(), ...panels()].map((p) => ({ color: [0, 0, 0], ...p }))));
  return { name: LAMPS, about: "a yard under a hundred lights of all kinds, two bounces",
    job: { scene: { file: glb, camera: { eye: [1.4, 2.3, 6.2], target: [-0.2, 0.75, -0.3], yfov_deg: 42 } }, lights: listed(),
      image: { width, height: Math.round(0.75 * width) }, effects: { indirect_bounces: 2 }, layers: ["beauty"] } };
}
