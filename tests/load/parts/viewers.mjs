// Many who watch one job: viewers of its events and feeds of its pixels, some of which never read. The same
// job is rendered without them and with them, in turn, on as many workers as the machine has threads for.
//
// What watching costs is paid by the second, so that it is told as the share of the machine's threads that is
// taken from rendering while a picture is made. `service` is what the coordinator takes more of them than when
// nobody watches, which is bounded here; `serve --stream-share` bounds the part of it that the loop counts for
// streams. `clients` is what those who watch take, who are on the same machine only here, `others` what runs on
// it besides. The clock's time is told, too: all three are in it, and on a machine that is not quiet it says
// little. All of it is measured from when the job goes on until it has ended.
import { spawn } from "node:child_process";
import { request } from "node:http";
import { availableParallelism } from "node:os";
import { createInterface } from "node:readline";
import { check, children_of, figure, join, note, sha256, sleep, until } from "../service.mjs";
import { begin, machine_busy_s, scene_bytes, threads_s } from "./clients.mjs";

export const defaults = {
    watch_viewers: 1000, watch_feeds: 200, watch_stuck: 20, watch_spp: 144, watch_width: 1280, watch_height: 720,
    watch_pairs: 3, watch_slower: 0.05, event_p99_ms: 500, watch_poke_ms: 2000, watch_stuck_ms: 3000,
    watch_share: 3, watch_feed_rate: 24, // serve --stream-share, --feed-rate
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
    return { pid: child.pid, seen, leave: () => child.stdin.end() };
};

// CPU seconds of everybody's, up to now.
const spent = (service, watching) => {
    const own = threads_s(service.pid), workers = children_of(service.pid).map((child) => threads_s(child.pid));
    const clients = watching ? threads_s(watching.pid) : { first_s: 0, waited_s: 0 }, script = process.cpuUsage();
    return {
        machine: machine_busy_s(), service: own.first_s + own.others_s, loop: own.first_s, loop_waited: own.first_waited_s, threads: own.others_s,
        workers: workers.reduce((sum, w) => sum + w.first_s + w.others_s, 0), clients: clients.first_s, clients_waited: clients.waited_s,
        script: 1e-6 * (script.user + script.system),
    };
};

// Calls `ended` when the job's events tell its end; resolves with its last state.
const follow = (service, id, ended) => new Promise((resolve, reject) => {
    const r = request({ host: "127.0.0.1", port: service.port, path: `/v1/jobs/${id}/events` }, (answer) => {
        let text = "", state = null;
        answer.on("data", (piece) => {
            text += piece;
            state ??= /^data: {"state":"(finished|failed|cancelled)"/m.exec(text)?.[1];
            if (state) { ended(); ended = () => {}; }
            text = text.slice(text.lastIndexOf("\n\n") + 1);
        });
        answer.on("end", () => resolve(state));
        answer.on("error", reject);
    });
    r.on("error", reject);
    r.end();
});

// What the service itself says that its streams take: a part of its first thread's time.
const streams_s = (service) => service.metrics(...["events", "pixels"].map((kind) => `shearwater_stream_cpu_seconds_total{kind="${kind}"}`));

// Asked for until `done()`: then the last answer from before.
const streams_until = async (service, done) => {
    for (let last = [0, 0]; ; await sleep(250)) {
        const now = await streams_s(service);
        if (done()) return last;
        last = now;
    }
};

// One render; `watched`: the arguments of who watches, or null. cpu: seconds while the picture was made; what is
// sent behind the end slows nothing.
const render = async (build, service, asset, want, watched) => {
    const { id, resume } = await submit_paused(service, asset, want);
    const watching = watched ? await watch(build, service, id, watched) : null;
    const streams = await streams_s(service), before = spent(service, watching), begun = performance.now();
    let wall_s = 0, after = null;
    const ended = follow(service, id, () => {
        wall_s = (performance.now() - begun) / 1000;
        after = spent(service, watching);
    });
    await resume();
    const streams_after = streams_until(service, () => after), state = await ended;
    const [events, pixels] = (await streams_after).map((s, i) => Math.max(0, s - streams[i]));
    const cpu = { events, pixels, ...Object.fromEntries(Object.keys(after).map((name) => [name, after[name] - before[name]])) };
    cpu.others = Math.max(0, cpu.machine - cpu.service - cpu.workers - cpu.clients - cpu.script);
    return { wall_s, cpu, state, seen: watching ? await watching.seen : null, leave: watching?.leave };
};

const cut_pixels = async (service) => (await service.metrics('shearwater_stream_readers_cut_total{kind="pixels"}'))[0];

const percent = (share) => `${(100 * share).toFixed(1)} %`;

// Notes the figures of renders with one kind of crowd, and checks them.
const judge = (name, renders, alone, figures, notes, want) => {
    const of = (value) => median(renders.map(value)), machine_s = (r) => r.wall_s * availableParallelism();
    const usual = (part) => median(alone.map((r) => r.cpu[part])), more = (part) => of((r) => (r.cpu[part] - usual(part)) / machine_s(r));
    const share = (part) => of((r) => r.cpu[part] / machine_s(r));
    const service = more("service"), clients = share("clients"), wall = of((r) => r.wall_s) / median(alone.map((r) => r.wall_s)) - 1;
    const spread = of((r) => r.seen.spread_p99_ms), poke = of((r) => r.seen.poke_p99_ms), others = Math.max(...renders.concat(alone).map((r) => r.cpu.others / machine_s(r)));
    const everybody = renders.every((r) => r.seen.told_of_the_end === want.watch_viewers && r.state === "finished");
    const told = {
        service_share: service, loop_share: more("loop"), threads_share: more("threads"), events_share: share("events"), pixels_share: share("pixels"),
        clients_share: clients, others_share: others, wall_slower: wall, event_spread_p99_ms: spread, event_p99_ms: Math.max(spread, poke),
        loop_waited_s: of((r) => r.cpu.loop_waited), clients_waited_s: of((r) => r.cpu.clients_waited), workers_cpu_s: of((r) => r.cpu.workers),
    };
    for (const [figure, value] of Object.entries(told)) figures[`${name}_${figure}`] = value;
    check(`${name}: all ${want.watch_viewers} are told of the end`, everybody, renders.map((r) => r.seen.told_of_the_end).join());
    figure(`${name}: the service takes at most ${100 * want.watch_slower} % of the machine from rendering: ${percent(service)}`, service <= want.watch_slower);
    figure(`${name}: 99 of 100 events come within ${want.event_p99_ms} ms of the first reader's (${spread.toFixed(0)} ms) and of their cause (${poke.toFixed(0)} ms)`, Math.max(spread, poke) <= want.event_p99_ms);
    // A quarter of a second's time is saved up before, and one round of events may be owed behind the end.
    const most_s = (r) => want.watch_share / 100 * availableParallelism() * (r.wall_s + 0.25) * 1.1 + 3e-5 * want.watch_viewers;
    figure(`${name}: by its own count streams keep to --stream-share ${want.watch_share}: ${percent(told.events_share + told.pixels_share)}`, want.watch_share === 0 || renders.every((r) => r.cpu.events + r.cpu.pixels <= most_s(r)));
    const said = [
        `${name}: the service takes ${percent(service)} of the machine from rendering: its loop ${percent(told.loop_share)} (by its own count ${percent(told.events_share)} for events, ${percent(told.pixels_share)} for pixels), its other threads ${percent(told.threads_share)}. The clients take ${percent(clients)}.`,
        `${name}: by the clock ${percent(wall)} slower, with other programs on up to ${percent(others)} of the machine, and with the clients on it. Workers take ${told.workers_cpu_s.toFixed(2)} s of CPU, ${usual("workers").toFixed(2)} s when nobody watches.`,
        `${name}: the loop was kept waiting for a CPU for ${told.loop_waited_s.toFixed(2)} s, the clients for ${told.clients_waited_s.toFixed(2)} s: that is in the events' delays.`,
    ];
    for (const text of said) note(text);
    notes.push(...said);
    if (name !== "feeds") return;
    Object.assign(figures, { feed_pictures: of((r) => r.seen.pictures), feed_mb: of((r) => r.seen.feed_mb) });
    check(`all ${want.watch_feeds} feeds end with the whole picture`, renders.every((r) => r.seen.feeds_whole === want.watch_feeds), renders.map((r) => r.seen.feeds_whole).join());
    check("... with the pixels of the finished one", renders.every((r) => r.seen.compared > 0 && r.seen.same === r.seen.compared), renders.map((r) => `${r.seen.same} of ${r.seen.compared}`).join());
};

export const run = async (build, want) => {
    const service = await begin(build, "viewers", {
        workers: 4, environment: { SHEARWATER_STUCK_MS: String(want.watch_stuck_ms) },
        args: ["--stream-share", String(want.watch_share), "--feed-rate", String(want.watch_feed_rate)],
    }), scene = scene_bytes(), asset = sha256(scene);
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
    const notes = [], figures = { alone_wall_s: median(alone.map((r) => r.wall_s)), alone_service_cpu_s: median(alone.map((r) => r.cpu.service)), alone_workers_cpu_s: median(alone.map((r) => r.cpu.workers)) };
    for (const [name, renders] of Object.entries(watched)) judge(name, renders, alone, figures, notes, want);
    // Those that never read: of pixels, as their sockets fill at once; events are few and fit into theirs.
    const cut = await until(20, async () => (await cut_pixels(service)) >= want.watch_stuck * want.watch_pairs);
    check(`each of the ${want.watch_stuck} feeds that never read is cut, and counted`, cut, `${await cut_pixels(service)}`);
    for (const renders of Object.values(watched)) for (const r of renders) r.leave();
    const [made, sent] = await service.metrics("shearwater_feed_blocks_made_total", "shearwater_feed_blocks_sent_total");
    check("blocks are made once for all feeds", want.watch_feeds < 10 || sent >= want.watch_feeds / 2 * made, `${made} made, ${sent} sent`);
    await service.kill();
    return { figures: { ...figures, blocks_made: made, blocks_sent: sent }, plots: [], notes };
};
