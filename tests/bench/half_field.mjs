// Light fields at half resolution beside those at full resolution: the error of what bounce rays and rays of glossy lobes
// bring, and CPU time of tracing and filtering, over rays a pixel that traces.
//   half_field.mjs BUILD [side=PX] [reference=RAYS] [spp=N,...] [scene=NAME,...] [seeds=N]
// One JSON line a scene, scale and count on standard output, a table on standard error. Between two counts the full
// field's error is a power of the time, so that each row of the half field says what error the full one has in its time.
// Truth are two halves of unfiltered rays of pixel centres, for lobes of plain paths, kept in BUILD/bench/half_field; what
// they are apart tells their own error, which is taken off.
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { spawnSync } from "node:child_process";
import { resolve } from "node:path";
import { indirectJob, testJob } from "./accuracy/job.mjs";
import { programs } from "./accuracy/programs.mjs";
import { scenesFolder } from "./folders.mjs";
import { glossy } from "./scenes/glossy.mjs";
import { indirect } from "./scenes/indirect.mjs";

process.chdir(new URL("../..", import.meta.url).pathname);
const [build, ...words] = process.argv.slice(2), WORDS = ["side", "reference", "spp", "scene", "seeds"];
const given = Object.fromEntries(words.map((w) => w.split(/=(.*)/s).slice(0, 2)));
const NAMES = ["box", "box_4", "helmet", "living_room", "plates", "spheres"];
const names = given.scene?.split(",") ?? NAMES, all = [...indirect, ...glossy.map((s) => ({ ...s, effect: "glossy" }))];
const counts = given.spp?.split(",").map(Number) ?? [4, 16, 64], number = (name, otherwise) => Number(given[name] ?? otherwise);
const o = { side: number("side", 256), shared: scenesFolder() }, HALF = number("reference", 1024), seeds = number("seeds", 2);
const scenes = names.map((name) => all.find((s) => s.name === name)), isCount = (n) => Number.isInteger(n) && n > 0;
if (!build || Object.keys(given).some((w) => !WORDS.includes(w)) || scenes.includes(undefined) || ![o.side, HALF, seeds, ...counts].every(isCount)) {
  console.error("usage: half_field.mjs BUILD [side=PX] [reference=RAYS] [spp=N,...] [scene=NAME,...] [seeds=N]\n" + `scenes: ${all.map((s) => s.name).join(" ")}`);
  process.exit(2);
}
const folder = resolve(build, "bench/half_field");
mkdirSync(folder, { recursive: true });
const tools = programs(build, folder), picture = `${folder}/picture.exr`, truth = `${folder}/truth.exr`;

const lobeJob = (scene, file, sampling, filter) => ({ scene: { file, lights: false, camera: scene.camera }, image: { width: o.side, height: o.side },
  lights: scene.lights, effects: { indirect_bounces: scene.bounces }, sampling, filter, layers: ["beauty", "indirect", "id"] });

const truthJob = (scene, file, seed) => scene.effect === "glossy"
  ? lobeJob(scene, file, { spp: HALF, seed }, { method: "none" })
  : indirectJob(scene, o, file, seed, HALF);

const jobOf = (scene, file, scale, n, seed) => {
  const sampling = { spp: 1, indirect_spp: n, field_scale: scale, seed };
  return scene.effect === "glossy" ? lobeJob(scene, file, sampling, { indirect: "constant", glossy: "virtual_hit" })
    : { ...testJob(scene, o, file, "constant", n, seed), sampling };
};

function apart(scene, a, b) {
  const [program, ...args] = scene.effect === "glossy"
    ? ["shearwater", "compare", a, b, "--layer", "indirect", "--where", `id,0.5,${scene.metals + 0.5}`]
    : ["tests/bench/exr_difference", a, b, "diffuse_indirect", "albedo", "id,0.5,1e9"];
  const result = spawnSync(`${build}/${program}`, args, { encoding: "utf8" });
  if (result.status !== 0) throw new Error(result.stderr);
  const d = JSON.parse(result.stdout);
  return { rmse: d.rmse, mean: d.mean ?? d.mean_reference.reduce((x, y) => x + y) / 3 };
}

function truthOf(scene, file) {
  const halves = [901, 902].map((seed) => {
    const path = `${folder}/${scene.name}-${o.side}-${HALF}-${seed}.exr`;
    if (!existsSync(path)) tools.render(truthJob(scene, file, seed), path);
    return path;
  });
  tools.mean(truth, halves);
  return apart(scene, ...halves).rmse / 2;
}

function measure(scene, file, scale, n, unsure) {
  const runs = Array.from({ length: seeds }, (_, i) => {
    const { cpu_s, rays, skipped } = tools.render(jobOf(scene, file, scale, n, 7 + i), picture), d = apart(scene, truth, picture);
    return { squared: Math.max(d.rmse ** 2 - unsure ** 2, 0) / d.mean ** 2, cpu_s: cpu_s.trace + (cpu_s.indirect ?? 0) + (cpu_s.glossy ?? 0), rays, skipped, unsure: unsure / d.mean };
  });
  const { rays, skipped } = runs[0];
  return { scene: scene.name, side_px: o.side, scale, spp: n, error: Math.sqrt(runs.reduce((s, r) => s + r.squared, 0) / seeds), reference_error: runs[0].unsure,
    cpu_s: Math.min(...runs.map((r) => r.cpu_s)), bounce_rays: rays.indirect, anew: rays.anew, lent: skipped.half_field };
}

// The full field's error in so much time: a power of it between, and beyond, two counts.
function errorAt(rows, cpu_s) {
  const k = Math.min(Math.max(rows.findIndex((r) => r.cpu_s >= cpu_s), 1), rows.length - 1), [a, b] = [rows.at(k === -1 ? -2 : k - 1), rows.at(k)];
  return a.error * (b.error / a.error) ** (Math.log(cpu_s / a.cpu_s) / Math.log(b.cpu_s / a.cpu_s));
}

for (const scene of scenes) {
  const file = `${folder}/${scene.name}.glb`;
  writeFileSync(file, scene.glb(o.shared));
  const unsure = truthOf(scene, file), full = counts.map((n) => measure(scene, file, 1, n, unsure));
  const half = counts.map((n) => measure(scene, file, 0.5, n, unsure));
  for (const row of full) console.log(JSON.stringify(row));
  for (const row of half) console.log(JSON.stringify({ ...row, full_error_in_its_time: errorAt(full, row.cpu_s), times_lower: errorAt(full, row.cpu_s) / row.error }));
  console.error(`${scene.name}: error in % of the mean, CPU s; the reference's ${(100 * full[0].reference_error).toPrecision(2)} %`);
  for (const row of [...full, ...half])
    console.error(`  scale ${String(row.scale).padEnd(4)}${String(row.spp).padStart(5)} rays ${(100 * row.error).toPrecision(3).padStart(6)} %${row.cpu_s.toPrecision(3).padStart(8)} s` +
      (row.scale < 1 ? `  full resolution has ${(errorAt(full, row.cpu_s) / row.error).toPrecision(3)} times the error in this time; anew ${(100 * row.anew / (row.anew + row.lent)).toPrecision(2)} % of other pixels` : ""));
}
