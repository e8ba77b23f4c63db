// GLB files of Lambert surfaces alone: made from meshes, or from files of others.

const MAGIC = 0x46546c67, JSON_CHUNK = 0x4e4f534a, BINARY_CHUNK = 0x004e4942;

function chunk(type, data, padding) {
  const padded = Buffer.concat([data, Buffer.alloc((4 - data.length % 4) % 4, padding)]);
  const header = Buffer.alloc(8);
  header.writeUInt32LE(padded.length, 0);
  header.writeUInt32LE(type, 4);
  return Buffer.concat([header, padded]);
}

function pack(document, binary) {
  const chunks = [chunk(JSON_CHUNK, Buffer.from(JSON.stringify(document)), " "), chunk(BINARY_CHUNK, binary, 0)];
  const header = Buffer.alloc(12);
  header.writeUInt32LE(MAGIC, 0);
  header.writeUInt32LE(2, 4);
  header.writeUInt32LE(12 + chunks[0].length + chunks[1].length, 8);
  return Buffer.concat([header, ...chunks]);
}

function unpack(glb) {
  const jsonSize = glb.readUInt32LE(12), rest = glb.subarray(20 + jsonSize);
  return { document: JSON.parse(glb.subarray(20, 20 + jsonSize).toString()),
    binary: rest.subarray(8, 8 + rest.readUInt32LE(0)) };
}

const lambert = (name, color) => ({
  name, doubleSided: true,
  pbrMetallicRoughness: { baseColorFactor: [...color, 1], metallicFactor: 0, roughnessFactor: 1 },
  extensions: { KHR_materials_specular: { specularFactor: 0 } } });

function extremes(positions) {
  const min = [Infinity, Infinity, Infinity], max = [-Infinity, -Infinity, -Infinity];
  positions.forEach((x, i) => {
    min[i % 3] = Math.min(min[i % 3], Math.fround(x));
    max[i % 3] = Math.max(max[i % 3], Math.fround(x));
  });
  return { min, max };
}

// parts: [{name, color, mesh}]
export function glbOf(parts) {
  const document = { asset: { version: "2.0", generator: "shearwater bench", copyright: "CC0" },
    extensionsUsed: ["KHR_materials_specular"], scene: 0, scenes: [{ nodes: parts.map((_, i) => i) }],
    nodes: [], meshes: [], materials: [], accessors: [], bufferViews: [], buffers: [] };
  const pieces = [];
  let offset = 0;
  const accessor = (data, type, componentType, target, more) => {
    const bytes = Buffer.from(data.buffer, data.byteOffset, data.byteLength);
    document.bufferViews.push({ buffer: 0, byteOffset: offset, byteLength: bytes.length, target });
    document.accessors.push({ bufferView: document.bufferViews.length - 1, componentType, type,
      count: data.length / (type === "VEC3" ? 3 : 1), ...more });
    pieces.push(bytes);
    offset += bytes.length;
    return document.accessors.length - 1;
  };
  parts.forEach(({ name, color, mesh }, i) => {
    document.nodes.push({ name, mesh: i });
    document.materials.push(lambert(name, color));
    document.meshes.push({ name, primitives: [{ material: i,
      attributes: {
        POSITION: accessor(Float32Array.from(mesh.positions), "VEC3", 5126, 34962, extremes(mesh.positions)),
        NORMAL: accessor(Float32Array.from(mesh.normals), "VEC3", 5126, 34962) },
      indices: accessor(Uint32Array.from(mesh.indices), "SCALAR", 5125, 34963) }] });
  });
  document.buffers.push({ byteLength: offset });
  return pack(document, Buffer.concat(pieces));
}

// Another's GLB with every material made Lambert; meshes whose materials match `without` are dropped.
export function lambertOf(glb, without) {
  const { document, binary } = unpack(glb);
  const gone = document.materials.map((m) => without.test(m.name ?? ""));
  document.materials = document.materials.map((m) =>
    lambert(m.name, (m.pbrMetallicRoughness?.baseColorFactor ?? [1, 1, 1]).slice(0, 3)));
  for (const mesh of document.meshes)
    mesh.primitives = mesh.primitives.filter((p) => !gone[p.material]);
  for (const node of document.nodes) {
    if (node.mesh !== undefined && document.meshes[node.mesh].primitives.length === 0) delete node.mesh;
    delete node.extensions;
  }
  // A mesh without primitives is no glTF.
  const kept = document.meshes.map((m) => m.primitives.length > 0);
  const at = kept.map((_, i) => kept.slice(0, i).filter(Boolean).length);
  document.meshes = document.meshes.filter((_, i) => kept[i]);
  for (const node of document.nodes) if (node.mesh !== undefined) node.mesh = at[node.mesh];
  delete document.extensions;
  delete document.extensionsRequired;
  document.extensionsUsed = ["KHR_materials_specular"];
  return pack(document, binary);
}
