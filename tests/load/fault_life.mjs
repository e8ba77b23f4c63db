// A coordinator's life on a machine that fails on purpose (tests/fake/preload_faults.c), and who asks it for
// a job all the same.
import { spawn } from "node:child_process";
import { closeSync, cpSync, openSync, readSync, rmSync, writeSync } from "node:fs";
import { resolve } from "node:path";
import { Service, folder, join, readFileSync, readdirSync, sha256, sleep, until, writeFileSync } from "./service.mjs";

export const KINDS = ["write", "fsync", "rename", "allocation", "make", "send"];
export const EIO = 5, ENOMEM = 12, ENOSPC = 28, ECONNRESET = 104, ENOBUFS = 105;
export const name_of = { [EIO]: "EIO", [ENOMEM]: "ENOMEM", [ENOSPC]: "ENOSPC", [ECONNRESET]: "ECONNRESET", [ENOBUFS]: "ENOBUFS" };
export const RECOVERY_S = 10;
export const scene = readFileSync("tests/scenes/cornell-box/cornell-box.glb");
const HANG = 0;

// The control block, which the faulty processes have mapped.
export class Control {
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
    all() { return Object.fromEntries(KINDS.map((kind) => [kind, this.calls(kind)])); }
    fail(kind, first, count, error) {
        const at = 4 * KINDS.indexOf(kind);
        this.put(at + 3, error);
        this.put(at + 2, count);
        this.put(at + 1, first);
    }
    from_now(kind, error) { this.fail(kind, this.calls(kind) + 1, 1e9, error); }
    slow(kind, ms) { this.from_now(kind, -ms); }
    hang(kind) { this.from_now(kind, HANG); }
    heal() { for (const kind of KINDS) this.put(4 * KINDS.indexOf(kind) + 1, 0); }
    clock(seconds) { this.put(4 * KINDS.length, seconds); }
}

// `program`: whose calls fail. `remote`: the worker is no child of the coordinator's, but dials it over TCP
// and keeps files; when it ends it is started again, as its host would. `template`: a data folder to begin with.
export class Life {
    constructor(build, program, { remote = false, template = null, environment = {} } = {}) {
        this.home = folder("faults");
        this.control = new Control(join(this.home, "control"));
        this.build = build;
        this.remote = remote;
        this.faulty = { LD_PRELOAD: resolve(build, "tests/fake/preload_faults.so"), FAULTS_CONTROL: this.control.path, FAULTS_FOR: program };
        if (template) cpSync(template, join(this.home, "data"), { recursive: true });
        this.service = new Service(build, join(this.home, "data"), {
            workers: remote ? 0 : 1, environment: { ...environment, ...(remote ? {} : this.faulty) }, args: remote ? ["--worker-listen", "127.0.0.1:0"] : [],
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
        if (this.remote) await this.start_worker();
    }
    async start_worker() {
        const port = /worker_port=(\d+)/.exec(await until(5, () => /worker_port=\d+.*\n/.exec(this.service.log())?.[0]))?.[1];
        const again = () => {
            if (this.ending) return;
            const log = openSync(join(this.home, "worker.log"), "a");
            this.worker = spawn(join(this.build, "shearwater-worker"), ["--connect", `127.0.0.1:${port}`, "--threads", "1", "--cache", join(this.home, "cache")],
                { stdio: ["ignore", "ignore", log], env: { ...process.env, ...this.faulty } });
            closeSync(log);
            this.worker.on("exit", () => { if (!this.ending) { this.worker_deaths = (this.worker_deaths ?? 0) + 1; setTimeout(again, 100); } });
        };
        again();
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
    // As if it had never been: the next job begins with the upload of its scene again.
    async forget(id) {
        await this.persist(() => this.service.ask("DELETE", `/v1/jobs/${id}?purge=1`));
        const objects = join(this.service.data, "objects");
        for (const name of readdirSync(objects)) rmSync(join(objects, name), { recursive: true });
        rmSync(join(this.home, "cache"), { recursive: true, force: true });
    }
    async check_debris() {
        await until(5, () => this.debris().length === 0);
        const left = this.debris();
        if (left.length) this.wrong.push(`left behind: ${left.join(" ")}`);
    }
    // In order, with nothing left behind.
    async end() {
        this.control.heal();
        if (!this.service.is_up) { this.deaths++; await this.service.ended; await this.start(); }
        await this.check_debris();
        await this.leave();
    }
    async leave() {
        this.ending = true;
        const { code, signal } = await this.service.kill("SIGTERM");
        if (code !== 0) this.wrong.push(`it ended with ${code ?? signal}`);
        await this.drop();
    }
    async drop() {
        this.ending = true;
        if (this.service.is_up) await this.service.kill();
        if (this.worker) this.worker.kill("SIGKILL");
        await sleep(0);
        try { rmSync(this.home, { recursive: true, force: true, maxRetries: 10 }); } catch { /* a disk of its own is mounted there: it goes at the end */ }
    }
    debris() {
        return ["tmp", "spool"].flatMap((name) => {
            try { return readdirSync(join(this.service.data, name)).map((file) => `${name}/${file}`); } catch { return []; }
        });
    }
}
