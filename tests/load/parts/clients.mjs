// What the parts of the load test share: tenants with tokens, figures of processes, quantiles.
import { execFileSync } from "node:child_process";
import { chmodSync } from "node:fs";
import { Service, folder, join, readFileSync, readdirSync } from "../service.mjs";

export const scene_bytes = () => readFileSync("tests/scenes/cornell-box/cornell-box.glb");

// {name: token}, and the file of their hashes; each name is its own tenant.
export const make_tokens = (build, names, role = "submitter") => {
    const file = join(folder("tokens"), "tokens.json"), token = {};
    for (const name of names)
        token[name] = execFileSync(join(build, "shearwater"), ["token", file, "--name", name, "--role", role], { encoding: "utf8" }).trim();
    chmodSync(file, 0o600);
    return { file, token };
};

// The service as one tenant asks it.
export class Tenant {
    constructor(service, token) { Object.assign(this, { service, headers: token ? { Authorization: `Bearer ${token}` } : {} }); }
    ask(method, path, body = null, headers = {}) { return this.service.ask(method, path, { body, headers: { ...this.headers, ...headers } }); }
    async json(path) { const a = await this.ask("GET", path); if (a.status !== 200) throw new Error(`${path}: ${a.status} ${a.body}`); return JSON.parse(a.body); }
    async put(bytes, digest) { return this.ask("PUT", `/v1/assets/${digest}`, bytes); }
    post(document, headers = {}) { return this.ask("POST", "/v1/jobs", JSON.stringify(document), { "Content-Type": "application/json", ...headers }); }
    // All of its jobs, page by page.
    async jobs() {
        const all = [];
        for (let next = null; ;) {
            const page = await this.json(`/v1/jobs?limit=100${next ? `&cursor=${encodeURIComponent(next)}` : ""}`);
            all.push(...page.jobs);
            if (!(next = page.next)) return all;
        }
    }
}

export const begin = async (build, name, settings) => {
    const service = new Service(build, join(folder(name), "data"), settings);
    await service.start();
    return service;
};

// Of a process and its threads: seconds of CPU; MB resident now, and at most.
export const cpu_s = (pid) => {
    const fields = readFileSync(`/proc/${pid}/stat`, "latin1").split(") ").at(-1).split(" ");
    return (Number(fields[11]) + Number(fields[12])) / 100;
};

// The same to the nanosecond, of the threads that there are: of the first one, of all others, and how long
// they were kept waiting for a CPU.
export const threads_s = (pid) => {
    const sum = { first_s: 0, others_s: 0, waited_s: 0, first_waited_s: 0 };
    let threads = [];
    try { threads = readdirSync(`/proc/${pid}/task`); } catch { /* it has ended: an importer, say */ }
    for (const thread of threads) {
        let text;
        try { text = readFileSync(`/proc/${pid}/task/${thread}/schedstat`, "latin1"); } catch { continue; /* it has ended */ }
        const [ran_ns, waited_ns] = text.split(" ").map(Number), first = Number(thread) === pid;
        sum[first ? "first_s" : "others_s"] += 1e-9 * ran_ns;
        sum.waited_s += 1e-9 * waited_ns;
        if (first) sum.first_waited_s += 1e-9 * waited_ns;
    }
    return sum;
};

// Of all CPUs: seconds that they were not idle, whoever had them; what a host took away counts.
export const machine_busy_s = () => {
    const [user, nice, system, , , irq, softirq, steal] = readFileSync("/proc/stat", "latin1").split("\n")[0].trim().split(/\s+/).slice(1).map(Number);
    return (user + nice + system + irq + softirq + steal) / 100;
};
const status_mb = (pid, name) => Number(new RegExp(`${name}:\\s+(\\d+)`).exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) / 1024;
export const resident_mb = (pid) => status_mb(pid, "VmRSS");
export const peak_mb = (pid) => status_mb(pid, "VmHWM");

export const quantile = (values, q) => {
    const sorted = Float64Array.from(values).sort();
    return sorted.length ? sorted[Math.min(sorted.length - 1, Math.ceil(q * sorted.length) - 1)] : NaN;
};
// [[share, value], ...] of a plot of how many are below what.
export const distribution = (values) => [0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99, 0.999, 1].map((q) => [q, quantile(values, q)]);

// `count` clients at once, until `work(i)` was called for all of 0 .. total - 1.
export const spread = async (total, count, work) => {
    let next = 0;
    const client = async () => { while (next < total) await work(next++); };
    await Promise.all(Array.from({ length: count }, client));
};
