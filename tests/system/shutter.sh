#!/usr/bin/env bash
# Motion blur: what moves evenly while the shutter is open covers each pixel for a share of the time, and so does
# its shadow, whether it goes as a whole, bends, or the camera moves instead.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/shutter.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash

# A black square of side 1 goes right by 2 units a second before a white wall. Light comes askew, so that its shadow
# lies 1 to the right.
cat >"$tmp/scenes.mjs" <<'J'
import { writeFileSync } from "node:fs";
const folder = process.argv[2];
const floats = [-0.5, -0.5, 0, 0.5, -0.5, 0, 0.5, 0.5, 0, -0.5, 0.5, 0, /* moves by */ 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0,
  /* times */ 0, 1, /* places */ -1, 0, 1, 1, 0, 1, /* the camera's */ 2, 0, 4, 0, 0, 4, /* weights */ -1, 1];
const bytes = Buffer.concat([Buffer.from(new Float32Array(floats).buffer), Buffer.from(new Uint16Array([0, 1, 2, 0, 2, 3]).buffer)]);
const views = [[0, 4, "VEC3"], [12, 4, "VEC3"], [24, 2, "SCALAR"], [26, 2, "VEC3"], [32, 2, "VEC3"], [38, 2, "SCALAR"], [40, 6, "SCALAR", 5123]];
const accessor = ([, count, type, componentType = 5126], bufferView) => ({ bufferView, componentType, count, type });
const size = ([, count, type, component]) => count * (component ? 2 : type === "VEC3" ? 12 : 4);
function scene(name, target, targets) {
  const shape = (material, more) => ({ primitives: [{ attributes: { POSITION: 0 }, indices: 6, material, ...more }] });
  const paths = { square: [0, "translation", 3], camera: [2, "translation", 4], bend: [0, "weights", 5] }, [node, path, output] = paths[target];
  writeFileSync(`${folder}/${name}.gltf`, JSON.stringify({
    asset: { version: "2.0" }, scenes: [{ nodes: [0, 1, 2] }], extensionsUsed: ["KHR_materials_unlit", "KHR_materials_specular"],
    nodes: [{ mesh: 0, translation: [0, 0, 1] }, { mesh: 1, scale: [40, 40, 1] }, { camera: 0, translation: [1, 0, 4] }],
    cameras: [{ type: "orthographic", orthographic: { xmag: 2, ymag: 0.5, znear: 0.1, zfar: 9 } }],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: [0, 0, 0, 1] }, doubleSided: true, extensions: { KHR_materials_unlit: {} } },
      { pbrMetallicRoughness: { metallicFactor: 0, roughnessFactor: 1 }, extensions: { KHR_materials_specular: { specularFactor: 0 } } }],
    meshes: [shape(0, targets ? { targets: [{ POSITION: 1 }] } : {}), shape(1)],
    buffers: [{ byteLength: bytes.length, uri: `data:application/octet-stream;base64,${bytes.toString("base64")}` }],
    bufferViews: views.map((v) => ({ buffer: 0, byteOffset: 4 * v[0], byteLength: size(v) })), accessors: views.map(accessor),
    animations: [{ samplers: [{ input: 2, output }], channels: [{ sampler: 0, target: { node, path } }] }] }));
}
scene("square", "square");
scene("bend", "bend", true);
scene("camera", "camera");
const job = (name, more, file = name.split("_")[0]) => writeFileSync(`${folder}/${name}.json`, JSON.stringify({
  scene: { file: `${folder}/${file}.gltf` }, image: { width: 64, height: 16 }, layers: ["beauty"], fps: 2, frames: { first: 2 },
  lights: [{ type: "directional", direction: [1, 0, -1], irradiance: [3, 3, 3] }], effects: { indirect_bounces: 0 },
  camera: { shutter: 1 }, filter: { method: "none" }, sampling: { spp: 1024 }, ...more }));
for (const name of ["square", "bend", "camera"]) job(name, {});
job("square_late", { camera: { shutter: { fraction: 1, centre: 0.5 } }, start_time_s: -0.25 });
job("square_few", { sampling: { spp: 16 } });
job("square_clean", { sampling: { spp: 16 }, filter: {} });
job("square_rest", { camera: { shutter: null } });
job("square_moment", { scene: { file: `${folder}/square.gltf`, time_s: 0.5 } });
job("square_list", { sampling: { spp: 16 }, filter: {}, frames: "1-4" });
job("square_apart", { sampling: { spp: 16 }, filter: { temporal: "none" }, frames: "1-4" });
job("square_open", { sampling: { spp: 16 }, camera: { shutter: null } });
J
# Compares a picture with the closed form: over a time, [-1/2, 1/2] goes from -1/2 to 1/2.
cat >"$tmp/judge.mjs" <<'J'
import { readFileSync } from "node:fs";
const [root, path] = process.argv.slice(2), { readExr } = await import(`${root}/web/picture/exr_file.js`);
const { buffer, byteOffset, byteLength } = readFileSync(path);
const { width, height, channels } = await readExr(buffer.slice(byteOffset, byteOffset + byteLength));
const red = channels.get("R"), hat = (x) => Math.max(0, 1 - Math.abs(x)), wall = 3 / Math.PI * Math.SQRT1_2;
let squares = 0, most = 0;
for (let x = 0; x < width; x++) {
  let truth = 0;
  for (let k = 0; k < 64; k++) { const at = 4 * (x + (k + 0.5) / 64) / width - 1; truth += (1 - hat(at) - hat(at - 1)) / 64; }
  for (let y = 0; y < height; y++) { const by = Math.abs(red[y * width + x] / wall - truth); squares += by * by; most = Math.max(most, by); }
}
console.log(JSON.stringify({ rms: Math.sqrt(squares / width / height), most }));
J
node "$tmp/scenes.mjs" "$tmp" || exit 1
judged() { node "$tmp/judge.mjs" "$PWD" "$tmp/$1.exr" | tee /dev/stderr | jq -e "$2"; }
rms() { node "$tmp/judge.mjs" "$PWD" "$tmp/$1.exr" | jq .rms; }
alike() { figure "$1" "$2" | jq -e --argjson most "${3:-0}" '.rmse <= $most'; }
same() { cmp "$tmp/$1.exr" "$tmp/$2.exr"; }

for what in square bend camera; do
    check "$what: a shutter is open" render "$what" "$what" --workers 2
    check "... for which pixels are covered as long as they should be" judged "$what" '.rms < 0.004 and .most < 0.02'
done
check "a shutter that opens later" render square_late late
check "... shows what is there then" judged late '.rms < 0.004'
check "without a shutter" render square_rest rest
check "... a moment is seen" judged rest '.rms > 0.2'
check "scene.time_s" render square_moment moment
check "... holds that moment" alike rest moment 0.001
check "few samples" render square_few few
check "... have noise" judged few '.rms > 0.01'
check "the residual filter" render square_clean clean
check "... takes some of it" jq -en --argjson a "$(rms clean)" --argjson b "$(rms few)" '$a < 0.7 * $b'
check "the option --shutter opens it, too" render square_open open --shutter 1
check "... as the job does" same open few
check "a sequence is blurred" render square_list l.# --workers 1
check "... on three workers, in other tiles" render square_list m.# --workers 3 --tile 16
check "... in the same bytes" bash -c "for f in 1 2 3 4; do cmp $tmp/l.\$f.exr $tmp/m.\$f.exr || exit 1; done"
check "frames of a window take some more noise" jq -en --argjson a "$(rms l.2)" --argjson b "$(rms clean)" '$a < $b'
check "a sequence without windows" render square_apart apart.#
check "... has the frame that it would have alone" alike apart.2 clean
tap_done
