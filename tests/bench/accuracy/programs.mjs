// The programs that the bench runs: renders of a job, comparisons of two pictures, means, pieces.
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { basename, dirname } from "node:path";

const PICTURE = "beauty";

export class Refused extends Error {}

export function programs(build, folder) {
  const run = (name, args, more = {}) => {
    const result = spawnSync(`${build}/${name}`, args, { encoding: "utf8", maxBuffer: 1 << 24, env: { ...process.env, ...more } });
    if (result.status === 0) return result.stdout;
    const said = (result.stderr || String(result.error ?? "")).trim();
    throw new (/not in this version|unsupported|not supported|\/filter\//i.test(said) ? Refused : Error)(
      `${name} ${args.join(" ")}: ${said}`);
  };
  const compare = (reference, test, layer, ...more) =>
    JSON.parse(run("shearwater", ["compare", reference, test, "--layer", layer, ...more]));
  const figures = ({ rmse, relmse, bias, p999, finite, pixels }) => ({ rmse, relmse, bias, p999, finite, pixels });
  // All of the image's light over all of the reference's.
  const energy = (c) => c.mean_test.reduce((a, b) => a + b) / c.mean_reference.reduce((a, b) => a + b);

  // The mean over all pixels that are judged.
  const overMean = (d, effect) => {
    const mean = d.mean_reference.reduce((a, b) => a + b) / d.mean_reference.length, unit = effect.relative ? mean : 1;
    return { ...figures(d), pixels: d.pixels ?? d.width * d.height, rmse: d.rmse / unit, bias: d.bias / unit, p999: d.p999 / unit, ...(effect.relative ? { mean } : {}) };
  };

  const weighed = (reference, test, { layer, times, where }) =>
    JSON.parse(run("tests/bench/exr_difference", [reference, test, layer, times, where]));
  const judged = (reference, test, effect) => {
    if (!effect.times) return overMean(compare(reference, test, effect.layer, ...(effect.where ? ["--where", effect.where] : [])), effect);
    const d = weighed(reference, test, effect), unit = effect.relative ? d.mean : 1;
    return { ...figures(d), rmse: d.rmse / unit, bias: d.bias / unit, p999: d.p999 / unit, mean: d.mean };
  };

  return {
    // Returns the frame's statistics; the picture lies at `out`. isa: in place of the best that the machine has.
    render(job, out, isa = null) {
      const path = `${folder}/job.json`, statistics = `${folder}/statistics.json`;
      writeFileSync(path, JSON.stringify(job, null, 1));
      run("shearwater", ["render", path, "--quiet", "--stats", statistics, "-o", out], isa ? { SHEARWATER_ISA: isa } : {});
      return JSON.parse(readFileSync(statistics, "utf8"));
    },
    // The scene file as a blob at `out`.
    importScene: (file, out) =>
      run("shearwater-import", ["--root", dirname(file), "--in", basename(file), "--out", out]),
    // Light at pixel centres from strata x strata samples a light, and visibility.
    reference(blob, job, strata, seed, out) {
      const path = `${folder}/reference.json`;
      writeFileSync(path, JSON.stringify(job));
      run("tests/bench/exr_reference", [blob, path, String(strata), String(seed), out]);
    },
    // What Open Image Denoise's network makes of a picture with albedo and normal; its CPU seconds.
    denoise: (weights, picture, out) => JSON.parse(run("tests/bench/exr_unet", [weights, picture, out])).cpu_s,
    mean: (out, inputs) => run("tests/bench/exr_mean", [out, ...inputs]),
    // 1 in the layer visibility where the slopes of a job's lens samples are alike.
    away: (blob, jobPath, out) => run("tests/bench/exr_away", [blob, jobPath, out]),
    writeJob(job) {
      const path = `${folder}/lens.json`;
      writeFileSync(path, JSON.stringify(job));
      return path;
    },
    // How far two pictures are apart where the filters work: pixel centres, before albedo or weighed
    // by it, as `judged` has it.
    apart: (a, b, effect) => judged(a, b, effect).rmse,
    // How well a picture's error is known by two halves of a reference: its standard error as a part of it.
    doubt: (halves, test, { layer, times, where }) => JSON.parse(run("tests/bench/exr_doubt",
      [...halves, test, layer, ...(times ? [times] : []), ...(where ? [where] : [])])).doubt,
    picturesApart: (a, b) => compare(a, b, PICTURE).rmse,
    // Errors beside two independent references, free of their noise, and FLIP beside their mean. What that noise hides is null.
    besidePair(first, second, test) {
      const { psnr_db, rmse01, relmse999, flip, width, height } = JSON.parse(run("shearwater", ["compare", first, "--reference-pair", second, test, "--flip"]));
      return { psnr_db, rmse01, relmse999, flip: flip.mean, width, height };
    },
    same: (a, b, layer) => compare(a, b, layer).rmse === 0,
    // All figures of a picture.
    judge(reference, test, effect) {
      const beauty = compare(reference, test, PICTURE);
      const parts = Object.entries(effect.parts ?? {}).map(([name, where]) => [name, judged(reference, test, { ...effect, where })]);
      return { ...Object.fromEntries(parts), ...figures(compare(reference, test, effect.layer)), judged: judged(reference, test, effect),
        beauty: { ...figures(beauty), energy: energy(beauty) } };
    },
    piece(picture, layer, crop, zoom, scale, minus) {
      const out = `${folder}/piece.png`;
      run("tests/bench/exr_crop", [picture, layer, crop.join(","), String(zoom), String(scale), out,
        ...(minus ? [minus] : [])]);
      return readFileSync(out);
    },
  };
}
