// make bench-accuracy: pictures of every scene, method and sample count against converged ones.
//   accuracy.mjs BUILD [quick|smoke] [effect=NAME,...] [scene=NAME,...] [method=NAME,...] [spp=N,...]
//     [mu=N,...] [side=PX] [reference=SPP] [repeat=N] [seed=N] [out=DIR]
// One JSON line per measurement on standard output and in OUT/accuracy.jsonl; then the bounds, one
// line each, with a sentence for people on standard error; plots and report.html in OUT (BUILD/bench).
// Exit status 1 when a bound is missed, and after a whole run also when one was not measured or a
// reference is not good enough for what it judged. A run is whole when nothing but effects is chosen.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { bounds, sentence } from "./accuracy/bounds.mjs";
import { effects } from "./accuracy/effects.mjs";
import { measureScene, SEED } from "./accuracy/measure.mjs";
import { programs } from "./accuracy/programs.mjs";
import { plotsOf, writeReport } from "./accuracy/report.mjs";
import { scenesFolder } from "./folders.mjs";
import { scenes } from "./scenes/scenes.mjs";

// By effect: counts of samples (mu of methods whose samples are turned by it), and more of them for the
// plain average; the most samples of one half of a reference.
const FULL = { side: 512, beautySeeds: { shadows: 16, indirect: 4 }, repeat: 5, repeatSpp: { shadows: 9, indirect: 16, lens: 9, combined: 9 }, scenes,
  spp: { shadows: [4, 9, 16, 25, 49, 100, 256], indirect: [4, 9, 16, 36, 64, 256], lens: [4, 9, 16, 25, 64, 256], combined: [4, 9, 16, 25, 64] },
  mu: [0.5, 0.7, 1, 1.4, 2, 2.8], more: { shadows: [576, 1024], indirect: [576], lens: [], combined: [144, 256] },
  referenceSpp: { shadows: 65536, indirect: 4096, lens: 16384, combined: 8192 } };
const QUICK = { side: 256, beautySeeds: { shadows: 4, indirect: 2 }, repeat: 3, repeatSpp: { shadows: 9, lens: 9, combined: 9 },
  scenes: scenes.filter((s) => ["contacts", "large_light", "curved", "box", "posts", "fence_room", "all_box"].includes(s.name)),
  spp: { shadows: [4, 9, 25, 100], indirect: [4, 16, 36, 100], lens: [4, 9, 25, 100], combined: [4, 9, 25, 64] }, mu: [0.5, 1, 2],
  more: { shadows: [400], indirect: [400], lens: [256], combined: [256] }, referenceSpp: { shadows: 4096, indirect: 2048, lens: 4096, combined: 4096 } };
const SMOKE = { side: 64, beautySeeds: { shadows: 2, indirect: 2 }, repeat: 1, repeatSpp: {}, scenes: scenes.filter((s) => ["contacts", "box", "posts", "all_box"].includes(s.name)),
  spp: { shadows: [9], indirect: [16], lens: [9], combined: [9] }, mu: [0.5, 1], more: { shadows: [4, 25], indirect: [4, 100], lens: [4, 25], combined: [4, 25] },
  referenceSpp: { shadows: 2048, indirect: 1024, lens: 1024, combined: 1024 } };
const METHODS = [...new Set(Object.values(effects).flatMap((e) => e.methods))];
const WORDS = ["effect", "scene", "method", "spp", "mu", "side", "reference", "repeat", "seed", "out"];
const USAGE = "accuracy.mjs BUILD [quick|smoke] [effect=NAME,...] [scene=NAME,...] [method=NAME,...] [spp=N,...] [mu=N,...] [side=PX] [reference=SPP] [repeat=N] [seed=N] [out=DIR]";

const ROOT = new URL("../..", import.meta.url).pathname;
process.chdir(ROOT);

function fail(sentence) {
  console.error(`accuracy: ${sentence}`);
  process.exit(2);
}

function parse(argv) {
  const [build, ...rest] = argv;
  if (argv.includes("--help")) {
    console.log(`${USAGE}\neffects: ${Object.keys(effects).join(" ")}\n` +
      `scenes: ${scenes.map((s) => s.name).join(" ")}\nmethods: ${METHODS.join(" ")}\n` +
      "Compares pictures with converged ones: JSON lines, plots and report.html in BUILD/bench. Status 1 when a bound is missed.");
    process.exit(0);
  }
  if (!build) fail(`usage: ${USAGE}`);
  const given = Object.fromEntries(rest.filter((w) => w.includes("=")).map((w) => w.split(/=(.*)/s).slice(0, 2)));
  const unknown = Object.keys(given).find((k) => !WORDS.includes(k));
  const stray = rest.find((w) => !w.includes("=") && !["quick", "smoke"].includes(w));
  if (unknown ?? stray) fail(`"${unknown ?? stray}" is unknown`);
  const list = (name) => given[name]?.split(/[, ]+/).filter(Boolean);
  const base = rest.includes("quick") ? QUICK : rest.includes("smoke") ? SMOKE : FULL, o = { ...base, folder: resolve(build), seed: SEED, refused: new Map() };
  const known = { effect: Object.keys(effects), scene: scenes.map((s) => s.name), method: METHODS };
  for (const [word, names] of Object.entries(known)) {
    const absent = list(word)?.find((name) => !names.includes(name));
    if (absent) fail(`there is no ${word} "${absent}": ${names.join(", ")}`);
  }
  const spp = list("spp")?.map(Number);
  if (list("scene")) o.scenes = scenes.filter((s) => list("scene").includes(s.name));
  if (list("effect")) o.scenes = o.scenes.filter((s) => list("effect").includes(s.effect));
  o.methods = list("method") ?? METHODS;
  o.spp = (effect, method) => spp ?? (method === "average" ? [...base.spp[effect], ...base.more[effect]].sort((a, b) => a - b) : base.spp[effect]);
  o.mu = list("mu")?.map(Number) ?? base.mu;
  if (given.side) o.side = Number(given.side);
  o.whole = base === FULL && ["scene", "method", "spp", "mu", "side", "reference"].every((word) => !given[word]);
  o.out = resolve(given.out ?? `${build}/bench`);
  o.references = `${o.folder}/bench/reference`;
  o.build = readFileSync(`${o.folder}/build_id.h`, "utf8").match(/"(.*)"/)?.[1];
  o.shared = scenesFolder();
  if (given.reference) o.referenceSpp = Object.fromEntries(Object.keys(effects).map((name) => [name, Number(given.reference)]));
  if (given.repeat) o.repeat = Number(given.repeat);
  if (given.seed) o.seed = Number(given.seed);
  o.say = (sentence) => console.error(`# ${sentence}`);
  return o;
}

function printBounds(list) {
  for (const b of list) {
    console.log(JSON.stringify({ effect: b.effect, figure: b.figure, value: b.value, bound: b.bound === null ? null : `${b.relation} ${b.bound}`, unit: b.unit,
      least: b.least, most: b.most, scenes: b.scenes, ok: b.ok }));
    console.error(sentence(b));
  }
}

function main() {
  const o = parse(process.argv.slice(2));
  mkdirSync(o.out, { recursive: true });
  const tools = programs(o.folder, o.out);
  const results = [], lines = [];
  for (const scene of o.scenes) {
    const measured = measureScene(tools, scene, o);
    if (!measured) continue;
    results.push({ scene, ...measured });
    for (const row of measured.rows) {
      lines.push(JSON.stringify({ ...row, reference_picture: measured.reference.path }));
      console.log(lines.at(-1));
    }
    for (const [name, svg] of Object.entries(plotsOf(scene, measured.rows)))
      if (svg) writeFileSync(`${o.out}/${scene.name}-${name}.svg`, svg);
    // After each scene: a long run shows what it has.
    writeFileSync(`${o.out}/accuracy.jsonl`, lines.map((l) => l + "\n").join(""));
    writeReport(tools, results, bounds(results.flatMap((r) => r.rows)).filter((b) => b.ok !== null), o);
  }
  for (const [method, why] of o.refused) o.say(`not measured: ${method}: ${why}`);
  const asked = new Set(o.scenes.map((s) => s.effect)), all = bounds(results.flatMap((r) => r.rows)).filter((b) => asked.has(b.effect));
  const judged = o.whole ? all : all.filter((b) => b.ok !== null);
  const poor = results.filter((r) => r.rows.some((row) => !row.reference.good)).map((r) => r.scene.name);
  printBounds(judged);
  if (poor.length > 0) console.error(`references not good enough for what they judged: ${poor.join(", ")}`);
  console.error(`report: ${o.out}/report.html`);
  return judged.every((b) => b.ok) && !(o.whole && poor.length > 0) ? 0 : 1;
}

process.exitCode = main();
