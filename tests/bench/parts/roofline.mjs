// The filters' kernels beside what one core can do: bench_roofline's lines, and how many of the kernels come
// within twice their roof.
import { spawnSync } from "node:child_process";

const WITHIN = 2;

export function roofline(o) {
  o.say("roofline");
  const result = spawnSync(`${o.build}/tests/bench/bench_roofline`, { encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
  if (result.status !== 0) throw new Error(`bench_roofline ended with ${result.signal ?? result.status ?? result.error}`);
  const [{ machine, ...limits }, ...kernels] = result.stdout.trim().split("\n").map((text) => JSON.parse(text));
  o.put("roofline", machine, { machine_limits: limits });
  for (const line of kernels) o.put("roofline", line.kernel, line);
  const near = kernels.filter((l) => l.over_roof <= WITHIN).length;
  o.put("figure", "roofline", { from: "roofline", figure: `kernels within ${WITHIN} times their roof, of ${kernels.length}`, value: near, bound: `>= ${kernels.length}`, unit: "kernels", ok: near === kernels.length });
}
