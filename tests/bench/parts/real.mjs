// Pictures of real scenes beside two independent references each: what filters make of few samples, what it costs,
// and what a neural denoiser makes of the same paths, or made of an older build's where its weights are not there. Of
// the peers folder; the small bench has two scenes of its own.
import { mkdirSync } from "node:fs";
import { programs } from "../accuracy/programs.mjs";
import { realBounds, realSentence } from "../real/bounds.mjs";
import { filterSeconds, pictureSeconds } from "../real/cost.mjs";
import { denoised, denoiserSeconds } from "../real/denoiser.mjs";
import { equalCpu, equalSentence } from "../real/equal_cpu.mjs";
import { makeReferences } from "../real/references.mjs";
import { GLOSS_NAMES, glossScenes } from "../scenes/gloss.mjs";
import { LAMPS, lampsScene } from "../scenes/lamps.mjs";
import { peersScenes } from "../scenes/peers.mjs";
import { SMALL_NAMES, smallScenes } from "../scenes/real.mjs";
import { KITCHEN_NAMES, kitchenScenes } from "../scenes/kitchen.mjs";
import { ROOM_NAMES, roomScenes } from "../scenes/room.mjs";
import { TABLE_NAMES, tableScenes } from "../scenes/table.mjs";
import { withFarm } from "./farms.mjs";
import { summary } from "./runs.mjs";

const METHODS = ["none", "auto"], WARM_UP = 8, OWN_WIDTH = 240;

// What is measured if nothing is said. width: of small scenes, which take the place of the peers folder then.
const FULL = { spp: [1, 4, 16, 64], referenceSpp: 1024 };
const SMALL = { quick: { spp: [4, 16], width: 160, referenceSpp: 576 }, smoke: { spp: [4], width: 48, referenceSpp: 256 } };

// Too long to be run more than once.
const isLong = (spp) => spp > 16;

function settings({ mode, given, repeat, out }) {
  const base = SMALL[mode] ?? FULL, list = (text) => text?.split(/[, ]+/).filter(Boolean);
  return { ...base, spp: list(given.spp)?.map(Number) ?? base.spp, methods: list(given.method) ?? METHODS, seed: Number(given.seed ?? 1),
    times: (spp) => given.repeat ? repeat : isLong(spp) ? 1 : Math.min(repeat, 3), folder: `${out}/real` };
}

// Those of the peers folder and the bench's own; null where there is no such folder.
function fullScenes({ out, peers }) {
  const scenes = peersScenes(peers), own = [`${out}/real`, OWN_WIDTH];
  return scenes && [...scenes, lampsScene(...own), ...tableScenes(...own), ...roomScenes(...own), ...kitchenScenes(...own), ...glossScenes(...own)];
}

// Those that there are; null where the peers folder is wanted and not there.
const realScenes = (o) => SMALL[o.mode] ? smallScenes(`${o.out}/real`, SMALL[o.mode].width) : fullScenes(o);

const jobOf = ({ job }, method, spp, seed) => ({ ...job, sampling: { spp, seed }, filter: { method } });

// Import and BVH, which no picture's cost has then.
async function warmUp(farm, scene) {
  const { width, height } = scene.job.image, small = (side) => Math.max(8, Math.round(side / WARM_UP));
  const job = jobOf(scene, "none", 1, 1);
  await farm.run({ ...job, image: { ...job.image, width: small(width), height: small(height) } });
}

function rowOf({ scene, width, height, references, reference }, method, spp, more) {
  return { scene: scene.name, about: scene.about, method, spp, width, height, megapixels: width * height / 1e6, references, reference_picture: reference, ...more };
}

// All methods at one count of samples, in turn, so that what else the machine does meets all alike.
async function measureStep(farm, tools, o, set, at, spp) {
  const runs = set.methods.map(() => []), picture = (method) => `${set.folder}/${at.scene.name}-${method}-${spp}.exr`;
  o.say(`real: ${at.scene.name}, ${spp} spp`);
  for (let i = 0; i < set.times(spp); i++)
    for (const [k, method] of set.methods.entries())
      runs[k].push(await farm.run(jobOf(at.scene, method, spp, set.seed), i === 0 ? picture(method) : null));
  const sums = set.methods.map((method, k) => ({ method, ...summary(runs[k]) })), none = sums.find((s) => s.method === "none");
  for (const { method, ...cost } of sums)
    o.put("real", `${at.scene.name} ${method} ${spp} spp`, rowOf(at, method, spp, { seed: set.seed,
      ...tools.besidePair(...at.references, picture(method)), ...cost,
      picture_s: pictureSeconds(cost.cpu_min_s), filters_s_per_megapixel: filterSeconds(cost.cpu_min_s) / (at.width * at.height / 1e6),
      trace_over_none: none && method !== "none" ? cost.cpu_min_s.trace / none.cpu_min_s.trace : null, picture: picture(method) }));
  return none && pictureSeconds(none.cpu_min_s);
}

// By the denoiser: of these very paths, or what lies in the folder. none_s: what the paths take.
async function measureDenoiser(farm, tools, o, set, at, spp, none_s) {
  const out = `${set.folder}/${at.scene.name}-oidn-${spp}.exr`, older = at.scene.oidn?.[spp];
  const put = (picture, more) => o.put("real", `${at.scene.name} oidn ${spp} spp`, rowOf(at, "oidn", spp, { ...tools.besidePair(...at.references, picture), ...more, picture }));
  if (o.weights)
    put(out, { seed: set.seed, ...await denoised(farm, tools, jobOf(at.scene, "none", spp, set.seed), { weights: o.weights, out, none_s, seconds: set.denoiser_s }) });
  else if (!o.weights && older) put(older, { paths: "older" });
}

async function measureScene(farm, tools, o, set, scene) {
  const { width, height } = scene.job.image, reference = `${set.folder}/${scene.name}-reference.exr`;
  await warmUp(farm, scene);
  const references = scene.references ?? await makeReferences(farm, tools, scene, { folder: `${o.build}/bench/reference`, spp: set.referenceSpp, say: o.say });
  tools.mean(reference, references);
  const at = { scene, width, height, references, reference };
  for (const spp of set.spp) await measureDenoiser(farm, tools, o, set, at, spp, await measureStep(farm, tools, o, set, at, spp));
}

function judge(o, rows) {
  for (const b of realBounds(rows)) {
    o.put("figure", `real ${b.figure}`, { from: "real", figure: b.figure, value: b.value === null ? null : Number(b.value.toPrecision(4)), bound: `${b.relation} ${b.bound}`, unit: b.unit, ok: b.ok });
    console.error(realSentence(b));
  }
}

// {absent, names}: what was asked for and is not there, and what is; null where all is, or where no folder tells.
export function absentScenes({ mode, peers, realNames }) {
  const own = peersScenes(peers), names = SMALL[mode] ? SMALL_NAMES : own && [...own.map((s) => s.name), LAMPS, ...TABLE_NAMES, ...ROOM_NAMES, ...KITCHEN_NAMES, ...GLOSS_NAMES];
  return names && realNames?.some((name) => !names.includes(name)) ? { absent: realNames.filter((name) => !names.includes(name)), names } : null;
}

export async function real(o) {
  const all = realScenes(o), scenes = all?.filter((s) => !o.realNames || o.realNames.includes(s.name)), set = settings(o), rows = [];
  if (!scenes) return o.say(`real: skipped, there is no peers folder at ${o.peers}: say peers=DIR or SHEARWATER_PEERS`);
  mkdirSync(set.folder, { recursive: true });
  const tools = programs(o.build, set.folder), put = (...args) => { const line = o.put(...args); if (line.part === "real") rows.push(line); };
  if (!o.weights && !SMALL[o.mode]) o.say("real: there are no weights of the denoiser (make peer-weights), so that its pictures are those of an older build's paths");
  await withFarm(o, {}, async (farm) => {
    set.denoiser_s = o.weights ? await denoiserSeconds(farm, all, jobOf) : null;
    for (const scene of scenes) await measureScene(farm, tools, { ...o, put }, set, scene);
  });
  for (const e of equalCpu(rows)) console.error(equalSentence(e));
  // Bounds are about the scenes of the peers folder.
  if (!SMALL[o.mode]) judge(o, rows);
}
