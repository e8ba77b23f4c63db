// Converged pictures. Light at pixel centres comes from exr_reference, in two independent halves whose
// difference says how good their mean is; anti-aliased pictures are means over many seeds. They are
// kept under a digest of the scene, the job and the sources of the integrator.
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, readdirSync, readFileSync } from "node:fs";
import { beautyJob, referenceJob } from "./job.mjs";

// Strata per axis of each half, one after the other until they suffice.
const LEVELS = [64, 128, 256, 512];

function sourcesDigest() {
  const hash = createHash("sha256");
  const wanted = /\.[ch]$/, samples = /^(pattern|plan|samples|scene|half|octahedron)/;
  for (const folder of ["worker", "worker/scene", "worker/shade", "worker/trace", "proto"])
    for (const name of readdirSync(folder).sort())
      if (wanted.test(name) && (folder !== "proto" || samples.test(name)))
        hash.update(name).update(readFileSync(`${folder}/${name}`));
  return hash.update(readFileSync("tests/bench/exr_reference.c")).digest("hex");
}

function digestOf(scene, side, file) {
  return createHash("sha256").update(sourcesDigest()).update(readFileSync(file))
    .update(JSON.stringify([scene.camera, scene.lights, side])).digest("hex").slice(0, 16);
}

export class Reference {
  #tools;
  #scene;
  #side;
  #file;
  #level = -1;

  // file: the scene's; folder: where references are kept.
  constructor(tools, scene, side, file, folder) {
    [this.#tools, this.#scene, this.#side, this.#file] = [tools, scene, side, file];
    this.folder = `${folder}/${scene.name}-${side}-${digestOf(scene, side, file)}`;
    mkdirSync(this.folder, { recursive: true });
  }

  #once(name, make) {
    const path = `${this.folder}/${name}`;
    if (!existsSync(path)) make(path);
    return path;
  }

  // Means over every second of the seeds, from the first and from the second.
  makePictures(seeds) {
    const one = (seed) => this.#once(`beauty-${seed}.exr`, (path) =>
      this.#tools.render(beautyJob(this.#scene, this.#side, this.#file, seed), path));
    const half = (odd) => this.#once(`beauty-${odd ? "odd" : "even"}-${seeds}.exr`, (path) =>
      this.#tools.mean(path, Array.from({ length: seeds }, (_, i) => 201 + i).filter((s) => s % 2 === odd).map(one)));
    this.pictures = [half(1), half(0)];
    this.picturesDifference = this.#tools.picturesApart(...this.pictures);
  }

  // The next better one; false when it would take more than `most` samples a light.
  improve(most) {
    const strata = LEVELS[this.#level + 1];
    if (!strata || strata * strata > most) return false;
    this.#level++;
    const blob = this.#once("scene.blob", (path) => this.#tools.importScene(this.#file, path));
    const half = (seed) => this.#once(`half-${strata}-${seed}.exr`, (path) =>
      this.#tools.reference(blob, referenceJob(this.#scene, this.#side), strata, seed, path));
    const halves = [half(1), half(2)];
    this.path = `${this.folder}/reference.exr`;
    this.#tools.mean(this.path, [...halves, ...this.pictures]);
    this.spp = 2 * strata * strata;
    this.difference = this.#tools.apart(...halves);
    return true;
  }

  // `smallest`: the least error that is judged by it.
  said(smallest) {
    return { spp: this.spp, halves_rmse: this.difference, good: this.difference <= 0.1 * smallest,
      beauty_halves_rmse: this.picturesDifference };
  }
}
