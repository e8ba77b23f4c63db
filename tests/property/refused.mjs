// A scene with NaN or infinity is refused with its place named: a number of a glTF file, drawn from a seed, is
// made one of them, in its arrays or in its document. TAP.
//   refused.mjs BUILD [runs=N] [seed=N]
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { glbOf } from "../bench/scenes/glb.mjs";
import { floor, sphere } from "../bench/scenes/mesh.mjs";
import { checkerboard } from "../bench/scenes/png.mjs";

const [build, ...words] = process.argv.slice(2), given = Object.fromEntries(words.map((w) => w.split("=")));
const RUNS = Number(given.runs ?? 60), SEED = Number(given.seed ?? 1);
const folder = mkdtempSync(`${tmpdir()}/refused-`), ARRAYS = { POSITION: "positions", NORMAL: "normals", TEXCOORD_0: "uvs" };

// SplitMix32.
function random(seed) {
  let state = seed >>> 0;
  return (n) => {
    state = state + 0x9e3779b9 >>> 0;
    let v = state;
    v = Math.imul(v ^ v >>> 16, 0x21f0aaad);
    v = Math.imul(v ^ v >>> 15, 0x735a2d97);
    return ((v ^ v >>> 15) >>> 0) % n;
  };
}

const parts = (glb) => {
  const size = glb.readUInt32LE(12);
  return { document: JSON.parse(glb.subarray(20, 20 + size)), binary: glb.subarray(20 + size), at: 20 + size + 8 };
};

function scene() {
  const glb = glbOf([{ name: "floor", color: [0.5, 0.5, 0.5], texture: checkerboard(2, 2, [0, 0, 0], [1, 1, 1]), mesh: floor(2) },
    { name: "ball", color: [0.7, 0.2, 0.2], mesh: sphere([0, 1, 0], 0.5, 8) }]);
  const { document, binary } = parts(glb);
  Object.assign(document.nodes[0], { translation: [0.5, 0, 0], rotation: [0, 0, 0, 1], scale: [1, 2, 1] });
  document.nodes[1].matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0.25, 1];
  document.nodes.push({ camera: 0, translation: [0, 1, 5] }, { extensions: { KHR_lights_punctual: { light: 0 } } });
  document.scenes[0].nodes.push(2, 3);
  document.cameras = [{ type: "perspective", perspective: { yfov: 0.8, znear: 0.1, aspectRatio: 1 } }];
  document.extensionsUsed.push("KHR_lights_punctual", "KHR_materials_emissive_strength");
  document.extensions = { KHR_lights_punctual: { lights: [{ type: "spot", color: [1, 1, 1], intensity: 5, range: 20, spot: { innerConeAngle: 0.1, outerConeAngle: 0.5 } }] } };
  Object.assign(document.materials[1], { emissiveFactor: [0.1, 0.2, 0.3] });
  document.materials[1].extensions.KHR_materials_emissive_strength = { emissiveStrength: 2 };
  return { document, binary };
}

function pack(text, binary) {
  const json = Buffer.from(text + " ".repeat((4 - Buffer.byteLength(text) % 4) % 4)), head = Buffer.alloc(20);
  head.writeUInt32LE(0x46546c67, 0);
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(20 + json.length + binary.length, 8);
  head.writeUInt32LE(json.length, 12);
  head.writeUInt32LE(0x4e4f534a, 16);
  return Buffer.concat([head, json, binary]);
}

// One number of an array: {glb, place: what the refusal must name}.
function inArray(draw, { document, binary }) {
  const mesh = draw(document.meshes.length), attributes = document.meshes[mesh].primitives[0].attributes, names = Object.keys(attributes), name = names[draw(names.length)];
  const accessor = document.accessors[attributes[name]], view = document.bufferViews[accessor.bufferView], width = { VEC2: 2, VEC3: 3 }[accessor.type];
  const element = draw(accessor.count), component = draw(width), value = [NaN, Infinity, -Infinity][draw(3)], bytes = Buffer.from(binary);
  bytes.writeFloatLE(value, 8 + (view.byteOffset ?? 0) + 4 * (width * element + component));
  return { glb: pack(JSON.stringify(document), bytes), what: `${name} ${element}.${component} of mesh ${mesh} is ${value}`,
    place: [`meshes[${mesh}]`, `${ARRAYS[name]}[${element}]`] };
}

// Places of all numbers that are lengths, colours, angles and such; not of indices and counts.
function numbers(value, path, found) {
  if (typeof value === "number") found.push(path);
  else if (value && typeof value === "object") for (const [key, inner] of Object.entries(value)) numbers(inner, [...path, key], found);
  return found;
}
// Indices; and a near plane, which nothing here has.
const NAMES = ["nodes", "materials", "cameras", "extensions"], UNUSED = ["mesh", "camera", "light", "index", "texCoord", "znear"];

// One number of the document, out of all range of floats.
function inDocument(draw, { document, binary }) {
  const places = NAMES.flatMap((name) => numbers(document[name], [name], [])).filter((path) => !UNUSED.includes(path.at(-1)));
  const path = places[draw(places.length)], mark = "\"the number\"", last = path.at(-1), owner = path.slice(0, -1).reduce((o, key) => o[key], document);
  owner[last] = "the number";
  const value = ["1e999", "-1e999", "1e39"][draw(3)];
  return { glb: pack(JSON.stringify(document).replace(mark, value), binary), what: `${path.join(".")} is ${value}`, place: [path[0] === "extensions" ? "light" : path[0]] };
}

let count = 0, failed = 0;
const test = (holds, text) => { count++; failed += holds ? 0 : 1; console.log(`${holds ? "" : "not "}ok ${count} - ${text}`); };

function refusal(glb) {
  writeFileSync(`${folder}/scene.glb`, glb);
  const { status, stdout, stderr } = spawnSync(`${build}/shearwater-import`, ["--root", folder, "--in", "scene.glb", "--out", `${folder}/scene.blob`], { encoding: "utf8" });
  return { status, said: JSON.parse(stdout.split("\n").find((l) => l.startsWith("{")) ?? `{"detail": ${JSON.stringify(stderr)}}`) };
}

const plain = scene();
test(refusal(pack(JSON.stringify(plain.document), plain.binary)).status === 0, "the scene as it is is taken");
for (const [name, draw] of [["arrays", inArray], ["the document", inDocument]]) {
  const wrong = [];
  for (let seed = SEED; seed < SEED + RUNS; seed++) {
    const { glb, what, place } = draw(random(seed), scene()), { status, said } = refusal(glb);
    // A parser that has no such numbers names the byte instead.
    const named = place.every((words) => `${said.pointer} ${said.detail}`.includes(words)) || (name === "the document" && /number|real/i.test(said.detail ?? ""));
    if (status !== 1 || said.ok !== false || !named) wrong.push(`# seed ${seed}: ${what}: status ${status}, ${JSON.stringify(said)}`);
  }
  for (const line of wrong.slice(0, 5)) console.log(line);
  test(wrong.length === 0, `${name}: ${RUNS} numbers from seed ${SEED} that are not finite, ${wrong.length} taken or refused without their place`);
}
rmSync(folder, { recursive: true });
console.log(`1..${count}`);
process.exit(failed > 0 ? 1 : 0);
