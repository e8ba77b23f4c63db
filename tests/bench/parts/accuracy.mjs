// Errors of pictures beside converged ones: runs accuracy.mjs scene by scene, so that what is measured is
// kept when a long run is cut short.
import { spawnSync } from "node:child_process";

export const accuracyKey = (r) => `${r.effect} ${r.scene} ${r.method} ${r.mu ? `mu ${r.mu}` : `${r.spp} spp`} ${r.side_px} px seed ${r.seed}`;

export function accuracy(o) {
  for (const scene of o.scenes) {
    const result = spawnSync(process.execPath, ["tests/bench/accuracy.mjs", o.build, ...o.accuracy, `scene=${scene}`, `out=${o.out}/accuracy`],
      { encoding: "utf8", maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "inherit"] });
    // 1: bounds are missed, which the report says, too.
    if (result.status > 1 || result.status === null) throw new Error(`accuracy of ${scene} ended with ${result.status ?? result.signal ?? result.error}`);
    for (const line of result.stdout.split("\n").filter(Boolean)) {
      const row = JSON.parse(line);
      if (row.judged) o.put("accuracy", accuracyKey(row), row);
    }
  }
}
