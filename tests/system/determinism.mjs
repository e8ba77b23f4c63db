// The determinism matrix: see determinism.sh. TAP.
//
// Every row is a real job of a real coordinator with workers that come up for it, whose EXR must be
// that of its job's reference: one worker, one thread, tiles of 32, nothing disturbed. Orders of
// completion are scripted:
//   plain    as the schedule has it
//   steered  the point (or region) that goes first changes every few milliseconds
//   stopped  workers are stopped and continued (SIGSTOP, SIGCONT) one after the other
//   killed   a worker that holds tiles is killed: they are leased again, to others
import { execFileSync, spawn } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdtempSync, openSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";

const [build, size] = process.argv.slice(2), all = size === "all";
const scene = resolve("tests/scenes/cornell-box/cornell-box.glb");
const temporary = mkdtempSync(join(tmpdir(), "determinism-"));
const children = new Set();
const slower = Number(process.env.TEST_SLOWER ?? 1); // of builds with sanitizers (tests/run)
let tests = 0, failures = 0;

// ---- what is varied ----

const WIDTH = 104, HEIGHT = 96;
const base = { image: { width: WIDTH, height: HEIGHT }, sampling: { spp: 9, seed: 7 }, effects: { indirect_bounces: 1 } };
const lens = { aperture_radius: 0.1, focus_distance: 3 }, environment = { radiance: [0.2, 0.3, 0.4] };
const jobs = {
    paths: { integrator: "paths", document: { ...base, filter: { method: "none" }, sampling: { spp: 40, seed: 7 }, effects: { indirect_bounces: 4 }, lens, layers: ["beauty", "CryptoObject", "CryptoMaterial"] } },
    light_field: { integrator: "light_field", document: { ...base, layers: ["beauty", "direct", "indirect", "visibility", "filter_width", "error", "CryptoObject"] } },
    divided_lights: { integrator: "paths_and_light_field", document: { ...base, environment, layers: ["beauty", "diffuse_direct", "diffuse_indirect", "error"] } },
    // More samples than light is divided for.
    filtered_paths: { integrator: "paths", document: { ...base, environment, sampling: { spp: 49, seed: 7 }, layers: ["beauty", "diffuse_direct", "diffuse_indirect", "error"] } },
    paths_and_light_field: { integrator: "paths_and_light_field", document: { ...base, environment, filter: { indirect: "constant" }, layers: ["beauty", "direct", "indirect", "diffuse_indirect", "error"] } },
    lens_field: { integrator: "lens_field", document: { ...base, lens, layers: ["beauty", "CryptoMaterial"] } },
    // Tiles differ in samples under a target: each size has a picture of its own.
    target_error: { rounds: true, by_tile: true, document: { ...base, environment, sampling: { spp: 9, seed: 7, target_error: 0.06 }, layers: ["beauty", "error", "samples"] } },
    lens_extra: { integrator: "lens_field", rounds: true, document: { ...base, lens, sampling: { spp: 9, seed: 7, lens_extra: 4 }, layers: ["beauty", "samples"] } },
    half_field: { integrator: "light_field", document: { ...base, sampling: { spp: 9, indirect_spp: 36, field_scale: 0.5, seed: 7 }, layers: ["beauty", "diffuse_indirect", "error", "samples"] } },
    adaptive: { rounds: true, document: { ...base, filter: { indirect: "adaptive" }, layers: ["beauty", "samples"] } },
};
const axes = {
    job: Object.keys(jobs),
    workers: [1, 2, 3],
    threads: [1, 2],
    tile: [8, 24, 64],
    order: ["plain", "steered", "stopped", "killed"],
    block: [0, 32, 96], // px; 0: as the plan has it
};
const names = Object.keys(axes);

// xorshift32: rows and disturbances are the same every time.
const random = (seed) => {
    let x = seed >>> 0 || 1;
    return (n) => { x ^= x << 13; x ^= x >>> 17; x ^= x << 5; x >>>= 0; return x % n; };
};

const pairs = (row) => {
    const out = [];
    for (let i = 0; i < names.length; i++)
        for (let j = i + 1; j < names.length; j++) out.push(`${i}${row[names[i]]}/${j}${row[names[j]]}`);
    return out;
};

// Greedy: of some random rows the one with most pairs that no row has yet, until there are none left.
function covering() {
    const next = random(7), left = new Set(), rows = [];
    for (const row of everything()) for (const pair of pairs(row)) left.add(pair);
    while (left.size > 0) {
        let best = null, most = -1;
        for (let k = 0; k < 400; k++) {
            const row = Object.fromEntries(names.map((name) => [name, axes[name][next(axes[name].length)]]));
            const fresh = pairs(row).filter((pair) => left.has(pair)).length;
            if (fresh > most) [best, most] = [row, fresh];
        }
        if (most === 0) continue;
        for (const pair of pairs(best)) left.delete(pair);
        rows.push(best);
    }
    return rows;
}

function everything(k = 0, row = {}) {
    if (k === names.length) return [{ ...row }];
    return axes[names[k]].flatMap((value) => everything(k + 1, { ...row, [names[k]]: value }));
}

// ---- processes ----

function start(program, args, variables, stdio = "ignore") {
    const log = openSync(join(temporary, "log"), "a");
    const child = spawn(join(build, program), args, { stdio: ["ignore", stdio === "pipe" ? "pipe" : log, log], env: { ...process.env, ...variables } });
    children.add(child);
    child.ended = new Promise((done) => child.once("exit", () => { children.delete(child); done(); }));
    return child;
}

// variables: of the environment of the server and of its workers.
async function serve(variables) {
    const data = mkdtempSync(join(temporary, "data-"));
    const child = start("shearwater", ["serve", "--listen", "127.0.0.1:0", "--data", data, "--workers", "0"], variables, "pipe");
    const url = await new Promise((done, fail) => {
        let text = "";
        child.stdout.on("data", (part) => {
            text += part;
            const found = /listening on (\S+)/.exec(text);
            if (found) done(found[1]);
        });
        child.once("exit", () => fail(new Error("the server did not start")));
    });
    const bytes = readFileSync(scene), asset = createHash("sha256").update(bytes).digest("hex");
    const put = await fetch(`${url}/v1/assets/${asset}`, { method: "PUT", body: bytes });
    if (!put.ok) throw new Error(`the scene: ${put.status}`);
    return { child, url, data, asset, variables };
}

const worker = (server, threads) => start("shearwater-worker",
    ["--connect", `unix:${server.data}/worker.sock`, "--threads", String(threads), "--cache", join(server.data, "cache"), "--blobs", join(server.data, "objects")], server.variables);

async function get(url) {
    const answer = await fetch(url);
    if (!answer.ok) throw new Error(`${url}: ${answer.status}`);
    return answer.json();
}

async function end(child, signal) {
    child.kill("SIGCONT");
    child.kill(signal);
    await child.ended;
}

// ---- disturbances: each runs beside a job until told to stop ----

const disturb = {
    async plain() {},
    async steered(run) {
        while (!run.over) {
            const at = { near: { x: run.next(WIDTH), y: run.next(HEIGHT) } };
            const region = { region: { x: run.next(WIDTH - 32), y: run.next(HEIGHT - 32), width: 32, height: 32 } };
            const answer = await fetch(run.job, { method: "PATCH", headers: { "Content-Type": "application/json" }, body: JSON.stringify(run.next(3) ? at : region) });
            if (answer.status === 200) run.did++;
            else if (answer.status !== 409) throw new Error(`steering: ${answer.status} ${await answer.text()}`);
            await sleep(5);
        }
    },
    async stopped(run) {
        while (!run.over) {
            const child = run.workers[run.next(run.workers.length)];
            child.kill("SIGSTOP");
            await sleep(2 + run.next(40));
            child.kill("SIGCONT");
            run.did++;
            await sleep(run.next(15));
        }
    },
    async killed(run) {
        for (let kills = 0; kills < 2 && !run.over; kills++) {
            const before = (await get(run.job)).progress.tiles_done;
            while (!run.over && (await get(run.job)).progress.tiles_done <= before) await sleep(2);
            if (run.over) return;
            // The youngest is as likely as any to hold tiles, and its place is taken.
            await end(run.workers.pop(), "SIGKILL");
            run.workers.push(worker(run.server, run.row.threads));
            run.did++;
        }
    },
};

async function finish(job) {
    const until = Date.now() + 90000 * slower;
    for (;;) {
        const now = await get(job);
        if (now.state === "finished") return now;
        if (["failed", "cancelled"].includes(now.state)) throw new Error(`${now.state}: ${JSON.stringify(now.error)}`);
        if (Date.now() > until) throw new Error(`not finished after ${90 * slower} s: ${JSON.stringify(now.progress)}`);
        await sleep(10);
    }
}

// A row: the digest of its EXR, and what the job says of itself.
async function render(server, row, seed) {
    const run = { server, row, next: random(seed), over: false, did: 0, workers: [] };
    const { sampling, ...rest } = jobs[row.job].document;
    const body = JSON.stringify({ ...rest, scene: { asset: server.asset }, sampling: { ...sampling, tile_px: row.tile } });
    const answer = await fetch(`${server.url}/v1/jobs`, { method: "POST", headers: { "Content-Type": "application/json" }, body });
    if (!answer.ok) throw new Error(await answer.text());
    run.job = `${server.url}${(await answer.json()).url}`;
    for (let k = 0; k < row.workers; k++) run.workers.push(worker(server, row.threads));
    const disturbance = disturb[row.order](run).catch((error) => { run.failed = error; });
    let ended;
    try {
        ended = await finish(run.job);
    } finally {
        run.over = true;
        await disturbance;
        await Promise.all(run.workers.map((child) => end(child, "SIGKILL")));
    }
    if (run.failed) throw run.failed;
    const picture = await fetch(`${run.job}/frames/1/image.exr`);
    const bytes = Buffer.from(await picture.arrayBuffer());
    return { ...ended, did: run.did, bytes, digest: createHash("sha256").update(bytes).digest("hex") };
}

// ---- the matrix ----

function report(text, fault) {
    tests++;
    console.log(`${fault ? "not ok" : "ok"} ${tests} - ${text}`);
    if (fault) { failures++; console.log(`#   ${fault}`); }
}

const references = {};
const reference_of = (row) => (jobs[row.job].by_tile ? `${row.job}, tiles of ${row.tile}` : row.job);
async function refer(server, job, tile) {
    const row = { job, workers: 1, threads: 1, tile, order: "plain", block: 0 };
    const done = await render(server, row, 1);
    const { integrator, rounds } = jobs[job];
    let fault = integrator && done.plan.integrator !== integrator ? `its integrator is ${done.plan.integrator}` : "";
    if (rounds && !(done.progress.tiles_total > Math.ceil(WIDTH / tile) * Math.ceil(HEIGHT / tile))) fault = "it has no rounds";
    references[reference_of(row)] = done.digest;
    writeFileSync(join(temporary, `${job}.exr`), done.bytes);
    report(`${reference_of(row)}: the undisturbed picture`, fault);
}

async function run() {
    const rows = all ? everything() : covering();
    const counts = Object.fromEntries(axes.order.map((order) => [order, { did: 0, reissued: 0 }]));
    for (const block of axes.block) {
        const server = await serve(block > 0 ? { SHEARWATER_BLOCK_PX: String(block) } : {});
        if (block === 0)
            for (const job of axes.job)
                for (const tile of jobs[job].by_tile ? axes.tile : [32]) await refer(server, job, tile);
        for (const row of rows.filter((r) => r.block === block)) {
            const text = names.map((name) => `${name} ${row[name]}`).join(", ");
            try {
                const done = await render(server, row, rows.indexOf(row) + 2);
                counts[row.order].did += done.did;
                counts[row.order].reissued += done.statistics.tiles.reissued;
                report(text, done.digest === references[reference_of(row)] ? "" : "its bytes are others than the undisturbed picture's");
            } catch (error) {
                report(text, error.message);
            }
        }
        await end(server.child, "SIGTERM");
    }
    report("jobs were steered while they ran", counts.steered.did > rows.length / 4 ? "" : `${counts.steered.did} times`);
    report("workers were stopped while they ran", counts.stopped.did > rows.length / 4 ? "" : `${counts.stopped.did} times`);
    report("workers were killed, and their tiles leased again", counts.killed.did > 0 && counts.killed.reissued > 0 ? "" : JSON.stringify(counts.killed));
    console.log(`# ${rows.length} rows; ${JSON.stringify(counts)}`);
}

// Instruction sets: the project's own kernels give the same bits on all of them (test_lane_kernels,
// make check-kernels: tolerance 0; with SSE4.2 filters' last bits are others), but Embree's hits differ in their last bits, and rays that run
// into an edge may meet the one side or the other. So each set has pictures of its own, for which all
// of the above holds, and which are those of the others within this RMSE (of beauty, whose mean is
// about 0.1; of paths, which few such rays belong to, it is a hundred thousandth of that).
const ISA_RMSE = 2e-3;

async function compare_sets() {
    for (const isa of ["sse4.2", "avx2"]) {
        const server = await serve({ SHEARWATER_ISA: isa });
        for (const job of axes.job.filter((name) => !jobs[name].rounds)) {
            const text = `${job} on ${isa}`, path = join(temporary, `${job}-${isa}.exr`);
            try {
                const one = await render(server, { job, workers: 1, threads: 1, tile: 64, order: "plain" }, 1);
                const other = await render(server, { job, workers: 2, threads: 2, tile: 24, order: "stopped" }, 2);
                report(`${text}: the same bytes however it is cut`, one.digest === other.digest ? "" : "they differ");
                writeFileSync(path, one.bytes);
                const compared = JSON.parse(execFileSync(join(build, "shearwater"), ["compare", join(temporary, `${job}.exr`), path, "--layer", "beauty"]));
                report(`${text}: the picture of this CPU's best set, within ${ISA_RMSE}`, compared.finite && compared.rmse <= ISA_RMSE ? "" : JSON.stringify(compared));
                console.log(`# ${text}: RMSE ${compared.rmse}`);
            } catch (error) {
                report(text, error.message);
            }
        }
        await end(server.child, "SIGTERM");
    }
}

function clear() {
    for (const child of children) child.kill("SIGKILL");
    rmSync(temporary, { recursive: true, force: true });
}
for (const signal of ["SIGINT", "SIGTERM"]) process.on(signal, () => { clear(); process.exit(130); });
try {
    await run();
    await compare_sets();
} catch (error) {
    report("the matrix", `${error.stack}\n# ${readFileSync(join(temporary, "log"), "utf8").split("\n").slice(-20).join("\n# ")}`);
}
console.log(`1..${tests}`);
clear();
process.exit(failures > 0 ? 1 : 0);
