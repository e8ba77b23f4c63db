// How near objects in photographs, and in colour and depth, come to the truth: a box put into pictures of a room against
// both path-traced together. Depth has 16 bits, the noise of a sensor and holes at edges. Errors are the RMS of all
// pixels and colours over the mean.
import { spawnSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";

const YFOV_DEG = 28, UNITS_PER_M = 2, MIDDLE = 2, FRAMES = 5;
const FULL = { side: 256, referenceSpp: 1024, spp: [4, 16, 64], still: 20 };
const SMALL = { quick: { side: 96, referenceSpp: 576, spp: [4, 16], still: 20 }, smoke: { side: 48, referenceSpp: 64, spp: [4], still: 3 } };
const eyeX = (k) => 0.1 * (k - MIDDLE);

function run(command, words) {
  const { status, stdout, stderr } = spawnSync(command, words, { encoding: "utf8", maxBuffer: 1 << 26 });
  if (status !== 0) throw new Error(`${command} ${words.join(" ")}: ${stderr}`);
  return stdout;
}

// Renders to OUT.exr; tells the CPU seconds.
function render(o, folder, job, out) {
  const file = `${folder}/job.json`, stats = `${folder}/stats.json`;
  writeFileSync(file, JSON.stringify(job));
  run(`${o.build}/shearwater`, ["render", file, "--quiet", "-o", `${folder}/${out}.exr`, "--stats", stats]);
  return JSON.parse(readFileSync(stats, "utf8")).cpu_s;
}

const room = (set, file, x, more) => ({ scene: { file, camera: { eye: [x, 1, 5], target: [x, 1, 0], yfov_deg: YFOV_DEG } },
  image: { width: set.side, height: set.side }, effects: { indirect_bounces: 4 }, ...more });
const reference = (spp) => ({ sampling: { spp }, filter: { method: "none" }, layers: ["beauty", "depth"] });

// What the sensor sees of the room from a few places, and the middle of them with the box.
function photograph(o, folder, set) {
  for (const name of ["box.obj", "room.obj", "room-and-box.obj", "materials.mtl"]) copyFileSync(`tests/scenes/photograph/${name}`, `${folder}/${name}`);
  const focal = set.side / 2 / Math.tan(YFOV_DEG * Math.PI / 360), centre = set.side / 2 - 0.5;
  for (let k = 0; k < FRAMES; k++) {
    if (!existsSync(`${folder}/room_${k}.exr`)) render(o, folder, room(set, "room.obj", eyeX(k), reference(k === MIDDLE ? set.referenceSpp : 4)), `room_${k}`);
    run(`${o.build}/tests/bench/exr_depth`, [`${folder}/room_${k}.exr`, `${folder}/depth_${k}.pgm`, String(YFOV_DEG), String(UNITS_PER_M), "1", String(k)]);
  }
  if (!existsSync(`${folder}/truth.exr`)) render(o, folder, room(set, "room-and-box.obj", 0, reference(set.referenceSpp)), "truth");
  const numbers = Array.from({ length: FRAMES }, (_, k) => k);
  writeFileSync(`${folder}/poses.txt`, numbers.map((k) => `${k / 24} ${eyeX(k) / UNITS_PER_M} 0 0 0 0 0 1\n`).join(""));
  for (const fuse of [0, 2])
    writeFileSync(`${folder}/sequence_${fuse}.json`, JSON.stringify({ camera: { fx: focal, fy: focal, cx: centre, cy: centre }, poses: { file: "poses.txt", format: "tum" }, fuse,
      frames: numbers.map((k) => ({ color: `room_${k}.exr`, depth: `depth_${k}.pgm` })), to_scene: [2, 0, 0, 0, 0, -2, 0, 1, 0, 0, -2, 5, 0, 0, 0, 1] }));
}

const lamp = { type: "rectangle", center: [0, 1.93, 0], half_u: [0.25, 0, 0], half_v: [0, 0, 0.25], radiance: [17, 12, 4] };
const roles = { backplate: { file: `room_${MIDDLE}.exr` }, catchers: ["white", "red", "green"], holdouts: ["lamp"] };
const measured = (set, fuse, surfaces = "screen") => ({ scene: { file: "box.obj" }, rgbd: { file: `sequence_${fuse}.json`, surfaces }, image: { width: set.side, height: set.side },
  effects: { indirect_bounces: 4 }, lights: [lamp], frames: { first: MIDDLE + 1, last: MIDDLE + 1 } });
const lit = (set, light) => { const job = measured(set, 2); return { ...job, lights: [], rgbd: { ...job.rgbd, light } }; };
const KINDS = [
  { name: "photograph", job: (set) => room(set, "room-and-box.obj", 0, roles) },
  { name: "photograph, additive", job: (set) => room(set, "room-and-box.obj", 0, { ...roles, composite: { mode: "additive" } }) },
  { name: "colour and depth", job: (set) => measured(set, 2) },
  { name: "colour and depth, frames by themselves", job: (set) => measured(set, 0) },
  { name: "colour and depth, fused", job: (set) => measured(set, 2, "fused") },
  { name: "colour and depth, light estimated", job: (set) => lit(set, "auto") },
  { name: "colour and depth, studio light", job: (set) => lit(set, "studio") }];

// Frames of a camera that stands, of a place where nothing moves: the colours are the same, and depth has noise of its
// own in each. All that changes from frame to frame flickers; its RMS is told over the mean.
function flicker(o, folder, set, spp) {
  const numbers = Array.from({ length: set.still }, (_, k) => k), frame = (k) => `${folder}/still_${String(k + 1).padStart(2, "0")}.exr`;
  for (const k of numbers)
    run(`${o.build}/tests/bench/exr_depth`, [`${folder}/room_${MIDDLE}.exr`, `${folder}/still_${k}.pgm`, String(YFOV_DEG), String(UNITS_PER_M), "1", String(100 + k)]);
  writeFileSync(`${folder}/still.txt`, numbers.map((k) => `${k / 24} ${eyeX(MIDDLE) / UNITS_PER_M} 0 0 0 0 0 1\n`).join(""));
  const sequence = JSON.parse(readFileSync(`${folder}/sequence_2.json`, "utf8"));
  writeFileSync(`${folder}/sequence_still.json`, JSON.stringify({ ...sequence, poses: { file: "still.txt", format: "tum" },
    frames: numbers.map((k) => ({ color: `room_${MIDDLE}.exr`, depth: `still_${k}.pgm` })) }));
  for (const [surfaces, temporal] of [["screen", "none"], ["screen", "2"], ["fused", "none"], ["fused", "2"]]) {
    const of = surfaces === "fused" ? ", fused" : "";
    const cpu_s = render(o, folder, { ...measured(set, "still", surfaces), frames: { first: 1, last: set.still }, sampling: { spp }, filter: { temporal } }, "still_##");
    const changes = numbers.slice(1).map((k) => JSON.parse(run(`${o.build}/shearwater`, ["compare", frame(k - 1), frame(k), "--layer", "composite"])));
    const rms = Math.sqrt(changes.reduce((sum, c) => sum + c.rmse ** 2, 0) / changes.length), mean = changes[0].mean_reference.reduce((sum, v) => sum + v / 3, 0);
    o.put("mixed", `flicker${of}, window ${temporal}, ${spp} spp`, { kind: `flicker${of}`, spp, side: set.side, frames: set.still, temporal, flicker: rms / mean, cpu_s });
    o.say(`${`flicker of ${set.still} frames${of}, window: ${temporal}`.padEnd(38)} ${String(spp).padStart(3)} spp  ${(100 * rms / mean).toFixed(2)} %`);
  }
}

export async function mixed(o) {
  const set = SMALL[o.mode] ?? FULL, folder = `${o.out}/mixed`;
  mkdirSync(folder, { recursive: true });
  photograph(o, folder, set);
  for (const { name, job } of KINDS)
    for (const spp of o.given.spp ? o.given.spp.split(",").map(Number) : set.spp) {
      const cpu_s = render(o, folder, { ...job(set), sampling: { spp } }, "composed");
      const { rms, plate_rms } = JSON.parse(run(`${o.build}/tests/bench/exr_composite`, ["truth", `room_${MIDDLE}`, "composed"].map((f) => `${folder}/${f}.exr`)));
      o.put("mixed", `${name} ${spp} spp`, { kind: name, spp, side: set.side, rms, plate_rms, cpu_s });
      o.say(`${name.padEnd(38)} ${String(spp).padStart(3)} spp  error ${(100 * rms).toFixed(2)} % where the box changes ${(100 * plate_rms).toFixed(1)} %`);
    }
  flicker(o, folder, set, o.given.spp ? Number(o.given.spp.split(",")[0]) : set.spp[0]);
}
