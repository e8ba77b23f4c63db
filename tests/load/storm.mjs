// A storm of kills over a coordinator at work: whatever dies, what was accepted is done, once, and the
// files are those of undisturbed jobs.
//   node tests/load/storm.mjs BUILD_DIR [kills=50] [seed=N] [workers=2] [pause_ms=300]
// Kinds of victims, drawn by the seed: the coordinator; a worker; an importer, caught while it runs; a
// writer: the coordinator again, but caught while a picture's file lies half-written in its folder. The
// only thing that is done by hand is what a supervisor does: a coordinator that died is started again.
// Submissions go on meanwhile, each with an Idempotency-Key; one whose answer was cut off is sent again
// until it is answered, and some that were answered are, too.
import { Service, check, children_of, done, figure, folder, join, marked_scene, note, options, readFileSync, readdirSync, seeded, sha256, sleep, until } from "./service.mjs";

const build = process.argv[2];
const want = options({ kills: 50, seed: Math.floor(Date.now() / 1000) % 1000000, workers: 2, pause_ms: 300 });
note(`seed ${want.seed}: tests/load/storm.mjs ${build} kills=${want.kills} seed=${want.seed} deals the same kinds of kills and jobs`);
const random = seeded(want.seed), random_job = seeded(want.seed + 1), one_of = (list, number = random) => list[number(list.length)];
const service = new Service(build, join(folder("storm"), "data"), { workers: want.workers });
const glb = readFileSync("tests/scenes/cornell-box/cornell-box.glb");

// What frames are made of: passes, filters, second sets, rounds, several frames, little and much work.
const image = (px) => ({ width: px, height: px });
const kinds = {
    passes: { image: image(192), sampling: { spp: 64, tile_px: 32 }, filter: { method: "none" } },
    filtered: { image: image(192), sampling: { spp: 16, tile_px: 32 }, effects: { indirect_bounces: 2 } },
    adaptive: { image: image(128), sampling: { spp: 16, tile_px: 32 }, effects: { indirect_bounces: 2 }, filter: { indirect: "adaptive" } },
    target: { image: image(128), sampling: { spp: 16, tile_px: 32, target_error: 0.04, max_spp: 256 }, filter: { method: "none" } },
    lens: { image: image(96), sampling: { spp: 16, tile_px: 32, lens_extra: 4 }, lens: { aperture_radius: 0.1, focus_distance: 6 }, effects: { indirect_bounces: 2 } },
    frames: { image: image(128), sampling: { spp: 16, tile_px: 32 }, frames: { first: 1, last: 3 } },
    large: { image: image(400), sampling: { spp: 9 }, layers: ["beauty", "direct", "indirect", "albedo", "normal", "depth"] },
};
const imported = { image: image(64), sampling: { spp: 4, tile_px: 32 } }; // of a scene that is new
kinds.imported = imported;
const frames_of = (kind) => kinds[kind].frames?.last ?? 1;

// ---- pictures ----

// What the digests of a job's pictures are; null while one cannot be had. A frame's file does not tell
// which asset its scene came from: the fingerprint in it does, so each scene has an undisturbed job.
const pictures = async (id, kind) => {
    const out = [];
    for (let frame = 1; frame <= frames_of(kind); frame++)
        for (const form of ["exr", "png"]) {
            const bytes = await service.picture(id, form, frame);
            if (!bytes) return null;
            out.push(sha256(bytes));
        }
    return out.join(" ");
};
const finished = async (id, seconds) => until(seconds, async () => {
    const state = await service.job(id).then((job) => job?.state, () => null);
    return ["finished", "failed", "cancelled"].includes(state) ? state : null;
}, 50);

// ---- submissions that do not give up ----

const jobs = []; // {key, kind, id, ids: all that were ever answered for the key}
let retries = 0, repeats = 0;
const persist = async (ask) => {
    for (;;) {
        const answer = await ask().catch(() => null);
        if (answer && answer.status < 500) return answer;
        retries++;
        await sleep(50);
    }
};
const submit = async (kind, asset, key) => {
    const document = { scene: { asset }, ...kinds[kind] };
    const answer = await persist(() => service.post(document, key));
    if (answer.status !== 202) throw new Error(`${kind}: ${answer.status} ${answer.body}`);
    return JSON.parse(answer.body).id;
};
const upload = async (bytes) => {
    const answer = await persist(() => service.put(bytes));
    if (answer.status >= 300) throw new Error(`asset: ${answer.status} ${answer.body}`);
    return sha256(bytes);
};

let raining = true, sent = 0, import_wanted = false;
const marks = new Set(); // numbers of the submissions that came with a scene of their own
const scenes = []; // digests; a new one, which is imported anew, when an importer is wanted
const rain = async () => {
    while (raining) {
        const open = jobs.filter((job) => !job.over).length;
        if (open >= 6 && !import_wanted) { await sleep(10); continue; }
        const n = sent++;
        const is_new = n === 0 || import_wanted;
        import_wanted = false;
        if (is_new) marks.add(n);
        if (is_new) scenes.push(await upload(marked_scene(glb, `storm ${want.seed} ${n}`)));
        const kind = is_new ? "imported" : one_of(Object.keys(kinds), random_job), asset = scenes[is_new ? scenes.length - 1 : 0], key = `storm-${n}`;
        const job = { key, kind, asset, ids: new Set(), over: false };
        job.ids.add(await submit(kind, asset, key));
        if (n % 4 === 1) { repeats++; job.ids.add(await submit(kind, asset, key)); }
        job.id = [...job.ids][0];
        jobs.push(job);
        finished(job.id, 600).then((state) => { job.over = true; job.state = state; });
    }
};

// ---- kills ----

const killed = { coordinator: 0, worker: 0, importer: 0, writer: 0 }, restarts = [];
const restart = async () => {
    await service.ended;
    const begin = performance.now();
    await service.start();
    await until(10, () => service.ask("GET", "/livez").then((a) => a.status === 200, () => false), 5);
    restarts.push(performance.now() - begin);
};
const child_named = (name) => children_of(service.pid).filter((child) => child.name.startsWith(name)); // names have 15 bytes
const is_writing = () => {
    try {
        return readdirSync(join(service.data, "tmp")).some((dir) =>
            dir.startsWith("dir-") && readdirSync(join(service.data, "tmp", dir)).some((file) => file.includes("image.exr")));
    } catch { return false; }
};
// They are there for milliseconds.
const catch_it = (seconds, look) => until(seconds, look, 1);
const kill = async (kind) => {
    if (kind === "worker") {
        const victim = await until(10, () => one_of(child_named("shearwater-work").length ? child_named("shearwater-work") : [null]));
        if (!victim) return false;
        process.kill(victim.pid, "SIGKILL");
    } else if (kind === "importer") {
        import_wanted = true;
        const victim = await catch_it(4, () => child_named("shearwater-impo")[0]);
        import_wanted = false;
        if (!victim) return false;
        try { process.kill(victim.pid, "SIGKILL"); } catch { return false; }
    } else {
        if (kind === "writer" && !await catch_it(4, is_writing)) return false;
        service.child.kill("SIGKILL");
        await restart();
    }
    killed[kind]++;
    return true;
};
const storm = async () => {
    for (let n = 0; n < want.kills;) {
        await sleep(random(want.pause_ms));
        const kind = one_of(["coordinator", "coordinator", "worker", "worker", "importer", "writer"]);
        n += await kill(kind);
    }
};

// ---- the story ----

await service.start();
const raindrops = rain();
const begin = performance.now();
await storm();
raining = false;
await raindrops;
note(`${want.kills} kills in ${((performance.now() - begin) / 1000).toFixed(0)} s: ${Object.entries(killed).map(([k, n]) => `${n} of ${k}`).join(", ")}`);
const all_over = await until(300, () => jobs.every((job) => job.over), 100); // however busy the machine is
check(`all ${jobs.length} accepted jobs are finished`, all_over && jobs.every((job) => job.state === "finished"),
    jobs.filter((job) => job.state !== "finished").map((job) => `${job.id} ${job.kind} ${job.state}`).join("\n"));
check(`none is done twice: a key is one job, ${repeats} sent again though answered, ${retries} sent again unanswered`, jobs.every((job) => job.ids.size === 1));
const listed = [];
for (let cursor = ""; cursor !== null;) {
    const page = await service.json(`/v1/jobs?limit=100${cursor && `&cursor=${cursor}`}`);
    listed.push(...page.jobs.map((job) => job.id));
    cursor = page.next;
}
check("... and the listing has these and no others", listed.length === jobs.length && jobs.every((job) => listed.includes(job.id)), `${listed.length} listed`);

let traced = 0, planned = 0, resumed = 0;
const without_cost = [];
for (const job of jobs) {
    const { statistics, progress } = await service.job(job.id);
    if (!(statistics?.tiles.done > 0)) without_cost.push(`${job.id} ${job.kind}`);
    traced += (statistics?.tiles.done ?? 0) - (statistics?.tiles.resumed ?? 0);
    resumed += statistics?.tiles.resumed ?? 0;
    planned += progress.tiles_total;
    job.pictures = await pictures(job.id, job.kind);
}
check("all tell what they cost", without_cost.length === 0, without_cost.join("\n"));
note(`${resumed} of ${planned} tiles taken from disk by the run that ended their frame, ${traced} traced by it`);
note(`restarts: ${restarts.length}, ${Math.max(0, ...restarts).toFixed(0)} ms at most, ${(restarts.reduce((a, b) => a + b, 0) / (restarts.length || 1)).toFixed(0)} ms in the mean`);
figure("a restart takes 2 s at most", Math.max(0, ...restarts) <= 2000);
check("tiles were taken from disk", resumed > 0 || killed.coordinator + killed.writer < 5);

// Undisturbed: the same documents once more, in a folder where nothing is left of before.
await service.kill("SIGTERM");
const debris = readdirSync(join(service.data, "tmp")), spools = readdirSync(join(service.data, "spool"));
check("nothing half-written is left", debris.length === 0, debris.join("\n"));
check("... and no spool", spools.length === 0, spools.join("\n"));
const calm = new Service(build, join(folder("calm"), "data"), { workers: want.workers });
Object.assign(service, { data: calm.data });
await service.start();
const by_scene = new Map();
for (const job of jobs) by_scene.set(`${job.kind} ${job.asset}`, job);
const assets = new Set(jobs.map((job) => job.asset));
for (const n of marks) {
    const bytes = marked_scene(glb, `storm ${want.seed} ${n}`);
    if (assets.has(sha256(bytes))) await upload(bytes);
}
const references = new Map();
for (const [name, job] of by_scene) references.set(name, await submit(job.kind, job.asset, `calm-${job.key}`));
let equal = 0;
const others = [];
for (const [name, id] of references) {
    const state = await finished(id, 120), wanted = state === "finished" ? await pictures(id, by_scene.get(name).kind) : null;
    for (const job of jobs.filter((j) => `${j.kind} ${j.asset}` === name))
        if (wanted && job.pictures === wanted) equal++;
        else others.push(`${job.id} ${job.kind}`);
}
check(`every result is byte-equal to the undisturbed one (${equal} jobs)`, equal === jobs.length, others.join("\n"));
await service.kill("SIGTERM");
done();
