// What the coordinator's bookkeeping costs a tile: workers that answer at once with packed samples of nothing, tiles
// of 16x16, one sample a pixel, so that hardly anything is spent on pixels. What is counted is the CPU time of all of
// the coordinator's threads from the first tile to the last (leases, frames and checksums, unpacking, the film, events,
// files), and the same of the workers, which are at the other end of the same talk: the ratio of the two depends
// neither on the machine nor on what else it does, as far as that slows both.
//
//   node tests/load/tile_rate.mjs BUILD_DIR [side=2048] [tile=16] [runs=5] [most=6] [workers=2]
//
// Exit status 1 when in none of the runs a tile costs the coordinator at most `most` times what it costs the workers.
// Only the least ratio is judged, since what else the machine does adds to the coordinator's threads alone: they are
// woken more often then.
// With side=8192 tile=64 it tells what a tile's pixels cost besides: they are copied, shown and encoded.
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";

const THREADS = 32;
const [build = "", ...words] = process.argv.slice(2);
const option = { side: 2048, tile: 16, runs: 5, most: 6, workers: 2 };
for (const word of words) {
    const [name, value] = word.split("=");
    if (!(name in option) || !(Number(value) > 0)) usage(`"${word}" is not understood`);
    option[name] = Number(value);
}
if (!build) usage("the build directory is missing");

function usage(fault) {
    console.error(`tile_rate: ${fault}; use: node tests/load/tile_rate.mjs BUILD_DIR [side=PX] [tile=PX] [runs=N] [most=RATIO] [workers=N]`);
    process.exit(2);
}

const folder = mkdtempSync(join(tmpdir(), "tile-rate-"));
const children = new Set();
function start(program, ...args) {
    const child = spawn(join(build, program), args, { stdio: ["ignore", "pipe", "inherit"] });
    children.add(child);
    child.on("exit", () => children.delete(child));
    return child;
}
process.on("exit", () => {
    for (const child of children) child.kill("SIGKILL");
    rmSync(folder, { recursive: true, force: true });
});

// CPU time in nanoseconds of a process's threads so far. The thread that has the process's number is the loop.
function cpuTimes(pid) {
    const times = new Map();
    for (const thread of readdirSync(`/proc/${pid}/task`))
        times.set(Number(thread), Number(readFileSync(`/proc/${pid}/task/${thread}/schedstat`, "utf8").split(" ")[0]));
    return times;
}
function cpuTime(pids) {
    return pids.flatMap((pid) => [...cpuTimes(pid).values()]).reduce((sum, time) => sum + time, 0);
}

async function serve() {
    const server = start("shearwater", "serve", "--listen", "127.0.0.1:0", "--data", join(folder, "data"), "--workers", "0");
    let said = "";
    const url = await new Promise((done, failed) => {
        server.stdout.on("data", (text) => { said += text; const found = /listening on (\S+)/.exec(said); if (found) done(found[1]); });
        server.on("exit", (status) => failed(new Error(`the coordinator ended with status ${status}`)));
    });
    const threads = String(Math.max(1, Math.floor(THREADS / option.workers)));
    const workers = [];
    for (let i = 0; i < option.workers; i++) {
        const worker = start("tests/fake/fake_worker", "--connect", `unix:${join(folder, "data", "worker.sock")}`, "--script", "echo", "--threads", threads, "--seconds", "3600");
        worker.stdout.resume();
        workers.push(worker.pid);
    }
    return { url, pid: server.pid, workers };
}

// One frame: tiles, wall and CPU time in ns between two looks at its progress, the first after the first tile.
async function frame({ url, pid, workers }, seed) {
    const job = { scene: { file: resolve("tests/scenes/cornell-box/cornell-box.glb") }, image: { width: option.side, height: option.side },
                  sampling: { spp: 1, tile_px: option.tile, seed }, filter: { method: "none" }, layers: ["beauty"] };
    const file = join(folder, "job.json");
    writeFileSync(file, JSON.stringify(job));
    const id = execFileSync(join(build, "shearwater"), ["submit", file, "--server", url, "--quiet"]).toString().trim();
    let first = null;
    for (;;) {
        const { state, progress, error } = await (await fetch(`${url}/v1/jobs/${id}`)).json();
        if (error) throw new Error(`the job failed: ${JSON.stringify(error)}`);
        const now = { tiles: progress.tiles_done, wall: performance.now() * 1e6, coordinator: cpuTime([pid]), loop: cpuTimes(pid).get(pid), workers: cpuTime(workers) };
        if (!first && now.tiles > 0) first = now;
        if (first && now.tiles >= progress.tiles_total) {
            await end(url, id, state);
            return Object.fromEntries(Object.keys(now).map((key) => [key, now[key] - first[key]]));
        }
        await sleep(20);
    }
}

// The picture is written, too, before the next frame is asked for; its time is not bookkeeping.
async function end(url, id, state) {
    while (state !== "finished") {
        await sleep(50);
        ({ state } = await (await fetch(`${url}/v1/jobs/${id}`)).json());
    }
    await fetch(`${url}/v1/jobs/${id}?purge=true`, { method: "DELETE" });
}

const service = await serve();
const ratios = [];
for (let run = 1; run <= option.runs; run++) {
    const { tiles, ...times } = await frame(service, run);
    const ratio = times.coordinator / times.workers, us = (time) => Number((time / tiles / 1000).toFixed(1));
    ratios.push(ratio);
    console.log(JSON.stringify({ run, workers: option.workers, side_px: option.side, tile_px: option.tile, tiles, wall_us: us(times.wall), coordinator_us: us(times.coordinator), loop_us: us(times.loop),
                                 workers_us: us(times.workers), ratio: Number(ratio.toFixed(2)), tiles_per_cpu_s: Math.round(tiles / times.coordinator * 1e9) }));
}
const least = Math.min(...ratios);
console.log(`a tile costs the coordinator ${least.toFixed(2)} times what it costs the workers, least of ${option.runs} runs; bound ${option.most}`);
process.exit(least <= option.most ? 0 : 1);
