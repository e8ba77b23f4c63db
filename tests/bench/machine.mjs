// What the bench runs on. Its digest stands in every line: figures of two machines are never joined.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { availableParallelism, cpus, loadavg, release, totalmem } from "node:os";

const FLAGS = [["avx512f", "AVX-512"], ["avx2", "AVX2"], ["sse4_2", "SSE4.2"]];
const cpuFlags = () => readFileSync("/proc/cpuinfo", "utf8").match(/^flags\s*:(.*)$/m)?.[1].split(" ") ?? [];

// Whether the machine has an instruction set, as SHEARWATER_ISA names it.
export const hasIsa = (isa) => cpuFlags().includes({ avx512: "avx512f", avx2: "avx2", "sse4.2": "sse4_2" }[isa]);

export function machineOf() {
  const flags = cpuFlags();
  const what = { cpu: cpus()[0]?.model.trim() ?? "unknown", cores: availableParallelism(),
    instructions: FLAGS.find(([flag]) => flags.includes(flag))?.[1] ?? "unknown", memory_bytes: totalmem(), kernel: release() };
  return { id: createHash("sha256").update(JSON.stringify(what)).digest("hex").slice(0, 8), ...what };
}

// How much other work there is: processes that wanted a core in the last minute, over the cores.
export const loadOf = () => loadavg()[0] / availableParallelism();
