// The machine below fails: the k-th write, fsync, rename, allocation or making of a file, in a coordinator
// or an importer, somewhere in a short job; a disk that is full or fails for a while; a clock that jumps.
//   node tests/load/faults.mjs BUILD_DIR [sample=90] [seed=N] [kind=NAME] [only=walk|while|clock] [at=K]
// sample=0 walks over all k, which takes hours for allocations. What must hold each time: what was answered
// is a success, or 503 or 507 as problem+json, and passes; what was accepted is finished within 10 s and has
// the undisturbed bytes; nothing half-written is left. A process that died is started again, which is all
// that is done by hand; where it lives, nothing is.
import { closeSync, openSync, readSync, writeSync } from "node:fs";
import { resolve } from "node:path";
import { Service, check, done, folder, join, note, options, readFileSync, readdirSync, seeded, sha256, sleep, until, writeFileSync } from "./service.mjs";

const build = process.argv[2];
const want = options({ sample: 90, seed: Math.floor(Date.now() / 1000) % 1000000, kind: "", only: "", at: 0, program: "", lanes: 3 });
const KINDS = ["write", "fsync", "rename", "allocation", "make"];
const ENOENT = 2, EIO = 5, ENOMEM = 12, ENOSPC = 28;
const RECOVERY_S = 10;
const scene = readFileSync("tests/scenes/cornell-box/cornell-box.glb");
const short = { image: { width: 64, height: 64 }, sampling: { spp: 4, tile_px: 32 }, layers: ["beauty", "direct", "indirect"] };
const long = { image: { width: 256, height: 256 }, sampling: { spp: 64, tile_px: 32 }, filter: { method: "none" } };
const shim = resolve(build, "tests/fake/preload_faults.so"); // children have folders of their own

// ---- the control block of tests/fake/preload_faults.c ----

class Control {
    constructor(path) { this.path = path; writeFileSync(path, Buffer.alloc(8 * (4 * KINDS.length + 1))); }
    put(number, value) {
        const bytes = Buffer.alloc(8), fd = openSync(this.path, "r+");
        bytes.writeBigInt64LE(BigInt(value));
        writeSync(fd, bytes, 0, 8, 8 * number);
        closeSync(fd);
    }
    get(number) {
        const bytes = Buffer.alloc(8), fd = openSync(this.path, "r");
        readSync(fd, bytes, 0, 8, 8 * number);
        closeSync(fd);
        return Number(bytes.readBigInt64LE());
    }
    calls(kind) { return this.get(4 * KINDS.indexOf(kind)); }
    fail(kind, first, count, error) {
        const at = 4 * KINDS.indexOf(kind);
        this.put(at + 3, error);
        this.put(at + 2, count);
        this.put(at + 1, first);
    }
    from_now(kind, error) { this.fail(kind, this.calls(kind) + 1, 1e9, error); }
    heal() { for (const kind of KINDS) this.put(4 * KINDS.indexOf(kind) + 1, 0); }
    clock(seconds) { this.put(4 * KINDS.length, seconds); }
}

// ---- one life under faults ----

class Life {
    constructor(program) {
        this.home = folder("faults");
        this.control = new Control(join(this.home, "control"));
        this.service = new Service(build, join(this.home, "data"), {
            workers: 1, environment: { LD_PRELOAD: shim, FAULTS_CONTROL: this.control.path, FAULTS_FOR: program },
        });
        this.deaths = 0;
        this.wrong = [];
        this.statuses = new Map();
    }
    async start() {
        for (let tries = 0; tries < 4; tries++) {
            try { await this.service.start(); break; } catch { this.deaths++; }
        }
        if (!this.service.is_up) throw new Error(`it does not start any more:\n${this.service.log().slice(-800)}`);
    }
    // Asks until it is answered with a success; answers in between must be those of troubles that pass.
    async persist(ask, seconds = 2 * RECOVERY_S) {
        for (const end = Date.now() + 1000 * seconds; ;) {
            if (!this.service.is_up) { this.deaths++; await this.service.ended; await this.start(); }
            const answer = await ask().catch(() => null);
            if (answer) this.judge(answer);
            if (answer && answer.status < 500) return answer;
            if (Date.now() > end) throw new Error(`no success within ${seconds} s: ${answer ? `${answer.status} ${answer.body}` : "no answer"}`);
            await sleep(25);
        }
    }
    judge({ status, headers, body }) {
        this.statuses.set(status, (this.statuses.get(status) ?? 0) + 1);
        if (status < 400) return;
        const problem = headers["content-type"] === "application/problem+json" && JSON.parse(body).status === status;
        if ((status !== 503 && status !== 507) || !problem) this.wrong.push(`${status} ${body}`);
    }
    async submit(document, key) {
        const asset = sha256(scene);
        await this.persist(() => this.service.put(scene));
        const answer = await this.persist(() => this.service.post({ scene: { asset }, ...document }, key));
        if (answer.status !== 202) throw new Error(`not accepted: ${answer.status} ${answer.body}`);
        return JSON.parse(answer.body).id;
    }
    // The digest of its picture when it is finished.
    async picture(id, seconds) {
        const end = Date.now() + 1000 * seconds;
        for (;;) {
            const answer = await this.persist(() => this.service.ask("GET", `/v1/jobs/${id}`)), job = JSON.parse(answer.body);
            if (job.state === "finished") break;
            if (job.state === "failed" || job.state === "cancelled") throw new Error(`it is ${job.state}: ${JSON.stringify(job.error)}`);
            if (Date.now() > end) throw new Error(`it is ${job.state} after ${seconds} s: ${JSON.stringify(job.log.slice(-3))}`);
            await sleep(20);
        }
        return sha256((await this.persist(() => this.service.ask("GET", `/v1/jobs/${id}/frames/1/image.exr`))).body);
    }
    // In order, with nothing left behind.
    async end() {
        this.control.heal();
        if (!this.service.is_up) { this.deaths++; await this.service.ended; await this.start(); }
        await until(5, () => this.debris().length === 0);
        const left = this.debris();
        if (left.length) this.wrong.push(`left behind: ${left.join(" ")}`);
        const { code, signal } = await this.service.kill("SIGTERM");
        if (code !== 0) this.wrong.push(`it ended with ${code ?? signal}`);
    }
    debris() {
        return ["tmp", "spool"].flatMap((name) => {
            try { return readdirSync(join(this.service.data, name)).map((file) => `${name}/${file}`); } catch { return []; }
        });
    }
}

// ---- the walk ----

const reference = {}, totals = {};
const undisturbed = async (program) => {
    const life = new Life(program);
    await life.start();
    const id = await life.submit(short, "short");
    reference.short = await life.picture(id, 60);
    totals[program] = Object.fromEntries(KINDS.map((kind) => [kind, life.control.calls(kind)]));
    reference.long ??= await life.picture(await life.submit(long, "long"), 60);
    await life.end();
    note(`${program}: ${KINDS.map((kind) => `${totals[program][kind]} ${kind}s`).join(", ")} in a short job`);
};

const errors_of = { write: [ENOSPC, EIO], fsync: [EIO, ENOSPC], rename: [EIO, ENOSPC], allocation: [ENOMEM], make: [ENOSPC, EIO] };
const name_of = { [EIO]: "EIO", [ENOMEM]: "ENOMEM", [ENOSPC]: "ENOSPC", [ENOENT]: "ENOENT" };
const counts = { runs: 0, deaths: 0, refused: 0, slowest_s: 0 }, misses = [];

const one_fault = async ({ program, kind, k, error }) => {
    const what = `${program}: ${kind} ${k} of ${totals[program][kind]} fails with ${name_of[error]}`;
    const life = new Life(program), begin = performance.now();
    try {
        life.control.fail(kind, k, 1, error);
        await life.start();
        const id = await life.submit(short, "walk");
        const digest = await life.picture(id, 2 * RECOVERY_S);
        const seconds = (performance.now() - begin) / 1000;
        counts.slowest_s = Math.max(counts.slowest_s, seconds);
        if (digest !== reference.short) life.wrong.push("its picture is another one");
        if (seconds > RECOVERY_S) life.wrong.push(`it took ${seconds.toFixed(1)} s`);
        const jobs = JSON.parse((await life.persist(() => life.service.ask("GET", "/v1/jobs"))).body).jobs;
        if (jobs.length !== 1) life.wrong.push(`${jobs.length} jobs`);
        await life.end();
    } catch (e) {
        life.wrong.push(e.message);
        if (life.service.is_up) await life.service.kill();
    }
    counts.runs++;
    counts.deaths += life.deaths;
    counts.refused += [...life.statuses].filter(([status]) => status >= 500).reduce((sum, [, n]) => sum + n, 0);
    if (life.deaths && process.env.FAULTS_SHOW_DEATHS) note(`${what}: died: ${life.service.log().slice(-400).replaceAll("\n", " | ")}`);
    for (const wrong of life.wrong) misses.push(`${what}: ${wrong}`);
};

const walk = async () => {
    const random = seeded(want.seed), points = [];
    for (const program of ["shearwater", "shearwater-import"]) {
        if (want.program && want.program !== program) continue;
        for (const kind of KINDS) {
            if (want.kind && want.kind !== kind) continue;
            const all = Array.from({ length: totals[program][kind] }, (_, i) => i + 1)
                .flatMap((k) => errors_of[kind].map((error) => ({ program, kind, k, error })));
            // A fair share of each kind, so that the few writes are not lost among the allocations.
            const share = want.sample ? Math.ceil(want.sample / (program === "shearwater" ? 6 : 20)) : all.length;
            while (all.length > share) all.splice(random(all.length), 1);
            points.push(...(want.at ? all.filter((point) => point.k === want.at) : all));
        }
    }
    if (want.at && !points.length) for (const error of errors_of[want.kind]) points.push({ program: want.program || "shearwater", kind: want.kind, k: want.at, error });
    let next = 0;
    const lane = async () => { while (next < points.length) await one_fault(points[next++]); };
    await Promise.all(Array.from({ length: want.lanes }, lane));
    note(`${counts.runs} faults: ${counts.deaths} deaths, ${counts.refused} requests refused for a while, ${counts.slowest_s.toFixed(1)} s from start to picture at most`);
    check(`${counts.runs} single faults: nothing accepted is lost, all pictures are the same`, counts.runs > 0 && misses.length === 0, misses.join("\n"));
};

// ---- troubles that last ----

const problem = (answer, status, slug) => answer?.status === status && answer.headers["content-type"] === "application/problem+json" && String(answer.body).includes(`:problem:${slug}"`);
const lasting = async (name, kinds, error, status, slug) => {
    const life = new Life("shearwater"), { service, control } = life;
    await life.start();
    const running = await life.submit(long, "running");
    await until(20, async () => (await service.job(running)).progress.tiles_done > 5);
    const pid = service.pid;
    for (const kind of kinds) control.from_now(kind, error);
    const refused = await service.post({ scene: { asset: sha256(scene) }, ...short }, "later").catch((e) => e);
    check(`${name}: a submission is answered ${status} ${slug}`, problem(refused, status, slug), `${refused.status} ${refused.body ?? refused}`);
    const other = Buffer.concat([scene, Buffer.from("another")]);
    const upload = await service.put(other).catch((e) => e);
    check(`${name}: so is an upload`, problem(upload, status, slug), `${upload.status} ${upload.body ?? upload}`);
    await sleep(4000); // long enough for the running job to come to its files
    check(`${name}: it answers meanwhile`, (await service.ask("GET", "/livez")).status === 200 && (await service.job(running)) !== null);
    const state = (await service.job(running)).state;
    check(`${name}: what was accepted waits (${state})`, state !== "failed" && state !== "cancelled", JSON.stringify((await service.job(running)).error));
    control.heal();
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

// ---- clocks ----

const HOUR_S = 3600, YEAR_S = 31557600;
const clocks = async () => {
    const life = new Life("shearwater"), { service, control } = life;
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
    control.clock(YEAR_S);
    const jobs = (await service.json("/v1/jobs?limit=100")).jobs;
    check("all jobs are there once", jobs.length === 9 && new Set(jobs.map((job) => job.id)).size === 9, `${jobs.length}`);
    check("all in one process but for that kill", life.deaths === 0);
    await life.end();
    check("nothing is left behind", life.wrong.length === 0, life.wrong.join("\n"));
};

// ---- the story ----

note(`seed ${want.seed}`);
await undisturbed("shearwater");
await undisturbed("shearwater-import");
if (!want.only || want.only === "walk") await walk();
if (!want.only || want.only === "while") {
    await lasting("a full disk", ["write", "make"], ENOSPC, 507, "disk-full");
    await lasting("a failing disk", ["write", "fsync", "rename", "make"], EIO, 503, "storage-failed");
}
if (!want.only || want.only === "clock") await clocks();
done();
