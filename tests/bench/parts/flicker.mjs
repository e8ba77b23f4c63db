// How much sequences flicker: plain paths, and auto with frames filtered one by one and over windows, of blocks, of these
// through a lens, and of the Cornell box, in which nothing moves, the camera, the lamp or a block. Flicker is what changes
// from frame to frame at points that both show and that has no cause in the scene (exr_flicker.c), over the mean; error is
// the frames' RMSE over the same.
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { moving, movingBox, movingJob, movingLens } from "../scenes/moving.mjs";

const FRAMES = 6, JUDGED = [3, 4]; // with two frames on each side
const FULL = { width: 320, referenceSpp: 1024, spp: [4, 9] };
const SMALL = { quick: { width: 160, referenceSpp: 256, spp: [4] }, smoke: { width: 48, referenceSpp: 64, spp: [4] } };

// times: so many more paths, which without filters take about as long.
const CONVERGED = { method: "none", residual: "halves", temporal: "none" }; // paths, whose mean a filtered picture becomes
const METHODS = [
  { name: "paths", more: { filter: { method: "none" } } },
  { name: "paths x 4", times: 4, more: { filter: { method: "none" } } },
  { name: "one by one", more: { filter: { temporal: "none" } } },
  { name: "window of 3", more: { filter: { temporal: "1" } } },
  { name: "window of 5", more: { filter: { temporal: "2" } } }];

function run(command, words) {
  const { status, stdout, stderr } = spawnSync(command, words, { encoding: "utf8", maxBuffer: 1 << 26 });
  if (status !== 0) throw new Error(`${command} ${words.join(" ")}: ${stderr}`);
  return stdout;
}

const frame = (pattern, n) => pattern.replace("#", n);

// Renders to files with # for the number; tells the CPU seconds of a frame.
function render(o, folder, job, out) {
  const file = `${folder}/job.json`, stats = `${folder}/stats.json`;
  writeFileSync(file, JSON.stringify(job));
  run(`${o.build}/shearwater`, ["render", file, "--quiet", "-o", out, "--stats", stats]);
  return JSON.parse(run("cat", [stats])).cpu_s;
}

function measure(o, reference, out) {
  const flicker = JSON.parse(run(`${o.build}/tests/bench/exr_flicker`, [reference, out].flatMap((p) => JUDGED.map((n) => frame(p, n)))));
  const errors = JUDGED.map((n) => JSON.parse(run(`${o.build}/shearwater`, ["compare", frame(reference, n), frame(out, n), "--layer", "beauty"])));
  const rmse = Math.sqrt(errors.reduce((sum, e) => sum + e.rmse ** 2, 0) / errors.length);
  const mean = errors[0].mean_reference.reduce((sum, v) => sum + v / 3, 0);
  return { ...flicker, error: rmse / mean };
}

export async function flicker(o) {
  const set = SMALL[o.mode] ?? FULL, folder = `${o.out}/flicker`;
  const spps = o.given.spp ? o.given.spp.split(",").map(Number) : set.spp;
  mkdirSync(folder, { recursive: true });
  const given = o.given.scene?.split(",");
  for (const { name, about, glb, job } of [...moving, ...movingLens, ...movingBox].filter((one) => !given || given.includes(one.name))) {
    const file = `${folder}/${name}.glb`, reference = `${folder}/${name}-reference.#.exr`;
    writeFileSync(file, glb());
    o.say(`flicker: ${name}, ${about}`);
    if (!JUDGED.every((n) => existsSync(frame(reference, n))))
      render(o, folder, movingJob(file, FRAMES, set.width, set.referenceSpp, { ...job, frames: { first: JUDGED[0], last: JUDGED[1] }, filter: CONVERGED,
        sampling: { spp: set.referenceSpp, seed: 7 }, layers: ["beauty", "vector"] }), reference);
    for (const spp of spps)
      for (const method of METHODS) {
        const out = `${folder}/${name}.#.exr`, cpu_s = render(o, folder, movingJob(file, FRAMES, set.width, spp * (method.times ?? 1), { ...job, layers: ["beauty"], ...method.more }), out);
        const row = { scene: name, about, method: method.name, spp, width: set.width, frames: FRAMES, cpu_s, ...measure(o, reference, out) };
        o.put("flicker", `${name} ${method.name} ${spp} spp`, row);
        o.say(`${name.padEnd(10)} ${String(spp).padStart(3)} spp  ${method.name.padEnd(12)} flicker ${(100 * row.flicker).toFixed(2)} % (low ${(100 * row.low).toFixed(2)}, high ${(100 * row.high).toFixed(2)}), error ${(100 * row.error).toFixed(2)} %`);
      }
  }
}
