// How many tiles a second the coordinator's bookkeeping sustains: workers that answer at once with
// packed samples of nothing, a picture of 64x64 tiles, one sample a pixel. What is counted is the
// coordinator's CPU time from the first tile to the last (leases, frames and checksums, unpacking,
// the film, events), so that the figure is one core's whatever else the machine does.
//
//   node tests/load/tile_rate.mjs BUILD_DIR [side=8192] [runs=3] [least=5000] [workers=2]
//
// Exit status 1 when the median run's tiles per CPU second are fewer than `least`.
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";

const TILE_PX = 64, THREADS = 32, TICKS_PER_S = Number(execFileSync("getconf", ["CLK_TCK"]));
const [build = "", ...words] = process.argv.slice(2);
const option = { side: 8192, runs: 3, least: 5000, workers: 2 };
for (const word of words) {
    const [name, value] = word.split("=");
    if (!(name in option) || !(Number(value) > 0)) usage(`"${word}" is not understood`);
    option[name] = Number(value);
}
if (!build) usage("the build directory is missing");

function usage(fault) {
    console.error(`tile_rate: ${fault}; use: node tests/load/tile_rate.mjs BUILD_DIR [side=PX] [runs=N] [least=TILES_PER_S] [workers=N]`);
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

// User and system time of a process so far.
function cpuSeconds(pid) {
    const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
    return (Number(fields[11]) + Number(fields[12])) / TICKS_PER_S;
}

async function serve() {
    const server = start("shearwater", "serve", "--listen", "127.0.0.1:0", "--data", join(folder, "data"), "--workers", "0");
    let said = "";
    const url = await new Promise((done, failed) => {
        server.stdout.on("data", (text) => { said += text; const found = /listening on (\S+)/.exec(said); if (found) done(found[1]); });
        server.on("exit", (status) => failed(new Error(`the coordinator ended with status ${status}`)));
    });
    const threads = String(Math.max(1, Math.floor(THREADS / option.workers)));
    for (let i = 0; i < option.workers; i++)
        start("tests/fake/fake_worker", "--connect", `unix:${join(folder, "data", "worker.sock")}`, "--script", "echo", "--threads", threads, "--seconds", "3600").stdout.resume();
    return { url, pid: server.pid };
}

// One frame: {tiles, wall_s, cpu_s} between two looks at its progress, the first after the first tile.
async function frame({ url, pid }, seed) {
    const job = { scene: { file: resolve("tests/scenes/cornell-box/cornell-box.glb") }, image: { width: option.side, height: option.side },
                  sampling: { spp: 1, tile_px: TILE_PX, seed }, filter: { method: "none" }, layers: ["beauty"] };
    const file = join(folder, "job.json");
    writeFileSync(file, JSON.stringify(job));
    const id = execFileSync(join(build, "shearwater"), ["submit", file, "--server", url, "--quiet"]).toString().trim();
    let first = null;
    for (;;) {
        const { state, progress, error } = await (await fetch(`${url}/v1/jobs/${id}`)).json();
        if (error) throw new Error(`the job failed: ${JSON.stringify(error)}`);
        const now = { tiles: progress.tiles_done, wall_s: performance.now() / 1000, cpu_s: cpuSeconds(pid) };
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
const rates = [];
for (let run = 1; run <= option.runs; run++) {
    const { tiles, wall_s, cpu_s } = await frame(service, run), rate = tiles / cpu_s;
    rates.push(rate);
    console.log(JSON.stringify({ run, workers: option.workers, side_px: option.side, tile_px: TILE_PX, tiles, wall_s: Number(wall_s.toFixed(3)), coordinator_cpu_s: cpu_s,
                                 tiles_per_cpu_s: Math.round(rate), tiles_per_s: Math.round(tiles / wall_s) }));
}
const median = rates.sort((a, b) => a - b)[Math.floor(rates.length / 2)];
console.log(`${Math.round(median)} tiles per CPU second of the coordinator, median of ${option.runs}; bound ${option.least}`);
process.exit(median >= option.least ? 0 : 1);
