// Many who watch one job: viewers of its events and feeds of its pixels, some of which never read. The same
// job is rendered without them and with them, in turn, on as many workers as the machine has threads for.
//
// What watching costs is paid by the second, so that it is told as the share of the machine's threads that is
// taken from rendering while a picture is made: `service` is what the coordinator's CPU time grows by, over all
// CPU time that passes meanwhile; `clients` what those who watch take themselves, here on the same machine. The
// clock's time is told too; it has in it both of these, and whatever else runs.
import { spawn } from "node:child_process";
import { availableParallelism } from "node:os";
import { createInterface } from "node:readline";
import { check, join, note, sha256, sleep, until } from "../service.mjs";
import { begin, cpu_s, scene_bytes } from "./clients.mjs";

export const defaults = {
    watch_viewers: 1000, watch_feeds: 200, watch_stuck: 20, watch_spp: 144, watch_width: 1280, watch_height: 720,
    watch_pairs: 3, watch_slower: 0.05, event_p99_ms: 500, watch_poke_ms: 2000, watch_stuck_ms: 3000,
};

const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];

const document_of = (asset, want) => ({
    scene: { asset }, image: { width: want.watch_width, height: want.watch_height }, sampling: { spp: want.watch_spp, tile_px: 64 },
    filter: { method: "none" }, effects: { indirect_bounces: 2 },
});

// The job waits until all who watch are there.
const submit_paused = async (service, asset, want) => {
    const id = JSON.parse((await service.post(document_of(asset, want))).body).id;
    const patch = async (members) => (await service.ask("PATCH", `/v1/jobs/${id}`, { body: JSON.stringify(members), headers: { "Content-Type": "application/json" } })).status;
    const paused = await patch({ paused: true });
    if (paused !== 200) throw new Error(`the job was not paused: ${paused}`);
    return { id, resume: () => patch({ paused: false }) };
};

const watch = async (build, service, id, arguments_) => {
    const child = spawn(join(build, "tests/load/watchers"), [`port=${service.port}`, `job=${id}`, ...arguments_], { stdio: ["pipe", "pipe", "inherit"] });
    const lines = createInterface(child.stdout)[Symbol.asyncIterator]();
    const next = async () => { const line = await lines.next(); if (line.done) throw new Error("the watchers have failed"); return line.value; };
    await next(); // all are there
    const seen = next().then(JSON.parse);
    seen.catch(() => {}); // thrown where it is awaited
    return { seen, leave: () => child.stdin.end() };
};

// One render; `watched`: the arguments of who watches, or null.
const render = async (build, service, asset, want, watched) => {
    const { id, resume } = await submit_paused(service, asset, want);
    const watching = watched ? await watch(build, service, id, watched) : null;
    const before = cpu_s(service.pid), begun = performance.now();
    await resume();
    let state;
    do { await sleep(50); state = (await service.job(id)).state; } while (state === "running" || state === "queued" || state === "importing");
    const wall_s = (performance.now() - begun) / 1000;
    const service_s = cpu_s(service.pid) - before; // what is sent behind the end slows nothing
    return { wall_s, service_s, state, seen: watching ? await watching.seen : null, leave: watching?.leave };
};

const cut_pixels = async (service) => (await service.metrics('shearwater_stream_readers_cut_total{kind="pixels"}'))[0];

// Notes the figures of renders with one kind of crowd, and checks them.
const judge = (name, renders, figures, want) => {
    const of = (value) => median(renders.map(value)), cores = availableParallelism(), all_s = (r) => r.wall_s * cores;
    const service = of((r) => (r.service_s - figures.alone_service_cpu_s) / all_s(r)), clients = of((r) => r.seen.cpu_s / all_s(r));
    const spread = of((r) => r.seen.spread_p99_ms), poke = of((r) => r.seen.poke_p99_ms), wall = of((r) => r.wall_s) / figures.alone_wall_s - 1;
    const everybody = renders.every((r) => r.seen.told_of_the_end === want.watch_viewers && r.state === "finished");
    Object.assign(figures, { [`${name}_service_share`]: service, [`${name}_clients_share`]: clients, [`${name}_wall_slower`]: wall, [`${name}_event_p99_ms`]: Math.max(spread, poke) });
    check(`${name}: all ${want.watch_viewers} are told of the end`, everybody, renders.map((r) => r.seen.told_of_the_end).join());
    check(`${name}: the service takes at most ${100 * want.watch_slower} % of the machine from rendering: ${(100 * service).toFixed(1)} %`, service <= want.watch_slower);
    check(`${name}: 99 of 100 events come within ${want.event_p99_ms} ms of the first reader's (${spread.toFixed(0)} ms) and of their cause (${poke.toFixed(0)} ms)`, Math.max(spread, poke) <= want.event_p99_ms);
    note(`${name}: by the clock ${(100 * wall).toFixed(1)} % slower; the clients take ${(100 * clients).toFixed(1)} % of the machine`);
    if (name !== "feeds") return;
    Object.assign(figures, { feed_pictures: of((r) => r.seen.pictures), feed_mb: of((r) => r.seen.feed_mb) });
    check(`all ${want.watch_feeds} feeds end with the whole picture`, renders.every((r) => r.seen.feeds_whole === want.watch_feeds), renders.map((r) => r.seen.feeds_whole).join());
    check("... with the pixels of the finished one", renders.every((r) => r.seen.compared > 0 && r.seen.same === r.seen.compared), renders.map((r) => `${r.seen.same} of ${r.seen.compared}`).join());
};

export const run = async (build, want) => {
    const service = await begin(build, "viewers", { workers: 4, environment: { SHEARWATER_STUCK_MS: String(want.watch_stuck_ms) } }), scene = scene_bytes(), asset = sha256(scene);
    await service.put(scene);
    const crowd = [`viewers=${want.watch_viewers}`, `poke_ms=${want.watch_poke_ms}`], crowds = {
        viewers: crowd, feeds: [...crowd, `feeds=${want.watch_feeds}`, `stuck=${want.watch_stuck}`],
    };
    await render(build, service, asset, want, null); // imports the scene, warms the workers
    const alone = [], watched = { viewers: [], feeds: [] };
    for (let i = 0; i < want.watch_pairs; i++) {
        alone.push(await render(build, service, asset, want, null));
        for (const [name, arguments_] of Object.entries(crowds)) watched[name].push(await render(build, service, asset, want, arguments_));
    }
    const figures = { alone_wall_s: median(alone.map((r) => r.wall_s)), alone_service_cpu_s: median(alone.map((r) => r.service_s)) };
    for (const [name, renders] of Object.entries(watched)) judge(name, renders, figures, want);
    // Those that never read: of pixels, as their sockets fill at once; events are few and fit into theirs.
    const cut = await until(20, async () => (await cut_pixels(service)) >= want.watch_stuck * want.watch_pairs);
    check(`each of the ${want.watch_stuck} feeds that never read is cut, and counted`, cut, `${await cut_pixels(service)}`);
    for (const renders of Object.values(watched)) for (const r of renders) r.leave();
    const [made, sent] = await service.metrics("shearwater_feed_blocks_made_total", "shearwater_feed_blocks_sent_total");
    check("blocks are made once for all feeds", want.watch_feeds < 10 || sent >= want.watch_feeds / 2 * made, `${made} made, ${sent} sent`);
    await service.kill();
    return { figures: { ...figures, blocks_made: made, blocks_sent: sent }, plots: [] };
};
