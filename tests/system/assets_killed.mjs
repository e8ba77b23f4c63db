// Removals that are killed between, on disks that fail, and what waits for them: for assets.mjs.
import { execFileSync } from "node:child_process";
import { resolve } from "node:path";
import { Control, EIO, ENOSPC } from "../load/fault_life.mjs";
import { Tenant, begin } from "../load/parts/clients.mjs";
import { Service, check, folder, join, readFileSync, sha256, sleep, slower, until } from "../load/service.mjs";
import { all_of, build, ended, has_object, head, id_of, is, job, long, notes_of, objects_of, picture, put, query, remove, scene, shown, tokens } from "./assets_room.mjs";

const settled = async (service, t, digest, label, wrong) => {
    const there = await head(t, digest) === 200, job_answer = await job(t, digest, picture);
    if (there !== has_object(service, digest)) wrong.push(`${label}: HEAD says ${there}, the disk ${!there}`);
    if (there && (job_answer.status !== 202 || await ended(t, id_of(job_answer)) !== "finished")) wrong.push(`${label}: there, and not drawn: ${shown(job_answer)}`);
    if (!there && !is(job_answer, 422, "missing-asset")) wrong.push(`${label}: ${shown(job_answer)}`);
    if (there && !is(await remove(t, digest), 204)) wrong.push(`${label}: there, and not to be removed`);
    if (notes_of(service).length) wrong.push(`${label}: notes ${notes_of(service)}`);
    return there;
};

export const can_preload = () => execFileSync("sh", ["-c", `nm ${build}/shearwater | grep -c __[at]san_init || true`], { encoding: "utf8" }).trim() === "0";
const unreliable = (name, environment = {}) => {
    const home = folder(name), control = new Control(join(home, "control"));
    const faulty = { LD_PRELOAD: resolve(build, "tests/fake/preload_faults.so"), FAULTS_CONTROL: control.path, FAULTS_FOR: "shearwater", ...environment };
    const service = new Service(build, join(home, "data"), { workers: 1, args: ["--tokens", tokens.file, "--tenant-assets", "1"] });
    return { control, faulty, service };
};

// Each fsync of a removal, and every third write, hangs once, and the server is killed there: every step is the last one once.
export const killed_at_each_step = async (kind, stride, least) => {
    const { control, faulty, service } = unreliable(`assets-killed-${kind}`), { a } = all_of(service), states = [], wrong = [];
    let steps = 0;
    for (let k = 1; k < 60; k += stride) {
        await service.start(faulty);
        const bytes = scene(`${kind} ${k}`), digest = sha256(bytes), before = new Set(objects_of(service));
        await put(a, bytes);
        const drawn = id_of(await job(a, digest));
        await ended(a, drawn);
        await a.ask("DELETE", `/v1/jobs/${drawn}?purge=1`);
        await sleep(100);
        const from = control.calls(kind);
        control.fail(kind, from + k, 1e9, 0);
        const answer = remove(a, digest).catch(() => null);
        const hung = await Promise.race([answer.then(() => false), until(10, () => control.calls(kind) >= from + k, 5)]);
        await service.kill();
        await answer;
        control.heal();
        await service.start();
        steps += Boolean(hung);
        states.push(await settled(service, a, digest, `${kind} ${k}`, wrong) ? "there" : "gone");
        const blobs = objects_of(service).filter((one) => !before.has(one) && one !== digest && readFileSync(join(service.data, "objects", one.slice(0, 2), one.slice(2))).subarray(0, 4).toString("latin1") !== "\x76\x2f\x31\x01" &&
            readFileSync(join(service.data, "objects", one.slice(0, 2), one.slice(2))).subarray(1, 4).toString() !== "PNG");
        if (blobs.length) wrong.push(`${kind} ${k}: blobs are left: ${blobs}`);
        await service.kill();
        if (!hung) break;
    }
    check(`killed at ${steps} calls of ${kind}: after a restart it is there whole or gone whole (${states.join(" ")})`, wrong.length === 0 && steps >= least && states.at(-1) === "gone", wrong.join("\n"));
    return states;
};

// A full disk is when files are given up; one that hangs is waited for by nobody.
export const bad_disks = async () => {
    const { control, faulty, service } = unreliable("assets-disk", { SHEARWATER_ANSWER_MS: "1000" }), { a } = all_of(service);
    await service.start(faulty);
    const bytes = scene("disk"), digest = sha256(bytes);
    await put(a, bytes);
    control.from_now("make", ENOSPC);
    const full = await remove(a, digest);
    check("on a full disk: 204, and the file goes", full.status === 204 && await head(a, digest) === 404 && !has_object(service, digest), shown(full));
    control.heal();
    await put(a, bytes);
    control.from_now("write", ENOSPC);
    const fuller = await remove(a, digest);
    check("on one that is full to the last byte: 507, and the file goes all the same", is(fuller, 507, "disk-full") && await head(a, digest) === 404 && !has_object(service, digest), shown(fuller));
    control.heal();
    check("... and there is room again: 204, once", is(await remove(a, digest), 204) && is(await remove(a, digest), 404) && notes_of(service).length === 0);
    await put(a, bytes);
    control.hang("fsync");
    const begun = performance.now(), late = remove(a, digest);
    let slowest_ms = 0, live = true;
    for (let i = 0; i < 20; i++) {
        const from = performance.now();
        live &&= (await service.ask("GET", "/livez")).status === 200;
        slowest_ms = Math.max(slowest_ms, performance.now() - from);
        await sleep(20);
    }
    const answer = await late, waited_ms = performance.now() - begun;
    check(`on a disk that hangs: 503 overdue after ${Math.round(waited_ms)} ms`, is(answer, 503, "overdue") && waited_ms < 3500 * slower, shown(answer));
    check(`... and /livez answers all the time, within ${Math.round(slowest_ms)} ms`, live && slowest_ms < 500 * slower);
    control.heal();
    check("... over, it is done as a whole", await until(10, async () => await head(a, digest) === 404) && await until(10, () => !has_object(service, digest) && notes_of(service).length === 0));
    check("... and the file may come again", (await put(a, bytes)).status === 201 && await ended(a, id_of(await job(a, digest))) === "finished");
    await service.kill();
};

// Another file in the same folder.
const beside = (bytes, mark) => {
    const first = sha256(bytes).slice(0, 2);
    for (let i = 0; ; i++) {
        const other = Buffer.from(`${mark} ${i}`);
        if (sha256(other).startsWith(first)) return other;
    }
};
// The next call hangs, and what `work` begins with it.
const hung_at = async (control, kind, work) => {
    const from = control.calls(kind);
    control.fail(kind, from + 1, 1, 0);
    const answer = work();
    if (!await until(10, () => control.calls(kind) > from, 5)) throw new Error(`no ${kind}`);
    return answer;
};
const goes = (service, digest) => until(30, () => !has_object(service, digest) && notes_of(service).length === 0);

// While a file is being stored those beside it cannot go; nor does what a job of somebody without a mark needs.
export const what_waits = async () => {
    const { control, faulty, service } = unreliable("assets-waits"), { a, root } = all_of(service);
    await service.start(faulty);
    const bytes = scene("waits"), digest = sha256(bytes), other = beside(bytes, "beside it");
    await put(a, bytes);
    const { answer } = await hung_at(control, "rename", () => ({ answer: put(a, other) }));
    control.from_now("write", ENOSPC);
    const full = await remove(a, digest);
    check("what must wait, without room to note it: 507", is(full, 507, "disk-full") && await head(a, digest) === 200, shown(full));
    control.fail("write", 0, 0, 0);
    const gone = await remove(a, digest);
    check("beside a file that is being stored: 204", is(gone, 204) && await head(a, digest) === 404, shown(gone));
    await sleep(2500);
    check("... and it waits", has_object(service, digest) && notes_of(service).includes(digest));
    control.heal();
    check("... that is stored, and it goes, without a restart", (await answer).status === 201 && await goes(service, digest) && await head(a, sha256(other)) === 200);
    await put(a, bytes);
    const running = id_of(await job(root, digest, long));
    check("named by an administrator's job: its owner gives it up", is(await remove(a, digest), 204) && await head(a, digest) === 404);
    await sleep(2500);
    check("... it waits", has_object(service, digest) && notes_of(service).join() === digest);
    await root.ask("DELETE", `/v1/jobs/${running}`);
    check("... and goes after the job", await goes(service, digest));
    await service.kill();
    // Without tokens, too.
    service.args = [];
    await service.start(faulty);
    const t = new Tenant(service);
    await put(t, bytes);
    const again = beside(bytes, "beside it again"), late = await hung_at(control, "rename", () => ({ answer: put(t, again) })), soon = await remove(t, digest);
    check("without tokens: 204, too, and nobody has it", is(soon, 204) && await head(t, digest) === 404 && is(await job(t, digest), 422, "missing-asset"), shown(soon));
    check("... and it waits", has_object(service, digest));
    control.heal();
    check("... that is stored, and it goes", (await late.answer).status === 201 && await goes(service, digest) && await head(t, sha256(again)) === 200);
    await service.kill();
};

// An upload that comes to nothing after its file is in its place.
export const failed_uploads = async () => {
    const { control, faulty, service } = unreliable("assets-unkept"), { a } = all_of(service), block = (mark) => Buffer.alloc(600 << 10, mark);
    await service.start(faulty);
    const bytes = block(1), digest = sha256(bytes);
    await put(a, bytes);
    const again = await hung_at(control, "fsync", () => ({ answer: put(a, bytes) }));
    const removed = await remove(a, digest), second = await put(a, block(2));
    control.heal();
    const answer = await again.answer;
    check("brought again, given up meanwhile, and the room is taken: 429", is(removed, 204) && second.status === 201 && is(answer, 429, "quota-exceeded"), `${shown(removed)} ${shown(second)} ${shown(answer)}`);
    check("... it does not stay", await goes(service, digest) && await head(a, digest) === 404);
    await remove(a, sha256(block(2)));
    const synced = await hung_at(control, "fsync", () => ({ answer: put(a, bytes) }));
    control.from_now("write", ENOSPC);
    control.fail("fsync", 0, 0, 0);
    const failed = await synced.answer;
    control.heal();
    check("its owner cannot be put on record: 507, and it does not stay", is(failed, 507, "disk-full") && await head(a, digest) === 404 && await goes(service, digest), shown(failed));
    control.fail("rename", control.calls("rename") + 1, 1, EIO);
    const lost = await put(a, bytes);
    check("it cannot be placed: 500, and it is not there", is(lost, 500, "internal") || is(lost, 503, "storage-failed") ? await head(a, digest) === 404 : false, shown(lost));
    check("... nor does it take room for long", await until(20, async () => (await put(a, block(2))).status === 201) && notes_of(service).length === 0);
    await remove(a, sha256(block(2)));
    const begun = await hung_at(control, "rename", () => ({ answer: put(a, bytes).catch(() => null) }));
    const owned = query(service, "SELECT owner FROM asset_owners", "-readonly").join();
    await service.kill();
    await begun.answer;
    control.heal();
    await service.start();
    check("killed while it is placed: it had an owner, and has none after the next start", owned === "a" && await head(a, digest) === 404 && !has_object(service, digest) && query(service, "SELECT owner FROM asset_owners", "-readonly").length === 0);
    await service.kill();
};

export const killed_at_random = async () => {
    const service = await begin(build, "assets-random", { workers: 1, args: ["--tokens", tokens.file, "--tenant-assets", "1"] }), { a, b } = all_of(service), wrong = [];
    for (let round = 0; round < 6; round++) {
        const all = Array.from({ length: 12 }, (_, i) => Buffer.from(`round ${round} ${i}`));
        for (const bytes of all) { await put(a, bytes); await put(b, bytes); }
        const answers = new Map();
        const work = Promise.all(all.map(async (bytes, i) => { for (const t of i % 2 ? [a, b] : [b, a]) answers.set(t, [...answers.get(t) ?? [], [sha256(bytes), await remove(t, sha256(bytes)).catch(() => null)]]); }));
        await sleep(2 + 7 * round);
        await service.kill();
        await work;
        await service.start();
        for (const [t, list] of answers)
            for (const [digest, answer] of list)
                if (answer?.status === 204 && await head(t, digest) !== 404) wrong.push(`${digest} was told to be gone, and is there`);
        for (const bytes of all) {
            const digest = sha256(bytes), owners = [await head(a, digest), await head(b, digest)].filter((s) => s === 200).length;
            if (owners > 0 !== has_object(service, digest)) wrong.push(`${digest}: ${owners} owners, and the file is ${has_object(service, digest) ? "" : "not "}there`);
            await remove(a, digest);
            await remove(b, digest);
            if (has_object(service, digest)) wrong.push(`${digest} stays`);
        }
    }
    check("killed in the midst of removals, six times: what was told is so, and files are there with their owners alone", wrong.length === 0, wrong.join("\n"));
    // The studio light is the server's own.
    const is_own = (one) => readFileSync(join(service.data, "objects", one.slice(0, 2), one.slice(2))).subarray(0, 7).toString("latin1") === "SWENVIR";
    const { size } = new Set([...objects_of(service).filter((one) => !is_own(one)), ...notes_of(service)]);
    check("... and nothing is left", size === 0, `${size}`);
    await service.kill();
};
