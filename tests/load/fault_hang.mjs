// A disk that hangs: every fsync begins and does not end; or every write, or making of a file, under uploads. It is
// told of, nobody waits for it for ever, who asks again and again fills no memory, and when it goes on all that
// was accepted, or may have been, is done once.
import { Agent, request } from "node:http";
import { Life, RECOVERY_S, scene } from "./fault_life.mjs";
import { check, note, readFileSync, sha256, sleep, slower, until } from "./service.mjs";

const ANSWER_MS = 2000, ROOM = 2048; // SHEARWATER_ANSWER_MS; requests that may wait (server/http/pending.h)
const LATE_MS = 1500;                // of a machine that has other things to do
const READY_MS = 2000 + 1000;        // what readiness.h waits for, and for how long it believes what it found

const problem = ({ status, headers, body }, slug) =>
    status === 503 && headers["retry-after"] > 0 && headers["content-type"] === "application/problem+json" && String(body).includes(`:problem:${slug}"`);
const shown = ({ status, body, message }) => message ?? `${status} ${body}`;
const timed = async (ask) => {
    const begin = performance.now(), answer = await ask().catch((e) => e);
    return { ...answer, message: answer.message, ms: performance.now() - begin };
};
const rss_mb = (pid) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) / 1024;

// One connection's request; the status, or 0 when it broke.
const get_alone = (port, path, agent) => new Promise((resolve) => {
    const r = request({ host: "127.0.0.1", port, path, agent }, (answer) => { answer.resume(); answer.on("end", () => resolve(answer.statusCode)); });
    r.on("error", () => resolve(0));
    r.end();
});

// Waits for what is due, while somebody looks at /livez all the time. Gives the slowest look in ms.
const watch_livez = (service) => {
    let on = true, slowest_ms = 0, all_ok = true;
    const agent = new Agent({ keepAlive: true }); // of its own: nobody else's request is waited for
    const looking = (async () => {
        while (on) {
            const begin = performance.now();
            all_ok &&= await get_alone(service.port, "/livez", agent) === 200;
            slowest_ms = Math.max(slowest_ms, performance.now() - begin);
            await sleep(20);
        }
    })();
    return async () => { on = false; await looking; agent.destroy(); return { slowest_ms, all_ok }; };
};

const ask_again_and_again = async (life, running) => {
    const agent = new Agent({ keepAlive: true, maxSockets: 800 }), { service } = life, counts = {};
    const before_mb = rss_mb(service.pid);
    await Promise.all(Array.from({ length: 800 }, async () => {
        for (let i = 0; i < 4; i++) {
            const status = await get_alone(service.port, `/v1/jobs/${running}`, agent);
            counts[status] = (counts[status] ?? 0) + 1;
        }
    }));
    const waiting = await service.metric("shearwater_http_waiting");
    check(`a disk that hangs: of 3,200 requests ${waiting} wait, no more than may`, waiting > 1000 && waiting <= ROOM, waiting);
    check("a disk that hangs: all are told to come again", counts[503] === 3200, counts);
    const more = await timed(() => service.ask("GET", `/v1/jobs/${running}`));
    check(`a disk that hangs: one more is told so at once (${more.ms.toFixed(0)} ms)`, problem(more, "busy") && more.ms < LATE_MS, shown(more));
    const grown_mb = rss_mb(service.pid) - before_mb;
    check(`a disk that hangs: memory grows by no more than 64 MB (${grown_mb.toFixed(0)} MB)`, grown_mb <= 64);
    agent.destroy();
};

const UPLOADS = 64; // that are under way at once (server/http/upload.h)

// Uploads whose files cannot be written, or not even made.
export const hang_uploads = async (build, { short, reference }) => {
    const life = new Life(build, "shearwater", { environment: { SHEARWATER_ANSWER_MS: String(ANSWER_MS) } }), { service, control } = life;
    await life.start();
    await life.picture(await life.submit(short, "before"), 30);
    const pid = service.pid, before_mb = rss_mb(pid);
    for (const kind of ["write", "make"]) {
        const file = (i) => Buffer.concat([Buffer.alloc(600000, i), Buffer.from(`${kind} ${i}`)]);
        const end_watch = watch_livez(service);
        control.hang(kind);
        const first = timed(() => service.put(file(0)));
        await sleep(200);
        const crowd = await Promise.all(Array.from({ length: UPLOADS + 32 }, (_, i) => timed(() => service.put(file(i + 1)))));
        const one = await first, busy = crowd.filter((answer) => problem(answer, "busy")), late = crowd.filter((answer) => problem(answer, "overdue"));
        check(`a ${kind} that hangs: an upload is answered 503 overdue after ${(one.ms / 1000).toFixed(1)} s`,
            problem(one, "overdue") && one.ms < ANSWER_MS + LATE_MS, shown(one));
        check(`... of ${crowd.length} more ${late.length} are told the same, ${busy.length} that there are too many`,
            busy.length > 0 && late.length > 0 && late.length < UPLOADS && busy.length + late.length === crowd.length,
            crowd.filter((answer) => !busy.includes(answer) && !late.includes(answer)).map(shown).join("\n"));
        const { slowest_ms, all_ok } = await end_watch();
        check(`... /livez is 200 all the time, within ${slowest_ms.toFixed(0)} ms`, all_ok && slowest_ms < 1000);
        const grown_mb = rss_mb(pid) - before_mb;
        check(`... memory grows by no more than 64 MB (${grown_mb.toFixed(0)} MB)`, grown_mb <= 64);
        control.heal();
        const again = await timed(() => life.persist(() => service.put(file(1))));
        check("... over, it is taken", again.status === 201, shown(again));
    }
    check("over: a new scene is rendered right", await life.picture(await life.submit(short, "after"), 30).catch((e) => e.message) === reference.short);
    check("over: in the same process", service.is_up && service.pid === pid && life.deaths === 0);
    life.wrong.length = 0;
    await life.end();
    check("over: nothing is left behind", life.wrong.length === 0, life.wrong.join("\n"));
};

// A disk that crawls: every write ends, and takes long. Uploads have an end all the same, and who asks whether the
// server is ready waits for none of them.
export const crawl_uploads = async (build, { short, reference }) => {
    const UPLOAD_MS = 4000, WRITE_MS = 500;
    const life = new Life(build, "shearwater", { environment: { SHEARWATER_ANSWER_MS: String(ANSWER_MS), SHEARWATER_UPLOAD_MS: String(UPLOAD_MS) } });
    const { service, control } = life, file = (i, size) => Buffer.concat([Buffer.alloc(size, i), Buffer.from(`crawl ${i}`)]);
    await life.start();
    await life.picture(await life.submit(short, "before"), 30);
    control.slow("write", WRITE_MS);
    const one = await timed(() => service.put(file(0, 6 << 20)));
    check(`a disk that crawls: an upload is answered 503 overdue after ${(one.ms / 1000).toFixed(1)} s`,
        problem(one, "overdue") && one.ms < UPLOAD_MS + LATE_MS, shown(one));
    const small = await timed(() => service.put(file(0, 100000)));
    check(`... a small one is taken (${(small.ms / 1000).toFixed(1)} s)`, small.status === 201, shown(small));
    const crowd = Array.from({ length: UPLOADS }, (_, i) => timed(() => service.put(file(i + 1, 2 << 20))));
    await sleep(1000);
    const asked = performance.now(), ready = await until(3, async () => (await service.ask("GET", "/readyz")).status === 200);
    check(`... behind ${UPLOADS} of them it says that it is ready (${(performance.now() - asked).toFixed(0)} ms)`, ready === true);
    const told = await Promise.all(crowd);
    check("... which all come to an end", told.every((answer) => problem(answer, "overdue") && answer.ms < UPLOAD_MS + LATE_MS + 1000 * (slower - 1)),
        told.filter((answer) => !problem(answer, "overdue")).map(shown).join("\n"));
    control.heal();
    const again = await Promise.all(Array.from({ length: UPLOADS }, (_, i) => life.persist(() => service.put(file(i + 1, 2 << 20)))));
    check("... over, there is a place for each of as many", again.every(({ status }) => status === 201), again.map(shown).join("\n"));
    check("over: a scene is rendered right", await life.picture(await life.submit(short, "after"), 30).catch((e) => e.message) === reference.short);
    life.wrong.length = 0;
    await life.end();
    check("over: nothing is left behind", life.wrong.length === 0, life.wrong.join("\n"));
};

export const hang = async (build, { short, long, reference }) => {
    const life = new Life(build, "shearwater", { environment: { SHEARWATER_ANSWER_MS: String(ANSWER_MS) } }), { service, control } = life;
    const asset = sha256(scene);
    await life.start();
    const running = await life.submit(long, "running");
    await until(20, async () => (await service.job(running)).progress.tiles_done > 5);
    const ready = async () => (await service.ask("GET", "/readyz")).status;
    check("a disk that will hang: it is ready", await until(5, async () => await ready() === 200) === true);
    const pid = service.pid, end_watch = watch_livez(service);

    control.hang("fsync");
    const began = performance.now();
    const [submission, other, upload] = await Promise.all([
        timed(() => service.post({ scene: { asset }, ...short }, "later")),
        timed(() => service.post({ scene: { asset }, ...short })),
        timed(() => service.put(Buffer.concat([scene, Buffer.from("another")]))),
        until(10, async () => await ready() === 503),
    ]);
    const told_ms = performance.now() - began;
    const probe = await service.ask("GET", "/readyz");
    check("a disk that hangs: /readyz tells of it", problem(probe, "storage-failed"), shown(probe));
    note(`/readyz told, and three requests were answered, within ${told_ms.toFixed(0)} ms`);
    check("... soon", told_ms < Math.max(READY_MS, ANSWER_MS) + LATE_MS, told_ms);
    for (const [what, answer] of [["a submission", submission], ["one without a key", other], ["an upload", upload]])
        check(`a disk that hangs: ${what} is answered 503 overdue after ${(answer.ms / 1000).toFixed(1)} s`,
            problem(answer, "overdue") && answer.ms < ANSWER_MS + LATE_MS, shown(answer));
    check("a disk that hangs: it goes on to say so", await ready() === 503);
    await ask_again_and_again(life, running);
    const { slowest_ms, all_ok } = await end_watch();
    check(`a disk that hangs: /livez is 200 all the time, within ${slowest_ms.toFixed(0)} ms`, all_ok && slowest_ms < 1000);

    control.heal();
    const healed = performance.now();
    check("over: it is ready again", await until(RECOVERY_S, async () => await ready() === 200) === true);
    check("over: nobody waits any more", await until(RECOVERY_S, async () => await service.metric("shearwater_http_waiting") === 0) === true);
    const digest = await life.picture(running, 30).catch((e) => e.message);
    const seconds = (performance.now() - healed) / 1000;
    check("over: the job is finished with the same bytes", digest === reference.long, digest);
    check(`over: within ${RECOVERY_S} s (${seconds.toFixed(1)} s)`, seconds <= RECOVERY_S);
    const again = await service.post({ scene: { asset }, ...short }, "later");
    check("over: the key tells that the submission was done", again.status === 202 && JSON.parse(again.body).existed === true, shown(again));
    check("over: its picture is right", await life.picture(JSON.parse(again.body).id, 30).catch((e) => e.message) === reference.short);
    const { jobs } = await service.json("/v1/jobs?limit=100");
    check("over: each submission was done once", jobs.length === 3, `${jobs.length} jobs`);
    for (const { id } of jobs) await life.picture(id, 30);
    check("over: in the same process", service.is_up && service.pid === pid && life.deaths === 0);
    life.wrong.length = 0;
    await life.end();
    check("over: nothing is left behind", life.wrong.length === 0, life.wrong.join("\n"));
};
