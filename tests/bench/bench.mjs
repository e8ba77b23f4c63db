// make bench: all that is measured, as JSON lines, plots and one report. By parts, if asked to: what earlier
// runs of the same build measured on the same machine is joined with it.
//   bench.mjs BUILD [quick|smoke] [report|accept|results] [part=NAME,...] [effect=NAME,...] [scene=NAME,...]
//     [method=NAME,...] [spp=N,...] [mu=N,...] [side=PX] [reference=SPP] [repeat=N] [seed=N] [workers=N,...]
//     [heights=PX,...] [kinds=NAME,...] [steps=N,...] [peers=DIR] [weights=FILE] [out=DIR] [figures=FILE] [runs=N]
// report: nothing is measured, the report is made of the lines there are. accept: measures `runs` times, with
// other seeds, and writes the figures that the gate holds later runs to; with part= those of some parts alone.
// results: writes RESULTS.md and its part of README.md. peers: the folder of part=real's scenes, $SHEARWATER_PEERS
// unless said. weights: the denoiser's, $SHEARWATER_PEER_WEIGHTS unless said; quick and smoke do without. Status 1 when a skip does not hold or a figure got worse than the gate allows.
import { mkdirSync, readFileSync } from "node:fs";
import { availableParallelism } from "node:os";
import { resolve } from "node:path";
import { sentence } from "./accuracy/bounds.mjs";
import { effects } from "./accuracy/effects.mjs";
import { peersFolder, weightsFile } from "./folders.mjs";
import { accept, judge, read } from "./gate.mjs";
import { effectBounds, rowsOf } from "./judged.mjs";
import { Lines } from "./lines.mjs";
import { loadOf, machineOf } from "./machine.mjs";
import { accuracy } from "./parts/accuracy.mjs";
import { resolution, triangles, workers } from "./parts/farms.mjs";
import { links, overlap } from "./parts/overlap.mjs";
import { flicker } from "./parts/flicker.mjs";
import { mixed } from "./parts/mixed.mjs";
import { RATES, rate } from "./parts/rates.mjs";
import { absentScenes, real } from "./parts/real.mjs";
import { summary } from "./parts/runs.mjs";
import { skips } from "./parts/skips.mjs";
import { writeReport } from "./report/page.mjs";
import { writeResults } from "./results.mjs";
import { scenes } from "./scenes/scenes.mjs";

const cores = availableParallelism(), upTo = (n) => Array.from({ length: n }, (_, i) => i + 1);
const OWN = { accuracy, real, workers, resolution, triangles, overlap, links, skips, flicker, mixed };
const FULL = { mode: "full", parts: [...Object.keys(OWN), ...RATES], scenes: scenes.map((s) => s.name), accuracy: [], repeat: 5, workersHeight: 720, workers: upTo(cores),
  heights: [360, 540, 720, 1080, 1440, 2160], kinds: ["fields", "paths", "lens"], hillSteps: [16, 50, 158, 500, 1000], hillSide: 512, skipSide: 512, overlapSizes: [[512, 512], [1280, 720]], runs: 3 };
// Three minutes on two cores, from nothing but the build.
const QUICK = { ...FULL, mode: "quick", parts: Object.keys(OWN).filter((name) => !["links", "flicker", "mixed"].includes(name)), scenes: ["contacts", "curved", "box", "posts", "all_box"],
  accuracy: ["smoke", "side=80", "spp=4,9,16,36"], repeat: 3, workersHeight: 240, heights: [90, 180, 360], kinds: ["fields", "paths"], hillSteps: [16, 64, 256], hillSide: 160, skipSide: 192, overlapSizes: [[512, 512]] };
// A test of the bench itself, beside whatever else the machine does. Filters take milliseconds of it, mostly to
// touch memory for the first time, which costs five times as much on one virtual machine as on another: times
// are said, not judged.
const SMOKE_SLACK = Infinity;
const SMOKE = { ...QUICK, mode: "smoke", repeat: 1, scenes: ["contacts", "box"], accuracy: ["smoke", "side=48", "spp=4,9,16"], heights: [90, 180], hillSteps: [16, 64], hillSide: 96, overlapSizes: [[192, 192]] };
const ACTIONS = ["report", "accept", "results"];
const PASSED_ON = ["effect", "method", "spp", "mu", "side", "reference", "repeat", "seed"];
const WORDS = [...PASSED_ON, "part", "scene", "workers", "heights", "kinds", "steps", "peers", "weights", "out", "figures", "runs"];

process.chdir(new URL("../..", import.meta.url).pathname);

const NAMES = `parts: ${FULL.parts.join(" ")}\neffects: ${Object.keys(effects).join(" ")}\nscenes: ${scenes.map((s) => s.name).join(" ")}\nreal scenes: those of the peers folder, living_room_lens, and lamps`;

function usage(sentence) {
  console.error(`bench: ${sentence}\n${NAMES}`);
  process.exit(2);
}

// The head of this file, and the names there are.
function help() {
  const own = readFileSync("tests/bench/bench.mjs", "utf8").split("\n");
  console.log(`${own.slice(0, own.findIndex((l) => !l.startsWith("//"))).map((l) => l.slice(3)).join("\n")}\n${NAMES}`);
  process.exit(0);
}

const list = (text) => text?.split(/[, ]+/).filter(Boolean);

function known(what, asked, names) {
  const absent = asked?.find((name) => !names.includes(name));
  if (absent) usage(`there is no ${what} "${absent}"`);
  return asked;
}

// Scenes of the part accuracy. Parts with scenes of their own know the names of these.
function chosen(base, given, parts) {
  const names = scenes.map((s) => s.name), others = parts.includes("real") || parts.includes("flicker");
  const named = others ? list(given.scene)?.filter((name) => names.includes(name)) : known("scene", list(given.scene), names), kinds = known("effect", list(given.effect), Object.keys(effects));
  const all = named ?? base.scenes;
  return kinds ? all.filter((name) => kinds.includes(scenes.find((s) => s.name === name).effect)) : all;
}

function parse([build, ...words]) {
  if ([build, ...words].includes("--help")) help();
  const action = words.find((w) => ACTIONS.includes(w)), base = words.includes("quick") ? QUICK : words.includes("smoke") ? SMOKE : FULL;
  const stray = words.find((w) => !w.includes("=") && !["quick", "smoke", ...ACTIONS].includes(w));
  const given = Object.fromEntries(words.filter((w) => w.includes("=")).map((w) => w.split(/=(.*)/s).slice(0, 2)).filter(([, v]) => v !== ""));
  const unknown = stray ?? Object.keys(given).find((name) => !WORDS.includes(name));
  if (!build || unknown) usage(unknown ? `"${unknown}" is unknown` : "which build?");
  const numbers = (name, other) => list(given[name])?.map(Number) ?? other;
  // A choice of what pictures are compared is a choice of that part, and a folder of scenes of its own.
  const parts = known("part", list(given.part), FULL.parts) ?? (given.peers ? ["real"] : PASSED_ON.some((w) => w !== "repeat" && w !== "seed" && given[w]) || given.scene ? ["accuracy"] : base.parts);
  const o = { ...base, action, parts, scenes: chosen(base, given, parts), realNames: list(given.scene), peers: peersFolder(given.peers), weights: base === FULL || given.weights ? weightsFile(build, given.weights) : null, build: resolve(build), cores, given,
    out: resolve(given.out ?? (base === FULL ? `${build}/bench` : `${build}/bench/${base.mode}`)), figures: resolve(given.figures ?? "tests/bench/figures.json"),
    workers: numbers("workers", base.workers), heights: numbers("heights", base.heights), hillSteps: numbers("steps", base.hillSteps),
    kinds: list(given.kinds) ?? base.kinds, runs: Number(given.runs ?? base.runs), repeat: Number(given.repeat ?? base.repeat) };
  o.accuracy = [...base.accuracy.filter((w) => !given[w.split("=")[0]]), ...PASSED_ON.filter((w) => w !== "effect" && given[w]).map((w) => `${w}=${given[w]}`)];
  if (given.weights && !o.weights) usage(`there are no weights at ${given.weights}`);
  const real = parts.every((name) => name === "real") ? absentScenes(o) : null;
  if (real) usage(`there is no real scene "${real.absent[0]}": ${real.names.join(" ")}`);
  // All that the mode measures; and whether what is measured is measured as the committed figures were.
  const only = (names) => Object.keys(given).every((w) => ["out", "figures", "runs", ...names].includes(w));
  o.whole = only([]);
  o.comparable = only(["part", "scene", "effect"]);
  return o;
}

async function measure(o, lines) {
  const failures = [], began = Date.now(), run = { ...o, summary, put: (...args) => lines.put(...args),
    say: (sentence) => console.error(`# ${sentence}`), fail: (sentence) => { failures.push(sentence); console.error(sentence); } };
  lines.put("machine", "", { ...machineOf(), load_before: loadOf() });
  for (const part of o.parts) {
    const from = Date.now();
    await (OWN[part] ?? ((options) => rate(options, part)))(run);
    lines.put("took", part, { of: part, wall_s: (Date.now() - from) / 1000 });
  }
  console.error(`measured in ${((Date.now() - began) / 1000).toFixed(0)} s`);
  return failures;
}

// Medians over an effect's scenes, where all of them are there.
function sayBounds(o, lines, say) {
  const all = effectBounds(rowsOf(lines.all()), scenes).filter((b) => b.judged);
  if (!o.parts.includes("accuracy") || all.length === 0) return;
  say("over all scenes of an effect:");
  for (const b of all) say(sentence({ ...b, figure: `${b.effect}: ${b.of ? `${b.of}, ` : ""}${b.figure}` }));
}

async function acceptAll(o, common) {
  const runs = [];
  for (let i = 0; i < o.runs; i++) {
    console.error(`run ${i + 1} of ${o.runs}`);
    const lines = new Lines(`${o.out}/lines-${i}.jsonl`, common);
    // The first with the seed that the gate's runs have.
    await measure(i === 0 ? o : { ...o, accuracy: [...o.accuracy, `seed=${100 + i}`], given: { ...o.given, seed: 100 + i } }, lines);
    runs.push(lines.fresh());
  }
  const { cpu, cores: count, instructions } = machineOf();
  accept(o.figures, o.mode, runs, { build: common.build, machine: `${cpu}, ${count} cores, ${instructions}` }, o.whole);
  console.error(`accepted: ${o.figures}`);
  return 0;
}

async function main() {
  const o = parse(process.argv.slice(2)), machine = machineOf();
  mkdirSync(o.out, { recursive: true });
  const common = { build: readFileSync(`${o.build}/build_id.h`, "utf8").match(/"(.*)"/)?.[1], machine: machine.id };
  if (o.action === "accept") return acceptAll(o, common);
  const lines = new Lines(`${o.out}/lines.jsonl`, common);
  const failures = o.action ? [] : await measure(o, lines);
  const committed = read(o.figures, o.mode), say = (sentence) => console.error(sentence);
  if (!o.action) sayBounds(o, lines, say);
  const gate = committed && !o.action && o.comparable ? judge(committed, lines.fresh(), o.whole, say, o.mode === "smoke" ? SMOKE_SLACK : 1) : null;
  const page = writeReport(o, lines.all(), gate && { ...gate, committed });
  console.error(`report: ${page}`);
  if (o.action === "results") writeResults(o, lines.all());
  return failures.length > 0 || gate?.ok === false ? 1 : 0;
}

process.exitCode = await main();
