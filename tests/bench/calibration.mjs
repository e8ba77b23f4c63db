// How well pictures of real scenes know their own error: the layer `error` of few samples beside two references.
//   calibration.mjs BUILD [scene=NAME,...] [spp=4,16] [filter=halves|none] [peers=FOLDER]
// One JSON line a picture on standard output, and a sentence for people on standard error. Status 1 when a bound is
// missed, 0 without the peers folder. filter: of paths, in place of the plan's choice.
import { spawnSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { resolve } from "node:path";
import { programs } from "./accuracy/programs.mjs";
import { peersFolder } from "./folders.mjs";
import { peersScenes } from "./scenes/peers.mjs";

process.chdir(new URL("../..", import.meta.url).pathname);
const [build, ...words] = process.argv.slice(2);
const given = Object.fromEntries(words.map((w) => w.split(/=(.*)/s).slice(0, 2)));
const WITHIN = [0.9, 0.99], SEED = 1, spps = (given.spp ?? "4,16").split(",").map(Number);

if (!build) {
  console.error("usage: calibration.mjs BUILD [scene=NAME,...] [spp=4,16] [filter=halves|none] [peers=FOLDER]");
  process.exit(2);
}
const folder = resolve(build, "bench/calibration"), scenes = peersScenes(peersFolder(given.peers));
if (!scenes) {
  console.error("calibration: skipped, there is no peers folder");
  process.exit(0);
}
mkdirSync(folder, { recursive: true });
const tools = programs(build, folder);

function known(references, picture) {
  const result = spawnSync(`${build}/tests/bench/exr_calibration`, [...references, picture], { encoding: "utf8" });
  if (result.status !== 0) throw new Error(result.stderr);
  return JSON.parse(result.stdout);
}

function measure(scene, spp) {
  const picture = `${folder}/picture.exr`, filter = given.filter ? { residual: given.filter } : {};
  tools.render({ ...scene.job, sampling: { spp, seed: SEED }, filter, layers: ["beauty", "error"] }, picture);
  const { error, estimate, within } = known(scene.references, picture);
  return { scene: scene.name, spp, error, estimate, ratio: estimate / error, within, ok: within >= WITHIN[0] && within <= WITHIN[1] };
}

const wanted = given.scene?.split(","), round = (v) => v.toPrecision(3);
let missed = 0;
for (const scene of scenes.filter((s) => s.references && (!wanted || wanted.includes(s.name))))
  for (const spp of spps) {
    const line = measure(scene, spp);
    missed += line.ok ? 0 : 1;
    console.log(JSON.stringify(line));
    console.error(`calibration ${scene.name}, ${spp} spp: estimate over error ${round(line.ratio)}; off by at most two estimates ` +
      `${round(100 * line.within)} % (bound ${100 * WITHIN[0]} to ${100 * WITHIN[1]} %) ${line.ok ? "reached" : "MISSED"}`);
  }
process.exit(missed > 0 ? 1 : 0);
