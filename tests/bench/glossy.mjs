// Glossy reflections by their own light field, on the floor of the scene glossy_floor: the error of the
// layer `indirect` there, of plain paths and of the field by each of its filters, at equal samples; and of
// adaptive sampling beside uniform sampling of as many rays of the floor's pixels.
//   glossy.mjs BUILD [side=PX] [reference=SPP] [spp=N,...] [mu=MU,...]
// One JSON line a method and count on standard output, a sentence for people on standard error. Status 1
// when a bound is missed. The two halves of the reference, plain paths, are kept in BUILD/bench/glossy;
// what they are apart tells the reference's own error, which is taken off.
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { spawnSync } from "node:child_process";
import { resolve } from "node:path";
import { pathsJob } from "./accuracy/job.mjs";
import { programs } from "./accuracy/programs.mjs";
import { scenesFolder } from "./folders.mjs";
import { indirect } from "./scenes/indirect.mjs";

process.chdir(new URL("../..", import.meta.url).pathname);
const [build, ...words] = process.argv.slice(2);
if (!build || words.some((w) => !/^(side|reference|spp|mu)=/.test(w))) {
  console.error("usage: glossy.mjs BUILD [side=PX] [reference=SPP] [spp=N,...] [mu=MU,...]");
  process.exit(2);
}
const given = Object.fromEntries(words.map((w) => w.split("=")));
const o = { side: Number(given.side ?? 384), shared: scenesFolder() };
const HALF = Number(given.reference ?? 1024), SEED = 7, FLOOR = "id,0.5,1.5"; // the scene's first instance
const COUNTS = (given.spp ?? "4,16,64").split(",").map(Number);
const MUS = (given.mu ?? "0.5,1,2").split(",").map(Number);
const METHODS = { paths: { method: "none" }, average: { glossy: "average" }, virtual_hit: { glossy: "virtual_hit" },
  bandlimit: { glossy: "bandlimit" } };
const LAYERS = ["beauty", "indirect", "samples", "id"];
// Paths' error over that of virtual hits, at least.
const BOUNDS = { 4: 5, 16: 4, 64: 2 };

const folder = resolve(build, "bench/glossy");
mkdirSync(folder, { recursive: true });
const tools = programs(build, folder), scene = indirect.find((s) => s.name === "glossy_floor");
const file = `${folder}/scene.glb`, picture = `${folder}/picture.exr`, reference = `${folder}/reference.exr`;
writeFileSync(file, scene.glb(o.shared));

function compare(a, b, layer = "indirect") {
  const result = spawnSync(`${build}/shearwater`, ["compare", a, b, "--layer", layer, "--where", FLOOR], { encoding: "utf8" });
  if (result.status !== 0) throw new Error(result.stderr);
  return JSON.parse(result.stdout);
}

const jobOf = (seed, spp, filter) => ({ ...pathsJob(scene, o, file, seed, spp), filter, layers: LAYERS });
const halves = [901, 902].map((seed) => {
  const path = `${folder}/${o.side}-${HALF}-${seed}.exr`;
  if (!existsSync(path)) tools.render(jobOf(seed, HALF, METHODS.paths), path);
  return path;
});
tools.mean(reference, halves);
const noise = compare(...halves).rmse / 2;

let missed = 0;
for (const spp of COUNTS) {
  const rows = Object.entries(METHODS).map(([method, filter]) => {
    const { cpu_s } = tools.render(jobOf(SEED, spp, filter), picture), c = compare(reference, picture);
    const rmse = Math.sqrt(Math.max(c.rmse ** 2 - noise ** 2, 0));
    return { scene: scene.name, side_px: o.side, method, spp, rmse, bias: c.bias, reference_rmse: noise,
      trace_cpu_s: cpu_s.trace, filter_cpu_s: cpu_s.glossy ?? 0 };
  });
  for (const row of rows) console.log(JSON.stringify({ ...row, times_lower: rows[0].rmse / row.rmse }));
  const times = rows[0].rmse / rows.find((r) => r.method === "virtual_hit").rmse, bound = BOUNDS[spp];
  const ok = bound === undefined || times >= bound;
  missed += ok ? 0 : 1;
  console.error(`glossy floor, ${spp} spp: paths' RMSE over that of virtual hits ${times.toPrecision(3)}` +
    (bound === undefined ? "" : ` (bound >= ${bound}) ${ok ? "reached" : "MISSED"}`));
}

// Under adaptive sampling all pixels get the first 16 rays of each kind, and paths beside them, also where
// it is uniform. Uniform sampling is known for squares: between two of them the error is a power of the
// rays, which the layer samples counts. Truth is the mean of many rays at the same places beside pixel
// centres: what silhouettes do there must not hide the rest. At half the side, whose truths take a minute.
const PATHS = 16, HALF_SIDE = { ...o, side: Math.round(o.side / 2) }, truth = `${folder}/truth.exr`;
const rateJob = (filter, rays) => ({ ...pathsJob(scene, HALF_SIDE, file, SEED, PATHS), filter, layers: LAYERS,
  sampling: { spp: PATHS, seed: SEED, ...(rays ? { indirect_spp: rays } : {}) } });
const truths = [1024, 961].map((rays) => {
  const path = `${folder}/${HALF_SIDE.side}-rays-${rays}.exr`;
  if (!existsSync(path)) tools.render(rateJob({ indirect: "average", glossy: "average" }, rays), path);
  return path;
});
tools.mean(truth, truths);
const unsure = compare(...truths).rmse / 2;
function measure(filter, rays) {
  const { cpu_s, adaptive } = tools.render(rateJob(filter, rays), picture);
  const c = compare(truth, picture), mean = compare(picture, picture, "samples").mean_test.find((v) => v > 0);
  return { rmse: Math.sqrt(Math.max(c.rmse ** 2 - unsure ** 2, 0)), bias: c.bias, rays: mean, cpu_s, adaptive };
}
const known = new Map();
const uniform = (side) => {
  if (!known.has(side)) known.set(side, measure({ glossy: "virtual_hit" }, side * side));
  return known.get(side);
};
function uniformOf(rays) { // of both kinds, together
  const side = Math.max(1, Math.floor(Math.sqrt(rays / 2))), a = uniform(side), b = uniform(side + 1);
  return a.rmse * (b.rmse / a.rmse) ** (Math.log(rays / a.rays) / Math.log(b.rays / a.rays));
}
for (const mu of MUS) {
  const a = measure({ indirect: "adaptive", mu }), beside = uniformOf(a.rays);
  console.log(JSON.stringify({ scene: scene.name, side_px: HALF_SIDE.side, method: "adaptive", mu, rays_of_floor: a.rays, rmse: a.rmse,
    bias: a.bias, uniform_rmse: beside, times_lower: beside / a.rmse, reference_rmse: unsure, trace_cpu_s: a.cpu_s.trace,
    filter_cpu_s: a.cpu_s.glossy ?? 0, ...a.adaptive }));
  console.error(`glossy floor, adaptive, mu ${mu}: ${a.rays.toPrecision(4)} rays a pixel of the floor, uniform sampling's ` +
    `RMSE over its ${(beside / a.rmse).toPrecision(3)}`);
}
process.exit(missed > 0 ? 1 : 0);
