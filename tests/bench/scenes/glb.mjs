// GLB files: made from meshes, or from files of others.
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";

const MAGIC = 0x46546c67, JSON_CHUNK = 0x4e4f534a, BINARY_CHUNK = 0x004e4942;

function chunk(type, data, padding) {
  const padded = Buffer.concat([data, Buffer.alloc((4 - data.length % 4) % 4, padding)]);
  const header = Buffer.alloc(8);
  header.writeUInt32LE(padded.length, 0);
  header.writeUInt32LE(type, 4);
  return Buffer.concat([header, padded]);
}

export function packGlb(document, binary) {
  const chunks = [chunk(JSON_CHUNK, Buffer.from(JSON.stringify(document)), " "), chunk(BINARY_CHUNK, binary, 0)];
  const header = Buffer.alloc(12);
  header.writeUInt32LE(MAGIC, 0);
  header.writeUInt32LE(2, 4);
  header.writeUInt32LE(12 + chunks[0].length + chunks[1].length, 8);
  return Buffer.concat([header, ...chunks]);
}

// The same file with a document that `change` has had in its hands.
export function changeGlb(glb, change) {
  const { document, binary } = unpack(glb);
  change(document);
  return packGlb(document, binary);
}

function unpack(glb) {
  const jsonSize = glb.readUInt32LE(12), rest = glb.subarray(20 + jsonSize);
  return { document: JSON.parse(glb.subarray(20, 20 + jsonSize).toString()),
    binary: rest.subarray(8, 8 + rest.readUInt32LE(0)) };
}

// Of what shines; with a strength beyond 1 the factor is what is left.
function shining(emission) {
  const most = Math.max(1, ...emission);
  return { factor: emission.map((x) => x / most), ...(most > 1 ? { KHR_materials_emissive_strength: { emissiveStrength: most } } : {}) };
}

// Lambert unless more is said: {metallic, roughness, specular, extensions}, {anisotropy: [strength, rotation]} or another
// {model} with its members. The texture is an index or undefined.
const surface = (name, color, { metallic = 0, roughness = 1, specular = 0, anisotropy, model, extensions = {} } = {}, texture, { emission, oneSided = false } = {}) => {
  const { factor, ...strength } = emission ? shining(emission) : {};
  return { name, doubleSided: !oneSided, ...(emission ? { emissiveFactor: factor } : {}),
  pbrMetallicRoughness: { baseColorFactor: [...color, 1], metallicFactor: metallic, roughnessFactor: roughness,
    ...(texture === undefined ? {} : { baseColorTexture: { index: texture } }) },
  extensions: { KHR_materials_specular: { specularFactor: specular }, ...strength, ...extensions, ...(anisotropy ?
    { KHR_materials_anisotropy: { anisotropyStrength: anisotropy[0], anisotropyRotation: anisotropy[1] } } : {}) },
  ...(model ? { extras: { shearwater: model } } : {}) };
};
const lambert = (name, color) => surface(name, color);

function extremes(positions) {
  const min = [Infinity, Infinity, Infinity], max = [-Infinity, -Infinity, -Infinity];
  positions.forEach((x, i) => {
    min[i % 3] = Math.min(min[i % 3], Math.fround(x));
    max[i % 3] = Math.max(max[i % 3], Math.fround(x));
  });
  return { min, max };
}

const empty = () => ({ document: { asset: { version: "2.0", generator: "shearwater bench", copyright: "CC0" },
  extensionsUsed: ["KHR_materials_specular"], scene: 0, scenes: [{ nodes: [] }],
  nodes: [], meshes: [], materials: [], accessors: [], bufferViews: [], buffers: [] }, binary: Buffer.alloc(0) });

const ADDED = { nodes: [], meshes: [], materials: [], accessors: [], bufferViews: [], images: [], samplers: [], textures: [] };
const NEAREST = 9728, REPEAT = 10497;

// Puts bytes behind what is there; returns what adds views of them.
function appender(base) {
  const pieces = [base.binary];
  let offset = base.binary.length;
  const view = (bytes, more) => {
    const gap = (4 - offset % 4) % 4;
    pieces.push(Buffer.alloc(gap), bytes);
    base.document.bufferViews.push({ buffer: 0, byteOffset: offset + gap, byteLength: bytes.length, ...more });
    offset += gap + bytes.length;
    return base.document.bufferViews.length - 1;
  };
  return { view, bytes: () => Buffer.concat(pieces) };
}

function addTexture(document, view, png) {
  document.images.push({ bufferView: view(png), mimeType: "image/png" });
  document.samplers.push({ magFilter: NEAREST, minFilter: NEAREST, wrapS: REPEAT, wrapT: REPEAT });
  document.textures.push({ source: document.images.length - 1, sampler: document.samplers.length - 1 });
  return document.textures.length - 1;
}

function addPart(document, view, { name, color, mesh, material, texture, emission, oneSided }) {
  const accessor = (data, type, componentType, target, more) => {
    const bytes = Buffer.from(data.buffer, data.byteOffset, data.byteLength);
    document.accessors.push({ bufferView: view(bytes, { target }), componentType, type,
      count: data.length / ({ VEC3: 3, VEC2: 2 }[type] ?? 1), ...more });
    return document.accessors.length - 1;
  };
  const index = texture && addTexture(document, view, texture);
  document.materials.push(surface(name, color, material, index, { emission, oneSided }));
  document.meshes.push({ name, primitives: [{ material: document.materials.length - 1,
    attributes: {
      POSITION: accessor(Float32Array.from(mesh.positions), "VEC3", 5126, 34962, extremes(mesh.positions)),
      NORMAL: accessor(Float32Array.from(mesh.normals), "VEC3", 5126, 34962),
      ...(texture || material?.anisotropy || material?.model ? { TEXCOORD_0: accessor(Float32Array.from(mesh.uvs), "VEC2", 5126, 34962) } : {}) },
    indices: accessor(Uint32Array.from(mesh.indices), "SCALAR", 5125, 34963) }] });
  document.nodes.push({ name, mesh: document.meshes.length - 1 });
  document.scenes[document.scene ?? 0].nodes.push(document.nodes.length - 1);
}

// parts: [{name, color, mesh, material, texture}], the last two optional (a texture is a PNG's bytes),
// beside what is in `base` {document, binary}, which is changed.
export function glbOf(parts, base = empty()) {
  const { document } = base, { view, bytes } = appender(base);
  for (const [name, none] of Object.entries(ADDED)) document[name] ??= none.slice();
  for (const part of parts) addPart(document, view, part);
  for (const name of Object.keys(ADDED)) if (document[name].length === 0) delete document[name];
  const used = document.materials.flatMap((m) => Object.keys(m.extensions ?? {}));
  document.extensionsUsed = [...new Set([...(document.extensionsUsed ?? []), ...used])];
  const binary = bytes();
  document.buffers = [{ byteLength: binary.length }];
  return packGlb(document, binary);
}

// The same file with a camera of its own and one animation. tracks: [{node, path, times, values}], a node by
// its name ("camera": that one), values in a row. camera: {eye, target, yfov_deg}.
export function animated(glb, camera, tracks) {
  const base = unpack(glb), { document } = base, { view, bytes } = appender(base);
  const floats = (numbers, type, n, more) => {
    document.accessors.push({ bufferView: view(Buffer.from(Float32Array.from(numbers).buffer)), componentType: 5126, type, count: numbers.length / n, ...more });
    return document.accessors.length - 1;
  };
  for (const node of document.nodes) if (node.camera !== undefined) Object.assign(node, { name: "before", camera: undefined });
  document.cameras = [{ type: "perspective", perspective: { yfov: camera.yfov_deg * Math.PI / 180, znear: 0.01 } }];
  document.nodes.push({ name: "camera", camera: 0, translation: camera.eye, rotation: facing(camera.eye, camera.target) });
  document.scenes[document.scene ?? 0].nodes.push(document.nodes.length - 1);
  const animation = { name: "all", samplers: [], channels: [] };
  for (const { node, path, times, values } of tracks) {
    const input = floats(times, "SCALAR", 1, { min: [Math.fround(Math.min(...times))], max: [Math.fround(Math.max(...times))] });
    const n = path === "rotation" ? 4 : 3;
    animation.samplers.push({ input, output: floats(values, `VEC${n}`, n), interpolation: "LINEAR" });
    animation.channels.push({ sampler: animation.samplers.length - 1,
      target: { node: document.nodes.findIndex((one) => one.name === node), path } });
  }
  if (tracks.length > 0) document.animations = [animation];
  const binary = bytes();
  document.buffers = [{ byteLength: binary.length }];
  return packGlb(document, binary);
}

// The rotation of a camera at `eye` that looks at `target`: first up or down, then round.
export function facing(eye, target) {
  const [x, y, z] = target.map((t, i) => t - eye[i]), round = Math.atan2(-x, -z), up = Math.atan2(y, Math.hypot(x, z));
  const [cr, sr, cu, su] = [Math.cos(round / 2), Math.sin(round / 2), Math.cos(up / 2), Math.sin(up / 2)];
  return [cr * su, sr * cu, -sr * su, cr * cu];
}

// Another's .gltf with its one buffer and its images, for glbOf; meshes whose materials match
// `without` are dropped.
export function gltfBase(file, without) {
  const document = JSON.parse(readFileSync(file, "utf8")), beside = (uri) => readFileSync(join(dirname(file), uri));
  const base = { document, binary: beside(document.buffers[0].uri) }, { view, bytes } = appender(base);
  for (const image of document.images ?? []) {
    image.bufferView = view(beside(image.uri));
    image.mimeType = /png$/i.test(image.uri) ? "image/png" : "image/jpeg";
    delete image.uri;
  }
  for (const node of document.nodes)
    if (node.mesh !== undefined && document.meshes[node.mesh].primitives.some((p) => without.test(document.materials[p.material].name)))
      delete node.mesh;
  return { document, binary: bytes() };
}

// Drops meshes whose materials match `without`.
function drop(document, without) {
  const gone = document.materials.map((m) => without.test(m.name ?? ""));
  for (const mesh of document.meshes)
    mesh.primitives = mesh.primitives.filter((p) => !gone[p.material]);
  for (const node of document.nodes)
    if (node.mesh !== undefined && document.meshes[node.mesh].primitives.length === 0) delete node.mesh;
  // A mesh without primitives is no glTF.
  const kept = document.meshes.map((m) => m.primitives.length > 0);
  const at = kept.map((_, i) => kept.slice(0, i).filter(Boolean).length);
  document.meshes = document.meshes.filter((_, i) => kept[i]);
  for (const node of document.nodes) if (node.mesh !== undefined) node.mesh = at[node.mesh];
}

// Another's GLB as it is; meshes whose materials match `without` are dropped.
export function glbWithout(glb, without) {
  const { document, binary } = unpack(glb);
  drop(document, without);
  return packGlb(document, binary);
}

// The same with every material made Lambert and lights left out.
export function lambertOf(glb, without) {
  const { document, binary } = unpack(glb);
  document.materials = document.materials.map((m) =>
    lambert(m.name, (m.pbrMetallicRoughness?.baseColorFactor ?? [1, 1, 1]).slice(0, 3)));
  drop(document, without);
  for (const node of document.nodes) delete node.extensions;
  delete document.extensions;
  delete document.extensionsRequired;
  document.extensionsUsed = ["KHR_materials_specular"];
  return packGlb(document, binary);
}
