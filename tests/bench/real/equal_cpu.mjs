// The filters beside paths with a denoiser that take as much CPU time: by interpolation in log-log over samples.
import { along } from "../accuracy/factors.mjs";

// Root mean square error as a screen shows it, in which psnr_db is a logarithm.
export const shownError = (r) => r.psnr_db === null ? NaN : 10 ** (-r.psnr_db / 20);
const decibels = (error) => -20 * Math.log10(error);

// rows: lines of the part. [{scene, spp, seconds, denoiser_s, oidn, auto, outside}]; spp is the denoiser's, oidn and
// auto are {psnr_db, flip}, auto with the samples that it has in that time; outside: beyond what was measured.
export function equalCpu(rows) {
  const found = [];
  for (const r of rows.filter((row) => row.method === "oidn" && row.picture_s && row.psnr_db !== null)) {
    const own = rows.filter((o) => o.scene === r.scene && o.method === "auto" && o.psnr_db !== null).sort((a, b) => a.spp - b.spp);
    const at = (of) => along(own.map((o) => [o.picture_s, of(o)]), r.picture_s), error = at(shownError);
    if (error) found.push({ scene: r.scene, spp: r.spp, seconds: r.picture_s, denoiser_s: r.denoiser_s, oidn: { psnr_db: r.psnr_db, flip: r.flip },
      auto: { spp: at((o) => o.spp).y, psnr_db: decibels(error.y), flip: at((o) => o.flip).y }, outside: error.outside });
  }
  return found;
}

// A line for people.
export const equalSentence = (e) => `${`${e.scene}: in ${e.seconds.toPrecision(3)} CPU s`.padEnd(36)} OIDN of ${e.spp} paths ${e.oidn.psnr_db.toFixed(2)} dB, FLIP ${e.oidn.flip.toFixed(4)}; ` +
  `auto of ${e.auto.spp.toPrecision(3)} ${e.auto.psnr_db.toFixed(2)} dB, FLIP ${e.auto.flip.toFixed(4)}${e.outside ? " (extrapolated)" : ""}`;
