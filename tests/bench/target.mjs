// Sampling until a target error, on the scenes of indirect light: how near the picture's true error comes
// to the one asked for, and how many samples that takes beside uniform sampling that comes as near.
//   target.mjs BUILD [scene=NAME,...] [side=PX] [reference=SPP]
// One JSON line a scene on standard output, and a sentence for people on standard error. Status 1 when a
// bound is missed. References, two pictures of the path tracer a scene, are kept in BUILD/bench/target.
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathsJob } from "./accuracy/job.mjs";
import { programs } from "./accuracy/programs.mjs";
import { scenesFolder } from "./folders.mjs";
import { indirect } from "./scenes/indirect.mjs";

process.chdir(new URL("../..", import.meta.url).pathname);
const [build, ...words] = process.argv.slice(2);
const given = Object.fromEntries(words.map((w) => w.split(/=(.*)/s).slice(0, 2)));
const o = { side: Number(given.side ?? 256), shared: scenesFolder() };
const REFERENCE = Number(given.reference ?? 1024), SEED = 7, FIRST = 9;
// Errors that pictures of some dozens of samples have.
const TARGETS = { box: 0.01, box_4: 0.01, living_room: 0.1, reflector: 0.015, glossy_floor: 0.015, helmet: 0.015 };
const UNIFORM = [4, 9, 16, 25, 36, 64, 100, 144, 225, 400, 784];

const folder = resolve(build, "bench/target");
mkdirSync(folder, { recursive: true });
const tools = programs(build, folder);

function known(references, picture) {
  const result = spawnSync(`${build}/tests/bench/exr_calibration`, [...references, picture], { encoding: "utf8" });
  if (result.status !== 0) throw new Error(result.stderr);
  return JSON.parse(result.stdout);
}

function referencesOf(scene, file) {
  return [901, 902].map((seed) => {
    const path = `${folder}/${scene.name}-${o.side}-${REFERENCE}-${seed}.exr`;
    if (!existsSync(path)) tools.render(pathsJob(scene, o, file, seed, REFERENCE), path);
    return path;
  });
}

// Samples a pixel of all kinds at which uniform sampling has the error: between two counts its logarithm
// is taken to go straight. Where none of the counts has it, the largest: uniform sampling takes more.
function uniformSamples(render, error) {
  let before = null;
  for (const n of UNIFORM) {
    const now = render({ spp: n });
    if (now.error <= error) {
      if (!before) return now.samples;
      const share = Math.log(before.error / error) / Math.log(before.error / now.error);
      return before.samples * (now.samples / before.samples) ** share;
    }
    before = now;
  }
  return before.samples;
}

function measure(scene) {
  const file = `${folder}/${scene.name}.glb`, picture = `${folder}/picture.exr`, asked = TARGETS[scene.name];
  writeFileSync(file, scene.glb(o.shared));
  const references = referencesOf(scene, file);
  const render = (sampling) => {
    const job = { ...pathsJob(scene, o, file, SEED, FIRST), sampling: { seed: SEED, tile_px: 32, ...sampling },
      filter: {}, layers: ["beauty", "error", "samples"] };
    const statistics = tools.render(job, picture);
    return { ...known(references, picture), target: statistics.target, wall_s: statistics.wall_s };
  };
  const reached = render({ spp: FIRST, target_error: asked });
  // Uniform rounds of one have the same parts: paths beside the light field, by an unreachable cap.
  const uniform = uniformSamples(({ spp }) => render({ spp, target_error: 1e-5, max_spp: spp }), reached.error);
  return { scene: scene.name, asked, reached: reached.error, estimate: reached.estimate, within: reached.within,
    over_asked: reached.error / asked, rounds: reached.target.rounds, samples: reached.samples,
    uniform_samples: uniform, over_uniform: reached.samples / uniform };
}

const wanted = given.scene?.split(",") ?? Object.keys(TARGETS);
const unknown = wanted.find((name) => !(name in TARGETS));
if (!build || unknown) {
  console.error(unknown ? `target: there is no scene "${unknown}"` : "usage: target.mjs BUILD [scene=NAME,...] [side=PX] [reference=SPP]");
  process.exit(2);
}
let missed = 0;
for (const scene of indirect.filter((s) => wanted.includes(s.name))) {
  const line = measure(scene), round = (v) => v.toPrecision(3);
  line.ok = line.over_asked > 0.7 && line.over_asked < 1.3 && line.over_uniform < 1;
  missed += line.ok ? 0 : 1;
  console.log(JSON.stringify(line));
  console.error(`target ${scene.name}: error ${round(line.reached)} over ${line.asked} asked is ${round(line.over_asked)} (bound 0.7 to 1.3); ` +
    `samples over uniform ones ${round(line.over_uniform)} (bound < 1) ${line.ok ? "reached" : "MISSED"}`);
}
process.exit(missed > 0 ? 1 : 0);
