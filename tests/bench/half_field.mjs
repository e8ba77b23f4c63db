// Light fields at half resolution beside those at full resolution: the error of what bounce rays and rays of glossy lobes
// bring, and CPU time of tracing and filtering, over rays a pixel that traces.
//   half_field.mjs BUILD [side=PX] [reference=RAYS] [spp=N,...] [scene=NAME,...] [seeds=N]
// The scene "walk" is a sequence, matt blocks that a camera goes round: what flickers is compared (exr_flicker.c), a quarter of
// the rays a pixel at full resolution beside as many at half.
// One JSON line a scene, scale and count on standard output, a table on standard error. Each row of the half field says how
// many times lower its error is than the full one's in equal CPU time, and with equal rays.
// Truth are two halves of unfiltered rays of pixel centres, for lobes of plain paths, kept in BUILD/bench/half_field; what
// they are apart tells their own error, which is taken off.
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { spawnSync } from "node:child_process";
import { resolve } from "node:path";
import { indirectJob, testJob } from "./accuracy/job.mjs";
import { programs } from "./accuracy/programs.mjs";
import { scenesFolder } from "./folders.mjs";
import { glossy } from "./scenes/glossy.mjs";
import { changeGlb } from "./scenes/glb.mjs";
import { indirect } from "./scenes/indirect.mjs";
import { moving, movingJob } from "./scenes/moving.mjs";

process.chdir(new URL("../..", import.meta.url).pathname);
const [build, ...words] = process.argv.slice(2), WORDS = ["side", "reference", "spp", "scene", "seeds"];
const given = Object.fromEntries(words.map((w) => w.split(/=(.*)/s).slice(0, 2)));
const STAGES = ["trace", "reconstruct", "indirect", "glossy"]; // the second fills pixels without rays
const NAMES = ["box", "box_4", "helmet", "living_room", "plates", "spheres", "walk"];
const names = given.scene?.split(",") ?? NAMES, all = [...indirect, ...glossy.map((s) => ({ ...s, effect: "glossy" })), { name: "walk" }];
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
    return { squared: Math.max(d.rmse ** 2 - unsure ** 2, 0) / d.mean ** 2, cpu_s, rays, skipped, unsure: unsure / d.mean };
  });
  const { rays, skipped } = runs[0];
  return { scene: scene.name, side_px: o.side, scale, spp: n, error: Math.sqrt(runs.reduce((s, r) => s + r.squared, 0) / seeds), reference_error: runs[0].unsure,
    cpu_s: STAGES.reduce((sum, stage) => sum + Math.min(...runs.map((r) => r.cpu_s[stage] ?? 0)), 0), bounce_rays: rays.indirect, anew: rays.anew, lent: skipped.half_field };
}

// Time, and what is traced, are lines over the count; they are fitted by relative errors, as each run's time is off by
// a part of it.
function lineOf(rows, member) {
  const sums = [0, 0, 0, 0, 0];
  for (const { spp: n, [member]: t } of rows) [1, n, n * n, t, n * t].forEach((v, k) => sums[k] += v / t ** 2);
  const [s, sn, snn, st, snt] = sums, det = s * snn - sn * sn;
  return { start: (snn * st - sn * snt) / det, each: (s * snt - sn * st) / det };
}

// The full field's error with so many rays a pixel: a power of them between, and beyond, two counts.
function errorAt(rows, n) {
  const k = Math.min(Math.max(rows.findIndex((r) => r.spp >= n), 1), rows.length - 1), [a, b] = rows.at(-1).spp < n ? rows.slice(-2) : [rows[k - 1], rows[k]];
  return a.error * (b.error / a.error) ** (Math.log(n / a.spp) / Math.log(b.spp / a.spp));
}

// What the full field has in the time of a row of the half field, and with as many rays; null for less than a ray a pixel.
function besideFull(full, half, row) {
  const a = lineOf(full, "cpu_s"), b = lineOf(half, "cpu_s"), c = lineOf(full, "bounce_rays");
  const n = (b.start + b.each * row.spp - a.start) / a.each, rays = (row.bounce_rays - c.start) / c.each;
  const times = (count) => count >= 0.9 ? errorAt(full, count) / row.error : null;
  return { full_rays_in_its_time: n, times_lower_in_equal_time: times(n), times_lower_with_equal_rays: times(rays) };
}

// Frames 2 and 3 of a walk around blocks under a lamp alone, three pixels a frame at 320 across.
function walk() {
  const file = `${folder}/walk.glb`, frame = (path, n) => path.replace("#", n), truth = `${folder}/walk-${o.side}-${HALF}.#.exr`, out = `${folder}/walk.#.exr`;
  const matt = (document) => { for (const m of document.materials) [m.pbrMetallicRoughness.metallicFactor, m.extensions.KHR_materials_specular] = [0, { specularFactor: 0 }]; };
  const job = (sampling, indirect, layers) => movingJob(file, 3, o.side, 16, { environment: null, frames: { first: 2, last: 3 }, sampling: { spp: 16, seed: 7, ...sampling },
    filter: { indirect }, layers });
  writeFileSync(file, changeGlb(moving.find((m) => m.name === "camera").glb(), matt));
  if (!existsSync(frame(truth, 3))) tools.render(job({ indirect_spp: HALF }, "linear", ["beauty", "vector"]), truth);
  for (const n of counts.filter((count) => count % 4 === 0))
    for (const scale of [1, 0.5]) {
      const spp = scale < 1 ? n : n / 4, { cpu_s, rays } = tools.render(job({ indirect_spp: spp, field_scale: scale }, "constant", ["beauty"]), out);
      const result = spawnSync(`${build}/tests/bench/exr_flicker`, [truth, out].flatMap((path) => [2, 3].map((k) => frame(path, k))), { encoding: "utf8" });
      if (result.status !== 0) throw new Error(result.stderr);
      const { flicker, low, high } = JSON.parse(result.stdout), row = { scene: "walk", side_px: o.side, scale, spp, flicker, low, high, cpu_s: STAGES.reduce((sum, stage) => sum + (cpu_s[stage] ?? 0), 0), bounce_rays: rays.indirect };
      console.log(JSON.stringify(row));
      console.error(`walk: scale ${String(scale).padEnd(4)}${String(spp).padStart(4)} rays, flicker ${(100 * flicker).toPrecision(3)} % (low ${(100 * low).toPrecision(3)}, high ${(100 * high).toPrecision(3)}), ${row.cpu_s.toPrecision(3)} CPU s, ${rays.indirect} bounce rays`);
    }
}

if (names.includes("walk")) walk();
for (const scene of scenes.filter((s) => s.name !== "walk")) {
  const file = `${folder}/${scene.name}.glb`;
  writeFileSync(file, scene.glb(o.shared));
  const unsure = truthOf(scene, file), full = counts.map((n) => measure(scene, file, 1, n, unsure));
  const half = counts.map((n) => measure(scene, file, 0.5, n, unsure));
  for (const row of full) console.log(JSON.stringify(row));
  for (const row of half) Object.assign(row, besideFull(full, half, row));
  for (const row of half) console.log(JSON.stringify(row));
  const said = (v) => (v === null ? "less than a ray" : v.toPrecision(3));
  console.error(`${scene.name}: ${scene.about}; error in % of the mean, the reference's ${(100 * full[0].reference_error).toPrecision(2)} %`);
  for (const row of [...full, ...half])
    console.error(`  scale ${String(row.scale).padEnd(4)}${String(row.spp).padStart(5)} rays ${(100 * row.error).toPrecision(3).padStart(6)} %${row.cpu_s.toPrecision(3).padStart(8)} CPU s` +
      (row.scale < 1 ? `  times lower in equal time ${said(row.times_lower_in_equal_time)}, with equal rays ${said(row.times_lower_with_equal_rays)}; ${(100 * row.anew / (row.anew + row.lent)).toPrecision(2)} % anew` : ""));
}
