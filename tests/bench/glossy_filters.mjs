// Filters of glossy lobes on metals, at equal samples: the error of the layer `indirect` there as a part of its mean
// beside the plain average's, and CPU time beside that of virtual hits in the same run.
//   glossy_filters.mjs BUILD [side=PX] [reference=SPP] [spp=N,...] [scene=NAME,...] [method=NAME,...] [repeat=N] [out=DIR]
// One JSON line a scene, method and count on standard output, tables and bounds on standard error, a plot SCENE.svg of
// each in `out`. Status 1 when a bound is missed. Truth are plain paths, two halves of so many each, kept in `out`, BUILD/bench/glossy unless said. What
// these are apart tells its own error, which is taken off. What pixel centres do not show of a pixel stays in all errors.
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { spawnSync } from "node:child_process";
import { resolve } from "node:path";
import { programs } from "./accuracy/programs.mjs";
import { lines } from "./plot/lines.mjs";
import { glossy } from "./scenes/glossy.mjs";

process.chdir(new URL("../..", import.meta.url).pathname);
const METHODS = ["average", "virtual_hit", "bandlimit", "sg", "sg_mixture", "asg"], PUBLISHED = ["bandlimit", "sg", "sg_mixture", "asg"];
const SEED = 7, PATHS = 1, LAYERS = ["beauty", "indirect", "id"];
// At JUDGED samples: the best published one's error over that of virtual hits, at least, on each scene.
const JUDGED = 16, TIMES = 1;
const [build, ...words] = process.argv.slice(2), WORDS = ["side", "reference", "spp", "scene", "method", "repeat", "out"];
const given = Object.fromEntries(words.map((w) => w.split(/=(.*)/s).slice(0, 2)));
const list = (name, otherwise) => (given[name]?.split(",") ?? otherwise), number = (name, otherwise) => Number(given[name] ?? otherwise);
const names = list("scene", glossy.map((s) => s.name)), methods = list("method", METHODS), counts = list("spp", [4, 16, 64]).map(Number);
const side = number("side", 192), HALF = number("reference", 512), repeat = number("repeat", 3);
const scenes = glossy.filter((s) => names.includes(s.name)), isCount = (n) => Number.isInteger(n) && n > 0;
if (!build || Object.keys(given).some((w) => !WORDS.includes(w)) || scenes.length < names.length || methods.some((m) => !METHODS.includes(m)) ||
    ![side, HALF, repeat, ...counts].every(isCount)) {
  console.error("usage: glossy_filters.mjs BUILD [side=PX] [reference=SPP] [spp=N,...] [scene=NAME,...] [method=NAME,...] [repeat=N] [out=DIR]\n" +
    `scenes: ${glossy.map((s) => s.name).join(" ")}\nmethods: ${METHODS.join(" ")}`);
  process.exit(2);
}

const folder = resolve(given.out ?? `${build}/bench/glossy`);
mkdirSync(folder, { recursive: true });
const tools = programs(build, folder), picture = `${folder}/picture.exr`, truth = `${folder}/truth.exr`;

function compare(scene, a, b) {
  const result = spawnSync(`${build}/shearwater`, ["compare", a, b, "--layer", "indirect", "--where", `id,0.5,${scene.metals + 0.5}`], { encoding: "utf8" });
  if (result.status !== 0) throw new Error(result.stderr);
  return JSON.parse(result.stdout);
}

const jobOf = (scene, file, sampling, filter) => ({ scene: { file, lights: false, camera: scene.camera }, image: { width: side, height: side },
  lights: scene.lights, effects: { indirect_bounces: scene.bounces }, sampling, filter, layers: LAYERS });

// The truth, how far off it is, and the mean of the light, all of the scene's metals.
function truthOf(scene, file) {
  const halves = [901, 902].map((seed) => {
    const path = `${folder}/${scene.name}-${side}-${HALF}-${seed}.exr`;
    if (!existsSync(path)) tools.render(jobOf(scene, file, { spp: HALF, seed }, { method: "none" }), path);
    return path;
  });
  tools.mean(truth, halves);
  const c = compare(scene, ...halves);
  return { unsure: c.rmse / 2, mean: c.mean_reference.reduce((a, b) => a + b) / 3 };
}

function measure(scene, file, method, n, { unsure, mean }) {
  const runs = Array.from({ length: n > JUDGED ? 1 : repeat }, () => tools.render(jobOf(scene, file, { spp: PATHS, indirect_spp: n, seed: SEED }, { indirect: "average", glossy: method }), picture));
  const c = compare(scene, truth, picture), cpu = Math.min(...runs.map((r) => r.cpu_s.glossy ?? 0)), lobes = runs[0].glossy?.pixels_filtered ?? 0;
  return { scene: scene.name, side_px: side, method, spp: n, error: Math.sqrt(Math.max(c.rmse ** 2 - unsure ** 2, 0)) / mean, bias: c.bias / mean,
    reference_error: unsure / mean, filter_cpu_s: cpu, filter_s_per_megapixel: cpu / (side * side / 1e6),
    filter_s_per_megapixel_of_lobes: lobes ? cpu / (lobes / 1e6) : null, trace_cpu_s: Math.min(...runs.map((r) => r.cpu_s.trace)) };
}

const percent = (x) => (100 * x).toPrecision(3);

// Errors by row and count, then what they are of the average's, then CPU time beside that of virtual hits.
function table(scene, rows, known) {
  const of = (method, spp) => rows.find((r) => r.scene === scene.name && r.method === method && r.spp === spp);
  console.error(`${scene.name}: ${scene.about}; error in % of the mean (times lower than the average's), reference ${percent(known.unsure / known.mean)} %`);
  console.error(`${"".padEnd(12)}${counts.map((n) => `${n} spp`.padStart(20)).join("")}${"CPU s/MP of lobes".padStart(20)}${"of virtual_hit's".padStart(18)}`);
  for (const method of methods) {
    const errors = counts.map((n) => {
      const row = of(method, n), plain = of("average", n);
      return `${percent(row.error)}${plain ? ` (${(plain.error / row.error).toPrecision(3)})` : ""}`.padStart(20);
    });
    const timed = of(method, counts.includes(JUDGED) ? JUDGED : counts[0]), beside = of("virtual_hit", timed.spp), s = timed.filter_s_per_megapixel_of_lobes;
    const ratio = s && beside?.filter_cpu_s ? (timed.filter_cpu_s / beside.filter_cpu_s).toPrecision(2) : "";
    console.error(`${method.padEnd(12)}${errors.join("")}${(s?.toPrecision(3) ?? "").padStart(20)}${ratio.padStart(18)}`);
  }
}

// Error over rays, a line a method.
function plotOf(scene, rows) {
  const points = (method) => rows.filter((r) => r.scene === scene.name && r.method === method).map((r) => [r.spp, 100 * r.error]);
  return lines({ title: scene.about, xLabel: "rays a lobe", yLabel: "error, % of the mean", xTicks: counts, series: methods.map((name) => ({ name, points: points(name) })) });
}

const rows = [];
for (const scene of scenes) {
  const file = `${folder}/${scene.name}.glb`;
  writeFileSync(file, scene.glb());
  const known = truthOf(scene, file);
  for (const n of counts)
    for (const method of methods) {
      const row = measure(scene, file, method, n, known);
      rows.push(row);
      const plain = rows.find((r) => r.scene === scene.name && r.spp === n && r.method === "average");
      console.log(JSON.stringify({ ...row, times_lower: plain ? plain.error / row.error : null }));
    }
  table(scene, rows, known);
  writeFileSync(`${folder}/${scene.name}.svg`, plotOf(scene, rows));
}

// What knowing distances, edges of roughness and turning normals at once is worth, scene by scene.
let missed = 0;
const times = scenes.map((scene) => {
  const at = rows.filter((r) => r.scene === scene.name && r.spp === JUDGED), own = at.find((r) => r.method === "virtual_hit");
  const others = at.filter((r) => PUBLISHED.includes(r.method)).sort((a, b) => a.error - b.error);
  if (!own || others.length === 0) return null;
  const value = others[0].error / own.error, ok = value >= TIMES;
  missed += ok ? 0 : 1;
  console.error(`${scene.name}, ${JUDGED} spp: error of ${others[0].method}, the best published one, over that of virtual hits ${value.toPrecision(3)} (bound >= ${TIMES}) ${ok ? "reached" : "MISSED"}`);
  return value;
}).filter((v) => v !== null).sort((a, b) => a - b);
if (times.length > 1) {
  const middle = (times.length - 1) / 2;
  console.error(`median of ${times.length} scenes: ${((times[Math.floor(middle)] + times[Math.ceil(middle)]) / 2).toPrecision(3)}`);
}
process.exit(missed > 0 ? 1 : 0);
