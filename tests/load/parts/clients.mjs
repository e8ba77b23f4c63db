// What the parts of the load test share: tenants with tokens, figures of processes, quantiles.
import { execFileSync } from "node:child_process";
import { chmodSync } from "node:fs";
import { Service, folder, join, readFileSync } from "../service.mjs";

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
