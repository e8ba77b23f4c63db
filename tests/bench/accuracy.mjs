// make bench-accuracy: pictures of every scene, method and sample count against converged ones.
//   accuracy.mjs BUILD [quick|smoke] [scene=NAME,...] [method=NAME,...] [spp=N,...] [reference=SPP] [repeat=N] [out=DIR]
// One JSON line per measurement on standard output and in OUT/accuracy.jsonl; then the bounds, one
// line each, with a sentence for people on standard error; plots and report.html in OUT (BUILD/bench).
// Exit status 1 when a bound is missed.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { bounds } from "./accuracy/factors.mjs";
import { METHODS } from "./accuracy/job.mjs";
import { measureScene, SEED } from "./accuracy/measure.mjs";
import { programs } from "./accuracy/programs.mjs";
import { plotsOf, writeReport } from "./accuracy/report.mjs";
import { scenes } from "./scenes/scenes.mjs";

const FULL = { side: 512, spp: [4, 9, 16, 25, 36, 49, 64, 100, 144, 256], more: [576, 1024], referenceSpp: 65536, beautySeeds: 16, repeat: 5, repeatSpp: [9], scenes };
const QUICK = { side: 256, spp: [4, 9, 25, 100], more: [400], referenceSpp: 4096, beautySeeds: 4, repeat: 3, repeatSpp: [9],
  scenes: scenes.filter((s) => ["contacts", "large_light", "curved"].includes(s.name)) };

const SMOKE = { side: 64, spp: [4, 9], more: [25], referenceSpp: 4096, beautySeeds: 2, repeat: 1, repeatSpp: [],
  scenes: scenes.filter((s) => s.name === "contacts") };

const ROOT = new URL("../..", import.meta.url).pathname;
process.chdir(ROOT);

function fail(sentence) {
  console.error(`accuracy: ${sentence}`);
  process.exit(2);
}

function parse(argv) {
  const [build, ...rest] = argv;
  if (argv.includes("--help")) {
    console.log("accuracy.mjs BUILD [quick|smoke] [scene=NAME,...] [method=NAME,...] [spp=N,...] [reference=SPP] [repeat=N] [out=DIR]\n" +
      `scenes: ${scenes.map((s) => s.name).join(" ")}\nmethods: ${METHODS.join(" ")}\n` +
      "Compares pictures with converged ones: JSON lines, plots and report.html in BUILD/bench. Status 1 when a bound is missed.");
    process.exit(0);
  }
  if (!build) fail("usage: accuracy.mjs BUILD [quick|smoke] [scene=,] [method=,] [spp=,] [reference=] [repeat=] [out=]");
  const given = Object.fromEntries(rest.filter((w) => w.includes("=")).map((w) => w.split(/=(.*)/s).slice(0, 2)));
  const unknown = Object.keys(given).find((k) => !["scene", "method", "spp", "reference", "repeat", "out"].includes(k));
  const stray = rest.find((w) => !w.includes("=") && !["quick", "smoke"].includes(w));
  if (unknown ?? stray) fail(`"${unknown ?? stray}" is unknown`);
  const list = (name) => given[name]?.split(/[, ]+/).filter(Boolean);
  const base = rest.includes("quick") ? QUICK : rest.includes("smoke") ? SMOKE : FULL, o = { ...base, folder: resolve(build), seed: SEED, refused: new Map() };
  const wanted = list("scene"), spp = list("spp")?.map(Number);
  const absent = wanted?.find((name) => !scenes.some((s) => s.name === name));
  if (absent) fail(`there is no scene "${absent}": ${scenes.map((s) => s.name).join(", ")}`);
  if (wanted) o.scenes = scenes.filter((s) => wanted.includes(s.name));
  o.methods = list("method") ?? METHODS;
  o.spp = (method) => spp ?? (method === "average" ? [...base.spp, ...base.more] : base.spp);
  o.out = resolve(given.out ?? `${build}/bench`);
  o.references = `${o.folder}/bench/reference`;
  o.build = readFileSync(`${o.folder}/build_id.h`, "utf8").match(/"(.*)"/)?.[1];
  o.shared = process.env.SHEARWATER_SCENES ?? "../shared/scenes";
  if (given.reference) o.referenceSpp = Number(given.reference);
  if (given.repeat) o.repeat = Number(given.repeat);
  o.say = (sentence) => console.error(`# ${sentence}`);
  return o;
}

function printBounds(list) {
  for (const b of list) {
    console.log(JSON.stringify({ figure: b.figure, value: b.value, bound: b.bound === null ? null : `${b.relation} ${b.bound}`, unit: b.unit,
      least: b.least, most: b.most, scenes: b.scenes, ok: b.ok }));
    console.error(`${b.figure.padEnd(58)} ${b.value.toPrecision(3).padStart(10)} ${b.unit.padEnd(12)} ` +
      (b.bound === null ? "" : `(bound ${b.relation} ${Number(b.bound.toPrecision(3))}) ${b.ok ? "reached" : "MISSED"}`));
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
    for (const { picture, ...row } of measured.rows) {
      lines.push(JSON.stringify(row));
      console.log(lines.at(-1));
    }
    for (const [name, svg] of Object.entries(plotsOf(scene, measured.rows)))
      if (svg) writeFileSync(`${o.out}/${scene.name}-${name}.svg`, svg);
    // After each scene: a long run shows what it has.
    writeFileSync(`${o.out}/accuracy.jsonl`, lines.map((l) => l + "\n").join(""));
    writeReport(tools, results, bounds(results.flatMap((r) => r.rows)), o);
  }
  for (const [method, why] of o.refused) o.say(`not measured: ${method}: ${why}`);
  const judged = bounds(results.flatMap((r) => r.rows));
  printBounds(judged);
  console.error(`report: ${o.out}/report.html`);
  return judged.every((b) => b.ok) ? 0 : 1;
}

process.exitCode = main();
