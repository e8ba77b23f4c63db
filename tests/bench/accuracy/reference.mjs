// Converged pictures, in two independent halves whose difference says how good their mean is. Direct
// light at pixel centres comes from exr_reference; indirect light there from many bounce rays without a
// filter; anti-aliased pictures are means over many seeds, where indirect light is judged by the path
// tracer. They are kept under a digest of the scene and the job, with a small probe that tells whether a
// build still gives the same.
import { createHash } from "node:crypto";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { effectOf } from "./effects.mjs";
import { beautyJob, indirectJob, lensJob, pathsJob, referenceJob } from "./job.mjs";

// Strata per axis of each half, one after the other until they suffice.
const LEVELS = [64, 128, 256, 512];
// Bounce rays of one seed, and how many seeds are in each half. Rays of a pixel share one jitter, and so
// does, but for a fixed step, the whole picture: only halves of many seeds are independent.
const BOUNCE_RAYS = 64, SEEDS = [8, 16, 32, 64, 128];
const PATHS = 256;
// Seeds in each half of a picture through a lens.
const LENS_SEEDS = [2, 4, 8, 16, 32, 64, 128];

// The probe: the same scene, small and with few samples. While a build gives the same values for it, what
// builds before it rendered stands.
const PROBE = { side: 48, spp: 16, strata: 4, seed: 77 };

function digestOf(scene, o, file) {
  return createHash("sha256").update(readFileSync(file))
    .update(JSON.stringify([scene.camera, scene.lights, o.side, scene.bounces, scene.sides, scene.environment?.(""), ...(scene.lens ? [scene.lens] : [])]))
    .digest("hex").slice(0, 16);
}

const seeds = (first, count) => Array.from({ length: count }, (_, i) => first + i);

export class Reference {
  #tools;
  #scene;
  #o;
  #file;
  #effect;
  #level = -1;
  #halves;

  // file: the scene's; o: side, shared; folder: where references are kept.
  constructor(tools, scene, o, file, folder) {
    [this.#tools, this.#scene, this.#o, this.#file, this.#effect] = [tools, scene, o, file, effectOf(scene)];
    this.folder = `${folder}/${scene.name}-${o.side}-${digestOf(scene, o, file)}`;
    mkdirSync(this.folder, { recursive: true });
    this.#probe();
  }

  // What is kept here, and what this build gives for it; what other integrators left goes.
  #probe() {
    const o = { ...this.#o, side: PROBE.side }, { spp, strata, seed } = PROBE;
    const now = mkdtempSync(`${tmpdir()}/probe-`), blob = `${now}/scene.blob`, effect = this.#effect.name;
    const job = (make, ...more) => make(this.#scene, o, this.#file, seed, ...more);
    this.#tools.render(job(pathsJob, spp), `${now}/probe-paths.exr`);
    if (effect === "indirect") this.#tools.render(job(indirectJob, spp), `${now}/probe-indirect.exr`);
    if (effect === "shadows") {
      this.#tools.importScene(this.#file, blob);
      this.#tools.render(job(beautyJob), `${now}/probe-beauty.exr`);
      this.#tools.reference(blob, referenceJob(this.#scene, o), strata, seed, `${now}/probe-half.exr`);
    }
    if (effect === "lens") {
      this.#tools.importScene(this.#file, blob);
      this.#tools.away(blob, this.#tools.writeJob(lensJob(this.#scene, o)), `${now}/probe-away.exr`);
    }
    const names = readdirSync(now).filter((name) => name.endsWith(".exr"));
    const layer = (name) => ({ "probe-indirect.exr": "diffuse_indirect", "probe-half.exr": "diffuse_direct", "probe-away.exr": "visibility" })[name] ?? "beauty";
    const stands = names.every((name) => existsSync(`${this.folder}/${name}`) &&
      this.#tools.same(`${this.folder}/${name}`, `${now}/${name}`, layer(name)));
    if (!stands) {
      rmSync(this.folder, { recursive: true });
      mkdirSync(this.folder);
      for (const name of names) copyFileSync(`${now}/${name}`, `${this.folder}/${name}`);
    }
    rmSync(now, { recursive: true });
  }

  #once(name, make) {
    const path = `${this.folder}/${name}`;
    if (!existsSync(path)) make(path);
    return path;
  }

  #render(name, job) {
    return this.#once(name, (path) => this.#tools.render(job, path));
  }

  #mean(name, inputs) {
    return this.#once(name, (path) => this.#tools.mean(path, inputs));
  }

  // Means over every second of the seeds, from the first and from the second.
  makePictures(count) {
    if (this.#scene.lens) return;
    const indirect = this.#effect.name === "indirect", what = indirect ? "paths" : "beauty";
    const one = (seed) => this.#render(`${what}-${seed}.exr`, indirect
      ? pathsJob(this.#scene, this.#o, this.#file, seed, PATHS) : beautyJob(this.#scene, this.#o, this.#file, seed));
    const half = (odd) => this.#mean(`${what}-${odd ? "odd" : "even"}-${count}.exr`,
      seeds(201, count).filter((s) => s % 2 === odd).map(one));
    this.pictures = [half(1), half(0)];
    this.picturesDifference = this.#tools.picturesApart(...this.pictures);
  }

  // Halves of direct light from strata x strata samples a light.
  #direct(most) {
    const strata = LEVELS[this.#level + 1];
    if (!strata || strata * strata > most) return null;
    const blob = this.#once("scene.blob", (path) => this.#tools.importScene(this.#file, path));
    this.spp = 2 * strata * strata;
    return [1, 2].map((seed) => this.#once(`half-${strata}-${seed}.exr`, (path) =>
      this.#tools.reference(blob, referenceJob(this.#scene, this.#o), strata, seed, path)));
  }

  // Halves of indirect light from some seeds' bounce rays.
  #indirect(most) {
    const count = SEEDS[this.#level + 1];
    if (!count || count * BOUNCE_RAYS > most) return null;
    const one = (seed) => this.#render(`indirect-${BOUNCE_RAYS}-${seed}.exr`,
      indirectJob(this.#scene, this.#o, this.#file, seed, BOUNCE_RAYS));
    this.spp = 2 * count * BOUNCE_RAYS;
    return [301, 501].map((first) => this.#mean(`half-${count * BOUNCE_RAYS}-${first}.exr`, seeds(first, count).map(one)));
  }

  // Halves of a picture through a lens, by the path tracer, and where its pixels are away from edges.
  #lens(most) {
    const count = LENS_SEEDS[this.#level + 1];
    if (!count || count * PATHS > most) return null;
    const blob = this.#once("scene.blob", (path) => this.#tools.importScene(this.#file, path));
    const away = this.#once("away.exr", (path) => this.#tools.away(blob, this.#tools.writeJob(lensJob(this.#scene, this.#o)), path));
    const one = (seed) => this.#render(`lens-${seed}.exr`, pathsJob(this.#scene, this.#o, this.#file, seed, PATHS));
    this.spp = 2 * count * PATHS;
    const halves = [301, 501].map((first) => this.#mean(`lens-${count * PATHS}-${first}.exr`, seeds(first, count).map(one)));
    this.pictures = [away];
    this.picturesDifference = this.#tools.picturesApart(...halves);
    return halves;
  }

  // The next better one; false when it would take more than `most` samples.
  improve(most) {
    const halves = this.#scene.lens ? this.#lens(most) : this.#effect.name === "indirect" ? this.#indirect(most) : this.#direct(most);
    if (!halves) return false;
    this.#level++;
    this.#halves = halves;
    this.path = `${this.folder}/reference.exr`;
    this.#tools.mean(this.path, [...halves, ...this.pictures]);
    this.differences = { judged: this.#tools.apart(...halves, this.#effect) };
    for (const [part, where] of Object.entries(this.#effect.parts ?? {})) {
      this.#tools.mean(`${this.folder}/marked.exr`, [halves[0], ...this.pictures]);
      this.differences[part] = this.#tools.apart(`${this.folder}/marked.exr`, halves[1], { ...this.#effect, where });
    }
    return true;
  }

  // `error` without what the reference itself adds to it, where that is allowed for: the mean of two
  // independent halves has a quarter of the variance of their difference.
  corrected(error, part = "judged") {
    if (!this.#effect.relative) return error;
    return Math.sqrt(Math.max(error * error - 0.25 * this.differences[part] ** 2, 0));
  }

  // How well the error of a picture is known: the standard error of `corrected` as a part of it. Null
  // where the reference's own share stays in it.
  doubt(picture) {
    return this.#effect.relative ? this.#tools.doubt(this.#halves, picture, this.#effect) : null;
  }

  // Of rows judged by it. A reference is good when the errors at the count that bounds speak of are
  // known to a tenth (two standard errors), or, where its own share stays in them, when its halves
  // differ by a tenth of the least.
  said(rows) {
    const smallest = Math.min(...rows.map((r) => r.judged.rmse));
    const quoted = rows.filter((r) => r.spp === this.#effect.at), doubt = Math.max(...(quoted.length > 0 ? quoted : rows).map((r) => r.judged.doubt));
    return { spp: this.spp, halves_rmse: this.differences.judged, doubt: this.#effect.relative ? doubt : null,
      good: this.#effect.relative ? doubt <= 0.05 : this.differences.judged <= 0.1 * smallest, beauty_halves_rmse: this.picturesDifference };
  }
}
