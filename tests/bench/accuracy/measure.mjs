// One scene: the pictures of every method and sample count, their cost, their errors.
import { mkdirSync, writeFileSync } from "node:fs";
import { hasIsa } from "../machine.mjs";
import { effectOf } from "./effects.mjs";
import { megapixels, testJob, turnedJob } from "./job.mjs";
import { Refused } from "./programs.mjs";
import { Reference } from "./reference.mjs";

export const SEED = 3;

const median = (values) => values.slice().sort((a, b) => a - b)[Math.floor((values.length - 1) / 2)];

// From samples to the picture, whoever does it: what the methods differ in.
const judgedSeconds = (cpu) => ["trace", "pack", "decode", "reconstruct", "shadow", "indirect", "glossy", "lens", "lens_relight"]
  .reduce((sum, stage) => sum + (cpu[stage] ?? 0), 0);

const least = (values) => Math.min(...values);

// CPU seconds are the least of the runs: whatever else the machine does only adds to them.
function cost(runs) {
  const cpu_s = {};
  for (const stage of Object.keys(runs[0].cpu_s)) cpu_s[stage] = least(runs.map((r) => r.cpu_s[stage]));
  cpu_s.judged = least(runs.map((r) => judgedSeconds(r.cpu_s)));
  return { cpu_s, wall_s: median(runs.map((r) => r.wall_s)), runs: runs.length,
    peak_rss_bytes: { server: Math.max(...runs.map((r) => r.peak_rss_bytes.server)),
      worker: Math.max(...runs.map((r) => r.peak_rss_bytes.worker)) },
    bytes_received: runs[0].bytes_received, rays: runs[0].rays, skipped: runs[0].skipped };
}

const isTurned = (scene, method) => effectOf(scene).turned?.includes(method);
// Bounce rays of a pixel that has any, on the average; the first set has 16.
const meanRays = ({ first_rays: first, second_rays: second }) => Math.round(160 * (first + second) / first) / 10;

// Whether the samples are those that the method is about.
function isCovered({ effect }, method, { rays: { paths, indirect, lens }, lens: { samples_lit: lit } }) {
  const through = method === "paths" ? lens === 0 && paths > 0 : lens > 0 && (method === "extra") === (paths > 0);
  return { indirect: indirect > 0, lens: through, combined: through && (method === "auto") === (lit > 0) }[effect] ?? paths === 0;
}

// What the method costs with the instruction set that a bound speaks of: {isa, cpu_s}; null where the machine has
// not got it, or nothing speaks of it. The least of `times` runs.
function costOfIsa(tools, scene, o, method, step, job, picture, times) {
  const { method: about, isa } = effectOf(scene).costs ?? {};
  if (about !== method || step !== o.repeatSpp[scene.effect] || !hasIsa(isa)) return null;
  o.say(`${scene.name}: ${method}, with ${isa}`);
  const runs = Array.from({ length: times }, () => tools.render(job, picture.replace(/\.exr$/, `-${isa}.exr`), isa));
  return { isa, cpu_s: cost(runs).cpu_s };
}

// step: the samples a pixel, or mu.
function renderTest(tools, scene, o, file, method, step) {
  const turned = isTurned(scene, method), picture = `${o.out}/pictures/${scene.name}-${method}-${step}.exr`, runs = [];
  const times = (turned ? step === 1 : o.repeatSpp[scene.effect] === step) ? o.repeat : 1;
  const job = (turned ? turnedJob : testJob)(scene, o, file, method, step, o.seed);
  for (let i = 0; i < times; i++) {
    runs.push(tools.render(job, picture));
    if (!isCovered(scene, method, runs[i])) throw new Error(`${scene.name}: light fields do not cover it`);
  }
  const spp = turned ? meanRays(runs[0].adaptive) : step;
  return { effect: scene.effect, scene: scene.name, method, spp, ...(turned ? { mu: step } : {}), seed: o.seed, side_px: o.side,
    megapixels: megapixels(scene, o.side), picture, ...cost(runs), with_isa: costOfIsa(tools, scene, o, method, step, job, picture, times) };
}

function renderAll(tools, scene, o, file) {
  const rows = [];
  for (const method of effectOf(scene).methods.filter((m) => o.methods.includes(m)))
    for (const step of isTurned(scene, method) ? o.mu : o.spp(scene.effect, method)) {
      o.say(`${scene.name}: ${method}, ${isTurned(scene, method) ? `mu ${step}` : `${step} spp`}`);
      try {
        rows.push(renderTest(tools, scene, o, file, method, step));
      } catch (error) {
        if (!(error instanceof Refused)) throw error;
        o.refused.set(`${scene.effect}, ${method}`, error.message.split(": ").slice(1).join(": "));
        break;
      }
    }
  return rows;
}

function judgeAll(tools, reference, rows, effect) {
  return rows.map((row) => {
    const found = tools.judge(reference.path, row.picture, effect);
    for (const part of ["judged", ...Object.keys(effect.parts ?? {})])
      found[part].rmse = reference.corrected(found[part].rmse, part);
    found.judged.doubt = reference.doubt(row.picture);
    return { ...row, ...found };
  });
}

// Rows as docs/accuracy.md names them, and the reference they were judged by. A scene whose file is not
// here (the shared ones may be absent) gives null.
export function measureScene(tools, scene, o) {
  mkdirSync(`${o.out}/pictures`, { recursive: true });
  const file = `${o.out}/${scene.name}.glb`;
  try {
    writeFileSync(file, scene.glb(o.shared));
  } catch (error) {
    if (error.code !== "ENOENT") throw error;
    o.say(`${scene.name}: left out, ${error.path} is absent`);
    return null;
  }
  const effect = effectOf(scene), reference = new Reference(tools, scene, o, file, o.references);
  const pictures = renderAll(tools, scene, o, file).filter((row) => !o.refused.has(`${row.effect}, ${row.method}`));
  if (pictures.length === 0) return null;
  o.say(`${scene.name}: reference`);
  reference.makePictures(o.beautySeeds[scene.effect]);
  reference.improve(Infinity);
  let rows = judgeAll(tools, reference, pictures, effect);
  while (!reference.said(rows).good && reference.improve(o.referenceSpp[scene.effect])) {
    o.say(`${scene.name}: better reference, ${reference.spp} samples`);
    rows = judgeAll(tools, reference, pictures, effect);
  }
  const said = reference.said(rows);
  return { rows: rows.map((row) => ({ ...row, reference: said })), reference };
}
