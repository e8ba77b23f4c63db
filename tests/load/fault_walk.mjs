// One call fails, and no other: the k-th of its kind, for all k. What a program does is cut in stages, so that
// one coordinator serves many k where it may: only its start, its end and what it takes up after a kill need
// one each.
import { cpus } from "node:os";
import { cpSync } from "node:fs";
import { ECONNRESET, EIO, ENOBUFS, ENOMEM, ENOSPC, KINDS, Life, RECOVERY_S, name_of } from "./fault_life.mjs";
import { folder, join, seeded, sleep, until } from "./service.mjs";

const tiny = { image: { width: 32, height: 16 }, sampling: { spp: 4, tile_px: 16 }, layers: ["beauty", "direct", "indirect"] };
const half = { image: { width: 64, height: 64 }, sampling: { spp: 48, tile_px: 16 }, filter: { method: "none" } };
const errors_of = {
    write: [ENOSPC, EIO], fsync: [EIO, ENOSPC], rename: [EIO, ENOSPC], allocation: [ENOMEM], make: [ENOSPC, EIO],
    send: [ECONNRESET, ENOBUFS],
};

export const STAGES = [
    { name: "start", program: "shearwater" },   // to the first job's picture, but counted to its listening
    { name: "job", program: "shearwater", lasts: true },
    { name: "resume", program: "shearwater" },  // after a kill in the middle of a job
    { name: "end", program: "shearwater" },     // SIGTERM in the middle of a job
    { name: "job", program: "shearwater-import", lasts: true },
    { name: "all", program: "shearwater-worker" },
    { name: "far", program: "shearwater-worker", remote: true }, // over TCP, with a cache of its own
];
const title = (stage) => `${stage.program} ${stage.name}`;

export class Walk {
    constructor(build, want, note) {
        Object.assign(this, { build, want, note, random: seeded(want.seed), misses: [] });
        this.counts = { runs: 0, hit: 0, deaths: 0, worker_deaths: 0, refused: 0, slowest_s: 0 };
        this.stages = STAGES.filter((stage) => (!want.program || stage.program === want.program) && (!want.stage || stage.name === want.stage));
    }

    // ---- what an undisturbed life is ----

    life(stage) { return new Life(this.build, stage.program, { remote: stage.remote, template: this.takes_up(stage) ? this.template : null }); }
    takes_up(stage) { return stage.name === "resume" || stage.name === "end"; }

    async prepare() {
        const life = new Life(this.build, "nobody");
        await life.start();
        this.reference = await life.picture(await life.submit(tiny, "tiny"), 60 + this.want.patience);
        this.half_reference = await life.picture(await life.submit(half, "undisturbed"), 60 + this.want.patience);
        this.half_id = await life.submit(half, "half");
        await until(30 + this.want.patience, async () => (await life.service.job(this.half_id)).progress.tiles_done > 12, 2);
        await life.service.kill();
        this.template = join(folder("template"), "data");
        cpSync(life.service.data, this.template, { recursive: true, filter: (path) => !path.endsWith(".sock") });
        await life.drop();
        for (const stage of this.stages) {
            stage.calls = await this.count(stage);
            this.note(`${title(stage)}: ${KINDS.map((kind) => `${stage.calls[kind]} ${kind}s`).join(", ")}`);
        }
    }
    // Calls of each kind; the most of several, since they vary a little.
    async count(stage) {
        const most = Object.fromEntries(KINDS.map((kind) => [kind, 0]));
        const life = this.life(stage);
        await life.start();
        for (let round = 0; round < (stage.lasts ? 3 : 1); round++) {
            const before = life.control.all();
            const begun = stage.lasts ? before : {};
            await this.run(stage, life, { k: 0, round }, life.control);
            const after = stage.name === "start" ? before : this.at_end ?? life.control.all();
            this.at_end = null;
            for (const kind of KINDS) most[kind] = Math.max(most[kind], after[kind] - (begun[kind] ?? 0));
        }
        if (stage.name === "end") for (const kind of KINDS) most[kind] -= this.before_end[kind];
        if (life.service.is_up) await life.end();
        if (life.wrong.length) throw new Error(`${title(stage)}, undisturbed: ${life.wrong.join("; ")}`);
        return most;
    }

    // ---- one life, or one job of it ----

    // From a coordinator that listens to a picture that is the undisturbed one.
    async run(stage, life, point) {
        let digest;
        if (stage.name === "end") return this.run_end(stage, life, point);
        if (this.takes_up(stage)) {
            digest = await life.picture(this.half_id, 2 * RECOVERY_S + this.want.patience);
            this.at_end = life.control.all();
            if (digest !== this.half_reference) life.wrong.push("its picture is another one");
            return;
        }
        const id = await life.submit(tiny, `walk-${this.counts.runs}-${point.k}-${point.round ?? 0}`);
        digest = await life.picture(id, 2 * RECOVERY_S + this.want.patience);
        this.at_end = life.control.all();
        if (digest !== this.reference) life.wrong.push("its picture is another one");
        const jobs = JSON.parse((await life.persist(() => life.service.ask("GET", "/v1/jobs"))).body).jobs;
        if (jobs.length !== 1) life.wrong.push(`${jobs.length} jobs`);
        life.control.heal();
        if (!stage.lasts) return;
        await life.check_debris();
        await life.forget(id);
    }
    async run_end(stage, life, { kind, k, error }) {
        await sleep(30); // tiles are read again, and others traced
        const calls = life.control.all();
        if (k) life.control.fail(kind, calls[kind] + k, 1, error);
        else this.before_end = calls;
        const { code, signal } = await life.service.kill("SIGTERM");
        if (code !== 0) life.deaths++;
        if (signal && signal !== "SIGABRT" && signal !== "SIGTERM") life.wrong.push(`it ended with ${signal}`);
        this.at_end = life.control.all();
        life.control.heal();
        await life.start();
        const digest = await life.picture(this.half_id, 2 * RECOVERY_S + this.want.patience);
        if (digest !== this.half_reference) life.wrong.push("its picture is another one");
    }

    async try(lane, point) {
        const { stage, kind, k, error } = point, begin = performance.now();
        const what = `${title(stage)}: ${kind} ${k} of ${stage.calls[kind]} fails with ${name_of[error]}`;
        const life = lane.life ?? this.life(stage), deaths_before = life.deaths;
        lane.life = null;
        life.wrong = [];
        try {
            if (!stage.lasts && stage.name !== "end") life.control.fail(kind, k, 1, error);
            if (!life.service.is_up) await life.start();
            if (stage.lasts) life.control.fail(kind, life.control.calls(kind) + k, 1, error);
            const first = life.control.get(4 * KINDS.indexOf(kind) + 1);
            const at = performance.now();
            await this.run(stage, life, point);
            const seconds = (performance.now() - (stage.lasts ? at : begin)) / 1000;
            this.counts.slowest_s = Math.max(this.counts.slowest_s, seconds);
            if (seconds > RECOVERY_S + this.want.patience) life.wrong.push(`it took ${seconds.toFixed(1)} s`);
            this.counts.hit += stage.name === "end" || life.control.calls(kind) >= first;
            if (!stage.lasts) await life.end();
        } catch (e) {
            life.wrong.push(e.message);
            await life.drop();
        }
        this.counts.runs++;
        this.counts.deaths += life.deaths - deaths_before;
        this.counts.worker_deaths += life.worker_deaths ?? 0;
        this.counts.refused += [...life.statuses].filter(([status]) => status >= 500).reduce((sum, [, n]) => sum + n, 0);
        life.statuses.clear();
        if (life.deaths > deaths_before && process.env.FAULTS_SHOW_DEATHS) this.note(`${what}: died: ${life.home}`);
        for (const wrong of life.wrong) this.misses.push(`${what}: ${wrong}`);
        if (life.wrong.length) this.note(`${what}: ${life.wrong.join("; ")}`);
        if (stage.lasts && !life.wrong.length) lane.life = life;
        else if (stage.lasts) await life.drop();
    }

    // ---- all of them ----

    points(stage) {
        const points = [], { want } = this;
        for (const kind of KINDS) {
            if (want.kind && want.kind !== kind) continue;
            const all = Array.from({ length: stage.calls[kind] }, (_, i) => i + 1)
                .flatMap((k) => errors_of[kind].map((error) => ({ stage, kind, k, error })));
            // A fair share of each kind, so that the few writes are not lost among the allocations.
            // Files that could not be opened when it starts stay so for long: all of these.
            const share = want.sample && !(stage.name === "resume" && kind === "make") ? Math.ceil(want.sample / (KINDS.length * STAGES.length)) : all.length;
            while (all.length > share) all.splice(this.random(all.length), 1);
            points.push(...all.filter((point) => (!want.at || point.k === want.at) && point.k >= want.from && (!want.to || point.k <= want.to)));
        }
        return points;
    }
    async walk() {
        for (const stage of this.stages) {
            const points = this.points(stage), begin = performance.now();
            let next = 0;
            const go = async () => {
                const lane = { life: null };
                while (next < points.length) {
                    await this.try(lane, points[next++]);
                    if (next % 500 === 0) this.note(`${title(stage)}: ${next} of ${points.length}`);
                }
                if (lane.life) await lane.life.end();
            };
            await Promise.all(Array.from({ length: Math.min(this.want.lanes, points.length) }, go));
            this.note(`${title(stage)}: ${points.length} faults in ${((performance.now() - begin) / 1000).toFixed(0)} s`);
        }
        const { runs, hit, deaths, worker_deaths, refused, slowest_s } = this.counts;
        this.note(`${runs} faults, of which ${hit} came: ${deaths} deaths of coordinators, ${worker_deaths} of far workers, ` +
            `${refused} requests refused for a while, ${slowest_s.toFixed(1)} s to the picture at most, ${cpus().length} cores`);
        return { ok: runs > 0 && this.misses.length === 0 && hit > 0.9 * runs, runs, hit };
    }
}
