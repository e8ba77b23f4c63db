// The programs that the bench runs: renders of a job, comparisons of two pictures, means, pieces.
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { basename, dirname } from "node:path";

const LAYERS = { judged: "diffuse_direct", picture: "beauty" };
const PENUMBRA = "visibility,0.02,0.98";

export class Refused extends Error {}

export function programs(build, folder) {
  const run = (name, args) => {
    const result = spawnSync(`${build}/${name}`, args, { encoding: "utf8", maxBuffer: 1 << 24 });
    if (result.status === 0) return result.stdout;
    const said = (result.stderr || String(result.error ?? "")).trim();
    throw new (/not in this version|unsupported|not supported|\/filter\/method/i.test(said) ? Refused : Error)(
      `${name} ${args.join(" ")}: ${said}`);
  };
  const compare = (reference, test, layer, ...more) =>
    JSON.parse(run("shearwater", ["compare", reference, test, "--layer", layer, ...more]));
  const figures = ({ rmse, relmse, bias, p999, finite, pixels }) => ({ rmse, relmse, bias, p999, finite, pixels });

  return {
    // Returns the frame's statistics; the picture lies at `out`.
    render(job, out, workers = 2) {
      const path = `${folder}/job.json`, statistics = `${folder}/statistics.json`;
      writeFileSync(path, JSON.stringify(job, null, 1));
      run("shearwater", ["render", path, "--quiet", "--workers", String(workers), "--stats", statistics, "-o", out]);
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
    mean: (out, inputs) => run("tests/bench/exr_mean", [out, ...inputs]),
    // How far two pictures are apart where the filters work: pixel centres, before albedo.
    apart: (a, b) => compare(a, b, LAYERS.judged, "--where", PENUMBRA).rmse,
    picturesApart: (a, b) => compare(a, b, LAYERS.picture).rmse,
    // All figures of a picture.
    judge: (reference, test) => ({
      ...figures(compare(reference, test, LAYERS.judged)),
      penumbra: figures(compare(reference, test, LAYERS.judged, "--where", PENUMBRA)),
      beauty: figures(compare(reference, test, LAYERS.picture)) }),
    piece(picture, crop, zoom, scale, minus) {
      const out = `${folder}/piece.png`;
      run("tests/bench/exr_crop", [picture, LAYERS.judged, crop.join(","), String(zoom), String(scale), out,
        ...(minus ? [minus] : [])]);
      return readFileSync(out);
    },
  };
}
