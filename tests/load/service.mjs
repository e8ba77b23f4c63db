// A real coordinator with its data folder, for scripts that ask it for much or treat it badly; and TAP.
import { spawn } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdirSync, mkdtempSync, openSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { Agent, request } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";

// ---- TAP ----

// How many times as long as usual to wait (tests/run).
export const slower = Number(process.env.TEST_SLOWER ?? 1);
let tests = 0, failures = 0;
export const note = (text) => console.log(`# ${text}`);
export const check = (text, ok, why = "") => {
    tests++;
    console.log(`${ok ? "ok" : "not ok"} ${tests} - ${text}`);
    if (ok) return ok;
    failures++;
    for (const line of String(typeof why === "string" ? why : JSON.stringify(why)).split("\n").slice(0, 40)) note(line);
    return ok;
};
export const skip = (text, why) => console.log(`ok ${++tests} - ${text} # SKIP ${why}`);
// A check of a time, a rate or of memory: sanitized builds have others, what they miss is said as skipped.
export const figure = (text, ok, why = "") => ok || slower === 1 ? check(text, ok, why) : skip(text, "missed, by a build that is slow for its sanitizer");
export const done = () => { console.log(`1..${tests}`); process.exitCode = failures ? 1 : 0; };
export const failed = () => failures;

// name=value of the command line over defaults; numbers stay numbers.
export const options = (defaults) => {
    const out = { ...defaults };
    for (const argument of process.argv.slice(3)) {
        const [name, value] = argument.split("=");
        if (!(name in defaults) || value === undefined) throw new Error(`${argument}: not one of ${Object.keys(defaults).join("=, ")}=`);
        out[name] = typeof defaults[name] === "number" ? Number(value) : value;
    }
    return out;
};

// xorshift32: whole numbers below n, the same every time.
export const seeded = (seed) => {
    let x = seed >>> 0 || 1;
    return (n) => { x ^= x << 13; x ^= x >>> 17; x ^= x << 5; x >>>= 0; return x % n; };
};
export const until = async (seconds, condition, every_ms = 20) => {
    for (const end = Date.now() + 1000 * slower * seconds; ;) {
        const value = await condition();
        if (value) return value;
        if (Date.now() > end) return null;
        await sleep(every_ms);
    }
};
export const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

// ---- folders and processes that go when the script does ----

const folders = [], children = new Set();
export const folder = (name) => { const path = mkdtempSync(join(tmpdir(), `${name}-`)); folders.push(path); return path; };
process.on("exit", () => {
    for (const child of children) try { process.kill(child.pid, "SIGKILL"); } catch { /* gone */ }
    for (const path of folders) try { rmSync(path, { recursive: true, force: true, maxRetries: 5 }); } catch { /* its business */ }
});
for (const signal of ["SIGINT", "SIGTERM"]) process.on(signal, () => process.exit(130));

// Processes that a process's first thread has started, {pid, name}: a few reads, so that it can be asked for
// each millisecond.
export const children_of = (parent) => {
    const read = (path) => { try { return readFileSync(path, "latin1"); } catch { return ""; } };
    return read(`/proc/${parent}/task/${parent}/children`).split(" ").filter(Boolean)
        .map((pid) => ({ pid: Number(pid), name: read(`/proc/${pid}/comm`).trim() })).filter((child) => child.name);
};

// ---- the service ----

export class Service {
    constructor(build, data, { workers = 2, threads = 1, environment = {}, args = [] } = {}) {
        Object.assign(this, { build, data, workers, threads, environment, args, port: 0, child: null, starts: 0 });
        mkdirSync(data, { recursive: true });
        this.agent = new Agent({ keepAlive: true, maxSockets: 64 });
    }

    // Resolves with the milliseconds until it said that it listens; rejects when it ends before.
    async start(environment = {}) {
        const begin = performance.now();
        const log = openSync(join(this.data, "log"), "a");
        const child = spawn(join(this.build, "shearwater"), ["serve", "--listen", `127.0.0.1:${this.port}`, "--data", this.data,
            "--workers", String(this.workers), "--worker-threads", String(this.threads), ...this.args],
            { stdio: ["ignore", "pipe", log], env: { ...process.env, ...this.environment, ...environment } });
        children.add(child);
        this.child = child;
        this.ended = new Promise((resolve) => child.on("exit", (code, signal) => {
            children.delete(child);
            this.agent.destroy();
            resolve({ code, signal });
        }));
        this.starts++;
        let text = "";
        await new Promise((resolve, reject) => {
            child.stdout.on("data", (piece) => { text += piece; if (/listening on .*:\d+\n/.test(text)) resolve(); });
            this.ended.then((end) => reject(new Error(`the coordinator ended with ${end.code ?? end.signal} before it listened`)));
        });
        this.port = Number(/listening on .*:(\d+)\n/.exec(text)[1]);
        this.pid = child.pid;
        return performance.now() - begin;
    }
    get is_up() { return this.child && this.child.exitCode === null && this.child.signalCode === null; }
    async kill(signal = "SIGKILL") { this.child.kill(signal); return this.ended; }
    log() { return readFileSync(join(this.data, "log"), "utf8"); }

    // {status, headers, body}: body a Buffer. Rejects when the connection breaks.
    ask(method, path, { body = null, headers = {}, timeout_ms = 20000 * slower } = {}) {
        return new Promise((resolve, reject) => {
            const r = request({ host: "127.0.0.1", port: this.port, method, path, headers, agent: this.agent, timeout: timeout_ms }, (answer) => {
                const pieces = [];
                answer.on("data", (piece) => pieces.push(piece));
                answer.on("end", () => resolve({ status: answer.statusCode, headers: answer.headers, body: Buffer.concat(pieces) }));
                answer.on("error", reject);
            });
            r.on("timeout", () => r.destroy(new Error(`${method} ${path}: no answer within ${timeout_ms} ms`)));
            r.on("error", reject);
            r.end(body);
        });
    }
    async json(path) { const a = await this.ask("GET", path); return a.status === 200 ? JSON.parse(a.body) : null; }
    put(bytes) { return this.ask("PUT", `/v1/assets/${sha256(bytes)}`, { body: bytes }); }
    post(document, key = null) {
        const headers = { "Content-Type": "application/json", ...(key ? { "Idempotency-Key": key } : {}) };
        return this.ask("POST", "/v1/jobs", { body: JSON.stringify(document), headers });
    }
    async job(id) { return this.json(`/v1/jobs/${id}`); }
    async picture(id, kind = "exr", frame = 1) {
        const a = await this.ask("GET", `/v1/jobs/${id}/frames/${frame}/image.${kind}`);
        return a.status === 200 ? a.body : null;
    }
    async metric(name) {
        return (await this.metrics(name))[0];
    }
    // Several of one moment; null for those that are not there.
    async metrics(...names) {
        const lines = String((await this.ask("GET", "/metrics")).body).split("\n");
        return names.map((name) => {
            const line = lines.find((l) => l.startsWith(`${name} `));
            return line ? Number(line.split(" ")[1]) : null;
        });
    }
}

// The same scene under another digest: glTF's JSON with a mark in it, so that it is imported once more.
export const marked_scene = (glb, mark) => {
    const length = glb.readUInt32LE(12), json = JSON.parse(glb.subarray(20, 20 + length));
    json.asset = { ...json.asset, extras: { mark } };
    let text = Buffer.from(JSON.stringify(json));
    text = Buffer.concat([text, Buffer.alloc((4 - text.length % 4) % 4, 0x20)]);
    const head = Buffer.from(glb.subarray(0, 20));
    head.writeUInt32LE(text.length, 12);
    const out = Buffer.concat([head, text, glb.subarray(20 + length)]);
    out.writeUInt32LE(out.length, 8);
    return out;
};

export { join, readFileSync, readdirSync, sleep, writeFileSync };
