// Whether a sequence keeps its tracing threads as busy as a lone frame does while it is traced: samples for each second of
// a tracing thread, over all of the sequence from its submission to its last file, beside the same of single frames from
// the first tile to the last. Other work on the machine slows both alike: a thread's seconds do not count in which it
// could run and had no core (schedstat tells them), and those in which it had nothing to do count by the share of the time
// in which the coordinator, which it waits for, had one.
//
//   node tests/load/sequence_rate.mjs BUILD_DIR [frames=48] [width=640] [spp=9] [scene=object] [temporal=auto]
//     [threads=1] [least=0.95]
//
// scene: one of tests/bench/scenes/moving.mjs. Exit status 1 when the ratio is below `least`. The line of the sequence
// says where the other seconds went, as shares of all: build (trees and scenes), other work of the threads, none. With few
// samples filters take as much CPU time as tracing (coordinator_over_traced), and need as many cores.
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { moving, movingBox, movingJob } from "../bench/scenes/moving.mjs";
import { ownServer } from "./own_server.mjs";

const [build = "", ...words] = process.argv.slice(2);
const option = { frames: 48, width: 640, spp: 9, scene: "object", temporal: "auto", threads: 1, least: 0.95 };
for (const word of words) {
    const [name, value] = word.split("=");
    if (!(name in option) || !value) usage(`"${word}" is not understood`);
    option[name] = typeof option[name] === "number" ? Number(value) : value;
}
const scene = [...moving, ...movingBox].find(({ name }) => name === option.scene);
if (!build || !scene) usage(build ? `there is no scene "${option.scene}"` : "the build directory is missing");

function usage(fault) {
    console.error(`sequence_rate: ${fault}; use: node tests/load/sequence_rate.mjs BUILD_DIR [frames=N] [width=PX] [spp=N] [scene=NAME] [temporal=WORD] [threads=N] [least=RATIO]`);
    process.exit(2);
}

// The same paths as frames of a sequence have: by itself auto would give a frame light fields.
const ALONE = { method: "none", residual: "halves", temporal: "none" };

const { url, server, folder } = await ownServer(build, "sequence-rate", option.threads);
const get = async (path) => (await fetch(`${url}${path}`)).json();

async function workerPid() {
    for (;;) {
        const { workers } = await get("/v1/workers");
        if (workers.length === 1) return workers[0].pid;
        await sleep(50);
    }
}

// Seconds that a process's threads have run, and waited for a core: of those that ran most, which are the tracing threads.
function threadTimes(pid, threads = Infinity) {
    return readdirSync(`/proc/${pid}/task`)
        .map((thread) => readFileSync(`/proc/${pid}/task/${thread}/schedstat`, "utf8").split(" ").slice(0, 2).map((ns) => ns * 1e-9))
        .sort((a, b) => b[0] - a[0]).slice(0, threads)
        .reduce((sum, [ran, waited]) => ({ ran: sum.ran + ran, waited: sum.waited + waited }), { ran: 0, waited: 0 });
}

// Renders frames; tells what their threads did from the submission to the end.
async function render(pid, file, first, last) {
    const job = join(folder, "job.json"), before = threadTimes(pid, option.threads), away = threadTimes(server.pid), from = performance.now();
    writeFileSync(job, JSON.stringify(movingJob(file, last, option.width, option.spp, { ...scene.job, frames: { first, last }, filter: first < last ? { temporal: option.temporal } : ALONE, layers: ["beauty"] })));
    const id = execFileSync(join(build, "shearwater"), ["submit", job, "--server", url, "--quiet"]).toString().trim();
    for (;;) {
        const { state, error, statistics } = await get(`/v1/jobs/${id}`);
        if (error) throw new Error(`the job failed: ${JSON.stringify(error)}`);
        if (state === "finished") {
            const after = threadTimes(pid, option.threads), back = threadTimes(server.pid), wall = (performance.now() - from) / 1000;
            await fetch(`${url}/v1/jobs/${id}?purge=true`, { method: "DELETE" });
            const ran = after.ran - before.ran, idle = option.threads * wall - ran - (after.waited - before.waited);
            const served = (back.ran - away.ran) / (back.ran - away.ran + back.waited - away.waited);
            const seconds = ran + idle * served;
            const traced = statistics.cpu_s.trace + statistics.cpu_s.pack;
            const { import: imported, build: _, trace, pack, ...rest } = statistics.cpu_s, { total, ...coordinator } = rest;
            const filters = Object.values(coordinator).reduce((sum, s) => sum + s, 0);
            return { samples: statistics.rays.paths, wall, imported, filters, seconds, traced, built: statistics.cpu_s.build, ran, idle, served };
        }
        await sleep(20);
    }
}

const file = join(folder, "moving.glb");
writeFileSync(file, scene.glb());
const pid = await workerPid(), round = (x) => Number(x.toFixed(3));
await render(pid, file, 1, 1); // it warms up: the importer is in memory, the worker has its scene
const singles = [];
for (const at of [0, 0.5, 1]) singles.push(await render(pid, file, 1 + Math.round(at * (option.frames - 1)), 1 + Math.round(at * (option.frames - 1))));
const all = (of) => singles.reduce((sum, one) => sum + one[of], 0);
// Of a lone frame only the seconds in which it was traced count.
const single = all("samples") / all("traced");
const s = await render(pid, file, 1, option.frames), sequence = s.samples / s.seconds;
console.log(JSON.stringify({ part: "single", frames: singles.length, samples: all("samples"), traced_s: round(all("traced")), samples_a_thread_second: Math.round(single) }));
console.log(JSON.stringify({ part: "sequence", frames: option.frames, samples: s.samples, wall_s: round(s.wall), thread_s: round(s.seconds), traced: round(s.traced / s.seconds), built: round(s.built / s.seconds),
    other: round((s.ran - s.traced - s.built) / s.seconds), none: round(s.idle * s.served / s.seconds), idle_s: round(s.idle), coordinator_served: round(s.served), coordinator_over_traced: round(s.filters / s.traced), import_over_traced: round(s.imported / s.traced), samples_a_thread_second: Math.round(sequence) }));
const ratio = sequence / single;
console.log(`a sequence of ${option.frames} frames takes ${ratio.toFixed(3)} times as many samples a second as single frames while they are traced; bound ${option.least}`);
server.kill("SIGTERM");
await new Promise((done) => server.on("exit", done));
process.exit(ratio >= option.least ? 0 : 1);
