// How cost grows: with workers, with resolution, with triangles. One picture each, rendered by a real farm
// that has rendered it small before, so that neither import nor the BVH is in what is timed, but where
// they are what is asked about.
import { writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { Farm } from "../farm.mjs";
import { glbOf } from "../scenes/glb.mjs";
import { light } from "../scenes/light.mjs";
import { hills } from "../scenes/mesh.mjs";
import { repeated } from "./runs.mjs";

export const BOX = resolve("tests/scenes/cornell-box/cornell-box.glb"), SMALL = { width: 64, height: 64 };
const size = (height) => ({ width: Math.round(height * 16 / 9), height });

// What is rendered: light fields of shadows and of one bounce with their filters, paths alone, and all of
// it through a lens.
const KINDS = {
  fields: { about: "soft shadows and one bounce, filtered", job: {} },
  paths: { about: "the same light by paths, no filter", job: { filter: { method: "none" } } },
  lens: { about: "the same through a lens, filtered", job: { lens: { aperture_radius: 0.05, focus_distance: 6.5 } } } };

const jobOf = (kind, image) => ({ scene: { file: BOX }, image, sampling: { spp: 9, seed: 1 }, effects: { indirect_bounces: 1 }, layers: ["beauty"], ...KINDS[kind].job });

export async function withFarm(o, options, run) {
  const farm = await Farm.start(o.build, options);
  try {
    return await run(farm);
  } finally {
    await farm.stop();
  }
}

export async function workers(o) {
  for (const count of o.workers)
    await withFarm(o, { workers: count, threads: 1 }, async (farm) => {
      await farm.run(jobOf("fields", SMALL));
      o.say(`workers: ${count} of one thread`);
      o.put("workers", `fields ${o.workersHeight} ${count}`, { kind: "fields", about: KINDS.fields.about, height_px: o.workersHeight, workers: count,
        ...await repeated(farm, jobOf("fields", size(o.workersHeight)), o.repeat) });
    });
}

export async function resolution(o) {
  for (const kind of o.kinds)
    for (const height of o.heights)
      // Of its own for each: the peak of memory is one of a process's life.
      await withFarm(o, {}, async (farm) => {
        o.say(`resolution: ${kind}, ${height} lines`);
        await farm.run(jobOf(kind, SMALL));
        const image = size(height);
        o.put("resolution", `${kind} ${height}`, { kind, about: KINDS[kind].about, ...image, megapixels: image.width * image.height / 1e6,
          ...await repeated(farm, jobOf(kind, image), o.repeat) });
      });
}

const height = (x, z) => 0.45 * Math.sin(1.1 * x + 0.4) * Math.cos(0.9 * z) + 0.15 * Math.sin(2.3 * z + x);

// Import and BVH count here, and happen once a coordinator and worker: each run has a farm of its own. Workers of one
// thread, a worker a core, are measured in turn with one of as many threads, which is what is started by default.
export async function triangles(o) {
  for (const steps of o.hillSteps) {
    const count = 2 * steps * steps, file = `${o.out}/hills-${steps}.glb`, runs = [], apart = [];
    o.say(`triangles: ${count}`);
    writeFileSync(file, glbOf([{ name: "hills", color: [0.6, 0.6, 0.6], mesh: hills(6, steps, height) }]));
    const job = { scene: { file, camera: { eye: [0, 5, 9], target: [0, 0, 0], yfov_deg: 42 } }, image: { width: o.hillSide, height: o.hillSide },
      lights: [light({ center: [1.5, 7, 1.5], target: [0, 0, 0], halfU: 0.8 })], sampling: { spp: 9, seed: 1 },
      effects: { indirect_bounces: 1 }, layers: ["beauty"] };
    for (let i = 0; i < o.repeat; i++)
      for (const [to, options] of [[runs, {}], [apart, { workers: o.cores, threads: 1 }]])
        await withFarm(o, options, async (farm) => { to.push(await farm.run(job)); });
    const { cpu_s, wall, peak_rss_bytes } = o.summary(apart);
    o.put("triangles", `${count}`, { triangles: count, side_px: o.hillSide, ...o.summary(runs), apart: { workers: o.cores, cpu_s, wall, peak_rss_bytes } });
  }
}
