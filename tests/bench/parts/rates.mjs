// Rates and shares beside their bounds: the figures of tests/bench/run, one at a time.
import { spawnSync } from "node:child_process";

export const RATES = ["rays", "paths", "blockers", "share", "tile", "memory", "brute", "lens_brute", "v_plane", "lone", "wire", "glossy", "half_field", "target"];

export function rate(o, name) {
  o.say(name);
  const result = spawnSync("tests/bench/run", [o.build, name], { encoding: "utf8", maxBuffer: 1 << 26, stdio: ["ignore", "pipe", "inherit"] });
  if (result.status === null) throw new Error(`${name} ended with ${result.signal ?? result.error}`);
  result.stdout.split("\n").filter((l) => l.startsWith("{")).forEach((text, i) => {
    const line = JSON.parse(text);
    // Verdicts are figures; what they were found from is kept beside them.
    if (line.figure) o.put("figure", `${name} ${line.figure}`, { from: name, ...line });
    else o.put(name, `${i}`, line);
  });
  // 1 is said of bounds that were missed.
  if (result.status > 1 || !result.stdout.includes("{")) throw new Error(`${name} was not measured as a whole`);
}
