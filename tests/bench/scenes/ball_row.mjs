// A row of balls of one radius, a material each, as a GLB file with a camera.
import { packGlb } from "./glb.mjs";

const RINGS = 48, SECTORS = 96, APART = 2.3;

function sphere() {
  const positions = [], indices = [];
  for (let i = 0; i <= RINGS; i++)
    for (let j = 0; j <= SECTORS; j++) {
      const a = Math.PI * i / RINGS, b = 2 * Math.PI * j / SECTORS;
      positions.push(Math.sin(a) * Math.sin(b), Math.cos(a), Math.sin(a) * Math.cos(b));
    }
  for (let i = 0; i < RINGS; i++)
    for (let j = 0; j < SECTORS; j++) {
      const k = i * (SECTORS + 1) + j, l = k + SECTORS + 1;
      if (i > 0) indices.push(k, l, k + 1);
      if (i < RINGS - 1) indices.push(k + 1, l, l + 1);
    }
  return { positions, indices };
}

// Stripes from black to white behind the balls, that glass bends.
function stripes(width) {
  const positions = [], indices = [];
  for (let k = 0; k < 2 * width; k += 2) {
    const x = (k - width) / 2 * 1.2, at = positions.length / 3;
    positions.push(x, -3, -2, x + 0.6, -3, -2, x + 0.6, 3, -2, x, 3, -2);
    indices.push(at, at + 1, at + 2, at, at + 2, at + 3);
  }
  return { positions, indices };
}

// `behind`: stripes stand behind them. `lamp`: only a lamp behind and below them shines.
export function balls(materials, { behind = false, lamp = false } = {}) {
  const meshes = [sphere(), ...(behind ? [stripes(12)] : [])], pieces = [], views = [], accessors = [];
  let offset = 0;
  const add = (array, componentType, type, more = {}) => {
    const bytes = Buffer.from(array.buffer);
    pieces.push(bytes);
    views.push({ buffer: 0, byteOffset: offset, byteLength: bytes.length });
    accessors.push({ bufferView: views.length - 1, componentType, count: array.length / (type === "VEC3" ? 3 : 1), type, ...more });
    offset += bytes.length;
    return accessors.length - 1;
  };
  const made = meshes.map(({ positions, indices }) => {
    const at = (k, f) => positions.filter((_, i) => i % 3 === k).reduce((a, b) => f(a, b));
    const floats = Float32Array.from(positions);
    return { POSITION: add(floats, 5126, "VEC3", { min: [0, 1, 2].map((k) => Math.fround(at(k, Math.min))), max: [0, 1, 2].map((k) => Math.fround(at(k, Math.max))) }),
      indices: add(Uint32Array.from(indices), 5125, "SCALAR") };
  });
  const normals = made[0].POSITION; // of a ball of radius 1
  const all = [...materials, { pbrMetallicRoughness: { baseColorFactor: [0.9, 0.9, 0.9, 1], metallicFactor: 0 }, doubleSided: true }];
  const used = [...new Set(all.flatMap((m) => Object.keys(m.extensions ?? {})))];
  const nodes = materials.map((_, i) => ({ mesh: i, translation: [APART * (i - (materials.length - 1) / 2), 0, 0] }));
  if (behind) nodes.push({ mesh: materials.length });
  if (lamp) nodes.push({ translation: [0, 1, -9], extensions: { KHR_lights_punctual: { light: 0 } } });
  nodes.push({ camera: 0, translation: [0, 0, 22] });
  return packGlb({ asset: { version: "2.0", copyright: "CC0" }, scene: 0, scenes: [{ nodes: nodes.map((_, i) => i) }], nodes,
    extensionsUsed: [...used, ...(lamp ? ["KHR_lights_punctual"] : [])],
    ...(lamp ? { extensions: { KHR_lights_punctual: { lights: [{ type: "point", intensity: 400 }] } } } : {}),
    cameras: [{ type: "perspective", perspective: { yfov: 0.4, znear: 0.1 } }], materials: all,
    meshes: [...materials.map((_, i) => ({ primitives: [{ attributes: { POSITION: made[0].POSITION, NORMAL: normals }, indices: made[0].indices, material: i }] })),
      ...(behind ? [{ primitives: [{ attributes: { POSITION: made[1].POSITION }, indices: made[1].indices, material: materials.length }] }] : [])],
    accessors, bufferViews: views, buffers: [{ byteLength: offset }] }, Buffer.concat(pieces));
}
