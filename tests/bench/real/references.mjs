// Two independent references of a scene, by paths alone. They are kept under a digest of its job and files, with a
// small probe that tells whether a build still gives the same.
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, readFileSync, rmSync } from "node:fs";

const SEEDS = { a: 1001, b: 2002 }, PROBE = { width: 48, spp: 16, seed: 77 };

const paths = (job, spp, seed, image = job.image) => ({ ...job, image, sampling: { spp, seed }, filter: { method: "none" } });

function digestOf(job, spp) {
  const hash = createHash("sha256"), files = [job.scene.file, job.environment?.file].filter(Boolean);
  for (const file of files) hash.update(readFileSync(file));
  // Not where files lie.
  return hash.update(JSON.stringify([job, spp], (name, value) => name === "file" ? "" : value)).digest("hex").slice(0, 16);
}

// Drops what builds of another light have left.
async function probe(farm, tools, job, folder) {
  const { width, spp, seed } = PROBE, kept = `${folder}/probe.exr`, now = `${folder}/probe-now.exr`;
  const image = { width, height: Math.max(1, Math.round(width * job.image.height / job.image.width)) };
  await farm.run(paths(job, spp, seed, image), now);
  if (existsSync(kept) && tools.same(kept, now, "beauty")) return;
  rmSync(folder, { recursive: true });
  mkdirSync(folder);
  await farm.run(paths(job, spp, seed, image), kept);
}

// Their files. folder: where references are kept; spp: of each of the two.
export async function makeReferences(farm, tools, { name, job }, { folder, spp, say }) {
  const own = `${folder}/${name}-${job.image.width}-${digestOf(job, spp)}`, files = Object.keys(SEEDS).map((half) => `${own}/${half}.exr`);
  mkdirSync(own, { recursive: true });
  await probe(farm, tools, job, own);
  for (const [i, seed] of Object.values(SEEDS).entries()) {
    if (existsSync(files[i])) continue;
    say(`${name}: reference ${i + 1} of 2, ${spp} paths a pixel`);
    await farm.run(paths(job, spp, seed), files[i]);
  }
  return files;
}
