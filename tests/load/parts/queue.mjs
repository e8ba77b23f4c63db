// Submissions that are durable when they are answered, a second; then pages of 100 rows of the long queue
// that they make, and the coordinator's memory.
import { check, figure, note, sha256 } from "../service.mjs";
import { Tenant, begin, cpu_s, distribution, peak_mb, quantile, resident_mb, scene_bytes, spread } from "./clients.mjs";

export const defaults = { queue_jobs: 10000, queue_clients: 64, queue_pages: 1000, submit_min: 200, page_p99_ms: 20, memory_mb: 256 };

const document_of = (asset, i) => ({
    scene: { asset }, image: { width: 320 + i % 7, height: 240 }, sampling: { spp: 16, seed: i },
    effects: { indirect_bounces: 2 }, priority: i % 5, layers: ["beauty", "direct", "indirect", "albedo", "normal", "depth"],
});

const submit = async (tenant, asset, want) => {
    const begun = performance.now(), ms = [], points = [];
    let accepted = 0;
    await spread(want.queue_jobs, want.queue_clients, async (i) => {
        const from = performance.now(), answer = await tenant.post(document_of(asset, i), { "Idempotency-Key": `load-${i}` });
        ms.push(performance.now() - from);
        accepted += answer.status === 202;
        if (accepted % Math.ceil(want.queue_jobs / 20) === 0) points.push([accepted, 1000 * accepted / (performance.now() - begun)]);
    });
    return { accepted, rate: 1000 * want.queue_jobs / (performance.now() - begun), ms, points };
};

// Every page there is, from the newest to the oldest and again; one at a time, as a viewer asks.
const read_pages = async (tenant, count) => {
    const ms = [], seen = new Set();
    let rows = 0, next = null;
    for (let i = 0; i < count; i++) {
        const from = performance.now(), page = await tenant.json(`/v1/jobs?limit=100${next ? `&cursor=${next}` : ""}`);
        ms.push(performance.now() - from);
        rows += page.jobs.length;
        for (const job of page.jobs) seen.add(job.id);
        next = page.next;
    }
    return { ms, rows, seen: seen.size };
};

export const run = async (build, want) => {
    const service = await begin(build, "queue", { workers: 0 }), tenant = new Tenant(service), scene = scene_bytes(), asset = sha256(scene);
    await tenant.put(scene, asset);
    const taken = await submit(tenant, asset, want), submit_cpu_s = cpu_s(service.pid), first_mb = peak_mb(service.pid);
    check(`${want.queue_jobs} jobs are accepted`, taken.accepted === want.queue_jobs, `${taken.accepted}`);
    figure(`... at least ${want.submit_min} a second: ${taken.rate.toFixed(0)}`, taken.rate >= want.submit_min);
    // Durable: a kill right after the last answer loses none.
    await service.kill();
    await service.start();
    const metrics = String((await service.ask("GET", "/metrics")).body);
    const waiting = ["queued", "importing", "running"].reduce((sum, state) => sum + Number(metrics.split(`shearwater_jobs{state="${state}"} `)[1]?.split("\n")[0]), 0);
    check("... and a kill after the last answer loses none", waiting === want.queue_jobs, `${waiting}`);
    const pages = await read_pages(tenant, want.queue_pages), p99 = quantile(pages.ms, 0.99), mb = Math.max(first_mb, peak_mb(service.pid));
    check("pages are full", pages.rows === 100 * want.queue_pages && pages.seen === Math.min(want.queue_jobs, 100 * want.queue_pages), `${pages.rows} rows, ${pages.seen} jobs`);
    figure(`pages of 100 rows take at most ${want.page_p99_ms} ms in 99 of 100: ${p99.toFixed(1)} ms`, p99 <= want.page_p99_ms);
    figure(`the coordinator's memory stays below ${want.memory_mb} MB: ${mb.toFixed(0)} MB at most`, mb < want.memory_mb);
    note(`submitting took ${submit_cpu_s.toFixed(1)} s of its CPU; ${resident_mb(service.pid).toFixed(0)} MB resident now`);
    await service.kill();
    return {
        figures: { jobs: want.queue_jobs, submissions_per_s: taken.rate, submission_p99_ms: quantile(taken.ms, 0.99), page_p50_ms: quantile(pages.ms, 0.5), page_p99_ms: p99, peak_mb: mb },
        plots: [
            { title: "Durable submissions", xLabel: "jobs queued", yLabel: "a second, since the first", xLog: false, yLog: false, series: [{ name: "rate", points: taken.points }] },
            { title: "How long a page of 100 rows takes", xLabel: "share of the pages", yLabel: "ms", xLog: false, series: [{ name: "at most", points: distribution(pages.ms) }] },
        ],
    };
};
