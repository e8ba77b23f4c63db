// The machine below fails: the k-th write, fsync, rename, allocation, making of a file or sending on a socket,
// in a coordinator, an importer or a worker, somewhere in a short job; a disk that is full, fails or hangs for
// a while; a clock that jumps.
//   node tests/load/faults.mjs BUILD_DIR [sample=N] [seed=N] [only=walk|while|hang|clock]
//        of the walk: [kind=NAME] [program=NAME] [stage=NAME] [at=K] [from=K] [to=K] [lanes=N] [patience=SECONDS]
// sample=0 walks over all k. What must hold each time: what was answered is a success, or 503 or 507 as
// problem+json, and passes; what was accepted is finished within 10 s and has the undisturbed bytes; nothing
// half-written is left. A process that died is started again, which is all that is done by hand; where it
// lives, nothing is.
import { crawl_uploads, hang, hang_uploads } from "./fault_hang.mjs";
import { EIO, ENOSPC, Life, RECOVERY_S, scene } from "./fault_life.mjs";
import { Walk } from "./fault_walk.mjs";
import { execFileSync } from "node:child_process";
import { closeSync, openSync, rmSync, writeSync } from "node:fs";
import { check, done, folder, join, note, options, sha256, skip, sleep, until } from "./service.mjs";

const build = process.argv[2];
const want = options({ sample: 84, seed: Math.floor(Date.now() / 1000) % 1000000, kind: "", only: "", at: 0, from: 0, to: 0, program: "", stage: "", lanes: 3, patience: 0 });
const short = { image: { width: 64, height: 64 }, sampling: { spp: 4, tile_px: 32 }, layers: ["beauty", "direct", "indirect"] };
const long = { image: { width: 256, height: 256 }, sampling: { spp: 32, tile_px: 32 }, filter: { method: "none" } };
const reference = {};
const undisturbed = async () => {
    const life = new Life(build, "shearwater");
    await life.start();
    reference.short = await life.picture(await life.submit(short, "short"), 60);
    reference.long = await life.picture(await life.submit(long, "long"), 60);
    await life.end();
};

// ---- one call that fails ----

const walk = async () => {
    const steps = new Walk(build, want, note);
    await steps.prepare();
    const { ok, runs, hit } = await steps.walk();
    check(`${runs} single faults (${hit} came): nothing accepted is lost, all pictures are the same`, ok, steps.misses.join("\n"));
};

// ---- troubles that last ----

const problem = (answer, status, slug) => answer?.status === status && answer.headers["content-type"] === "application/problem+json" && String(answer.body).includes(`:problem:${slug}"`);
// trouble: {prepare(life), begin(life), over(life)}: before the coordinator starts, and while it runs.
const lasting = async (name, trouble, status, slug) => {
    const life = new Life(build, "shearwater"), { service } = life;
    trouble.prepare?.(life);
    await life.start();
    const running = await life.submit(long, "running");
    await until(20, async () => (await service.job(running)).progress.tiles_done > 5);
    const pid = service.pid;
    await trouble.begin(life);
    const refused = await service.post({ scene: { asset: sha256(scene) }, ...short }, "later").catch((e) => e);
    check(`${name}: a submission is answered ${status} ${slug}`, problem(refused, status, slug), `${refused.status} ${refused.body ?? refused}`);
    const other = Buffer.concat([scene, Buffer.from("another")]);
    const upload = await service.put(other).catch((e) => e);
    check(`${name}: so is an upload`, problem(upload, status, slug), `${upload.status} ${upload.body ?? upload}`);
    await until(60, async () => (({ tiles_done, tiles_total }) => tiles_done === tiles_total)((await service.job(running)).progress));
    await sleep(2000); // ... and comes to its files
    check(`${name}: it answers meanwhile`, (await service.ask("GET", "/livez")).status === 200 && (await service.job(running)) !== null);
    const state = (await service.job(running)).state;
    check(`${name}: what was accepted waits (${state})`, state !== "failed" && state !== "cancelled", JSON.stringify((await service.job(running)).error));
    await trouble.over(life);
    const begin = performance.now();
    const digest = await life.picture(running, 30).catch((e) => e.message);
    const seconds = (performance.now() - begin) / 1000;
    check(`${name}: over, the job is finished with the same bytes`, digest === reference.long, digest);
    check(`${name}: within ${RECOVERY_S} s (${seconds.toFixed(1)} s)`, seconds <= RECOVERY_S);
    check(`${name}: the submission is accepted now`, await life.picture(await life.submit(short, "later"), 30).catch((e) => e.message) === reference.short);
    check(`${name}: in the same process`, service.is_up && service.pid === pid && life.deaths === 0);
    life.wrong.length = 0; // answers in between were looked at above
    await life.end();
    check(`${name}: nothing is left behind`, life.wrong.length === 0, life.wrong.join("\n"));
};
const calls_fail = (kinds, error) => ({
    begin: ({ control }) => { for (const kind of kinds) control.from_now(kind, error); },
    over: ({ control }) => control.heal(),
});

// A disk of its own that is really full: all of it is given to a file, to the last byte, again and again as
// the coordinator gives something back.
const mounts = [];
process.on("exit", () => { for (const path of mounts) try { execFileSync("umount", ["-l", path]); } catch { /* its business */ } });
const small_disk = {
    prepare({ service }) {
        execFileSync("mount", ["-t", "tmpfs", "-o", "size=24m", "tmpfs", service.data], { stdio: "ignore" });
        mounts.push(service.data);
    },
    begin(life) {
        const file = openSync(join(life.service.data, "filler"), "a"), block = Buffer.alloc(65536);
        const fill = () => {
            for (let size = block.length; size > 0;)
                try { writeSync(file, block, 0, size); } catch { size >>= 1; }
        };
        fill();
        this.file = file;
        this.timer = setInterval(fill, 5);
    },
    over(life) {
        clearInterval(this.timer);
        closeSync(this.file);
        rmSync(join(life.service.data, "filler"));
    },
};
const can_mount = () => {
    const path = folder("mount");
    try { execFileSync("mount", ["-t", "tmpfs", "-o", "size=1m", "tmpfs", path], { stdio: "ignore" }); } catch { return false; }
    execFileSync("umount", [path]);
    return true;
};

// ---- clocks ----

const HOUR_S = 3600, YEAR_S = 31557600;
const clocks = async () => {
    const life = new Life(build, "shearwater"), { service, control } = life;
    await life.start();
    for (const [name, seconds] of [["an hour on", HOUR_S], ["an hour back", -HOUR_S], ["a year on", YEAR_S], ["a year back", -YEAR_S]]) {
        control.clock(0);
        const id = await life.submit(long, `before ${name}`.replaceAll(" ", "-"));
        await until(20, async () => (await service.job(id)).progress.tiles_done > 5, 5);
        control.clock(seconds);
        const during = await life.submit({ ...short, priority: 1 }, `after ${name}`.replaceAll(" ", "-"));
        check(`the clock jumps ${name}: a job goes on, the same bytes`, await life.picture(id, 30).catch((e) => e.message) === reference.long);
        check("... so is one that is submitted then", await life.picture(during, 30).catch((e) => e.message) === reference.short);
        const { statistics } = await service.job(id);
        check("... no lease ends by it", statistics.tiles.reissued === 0 && statistics.results.dropped === 0, JSON.stringify(statistics.tiles));
        check("... and it says that it is ready", (await service.ask("GET", "/readyz")).status === 200);
    }
    // Killed in one year, started in another.
    control.clock(0);
    const id = await life.submit(long, "over-the-years");
    await until(20, async () => (await service.job(id)).progress.tiles_done > 5, 5);
    await service.kill();
    control.clock(-YEAR_S);
    await life.start();
    check("killed today, started a year ago: it is finished, the same bytes", await life.picture(id, 30).catch((e) => e.message) === reference.long);
    const last = await life.submit(short, "a-year-ago");
    const jobs = (await service.json("/v1/jobs?limit=100")).jobs;
    check("the last one that came is listed first, whatever the year", jobs[0].id === last && jobs[1].id === id, jobs.map((job) => job.id).join(" "));
    check("... and is finished, the same bytes", await life.picture(last, 30).catch((e) => e.message) === reference.short);
    control.clock(YEAR_S);
    check("all jobs are there once", jobs.length === 10 && new Set(jobs.map((job) => job.id)).size === 10, `${jobs.length}`);
    check("all in one process but for that kill", life.deaths === 0);
    await life.end();
    check("nothing is left behind", life.wrong.length === 0, life.wrong.join("\n"));
};

// ---- the story ----

note(`seed ${want.seed}`);
if (!want.only || want.only === "walk") await walk();
if (want.only !== "walk") await undisturbed();
if (!want.only || want.only === "while") {
    await lasting("a full disk", calls_fail(["write", "make"], ENOSPC), 507, "disk-full");
    await lasting("a failing disk", calls_fail(["write", "fsync", "rename", "make"], EIO), 503, "storage-failed");
    if (can_mount()) await lasting("a real disk that is full", small_disk, 507, "disk-full");
    else skip("a real disk that is full", "only root may mount one");
}
if (!want.only || want.only === "hang") {
    await hang(build, { short, long, reference });
    await hang_uploads(build, { short, reference });
    await crawl_uploads(build, { short, reference });
}
if (!want.only || want.only === "clock") await clocks();
done();
