// Assets that are given up, for tests/system/assets.sh: assets.mjs BUILD_DIR. TAP.
import { existsSync } from "node:fs";
import { request } from "node:http";
import { Tenant, begin } from "../load/parts/clients.mjs";
import { check, done, join, readFileSync, sha256, skip, until } from "../load/service.mjs";
import { bad_disks, can_preload, failed_uploads, killed_at_each_step, killed_at_random, what_waits } from "./assets_killed.mjs";
import { admin, all_of, build, ended, exr, has_object, head, id_of, in_state, is, job, long, note, notes_of, objects_of, picture, put, remove, scene, shown, slug, tokens, viewer } from "./assets_room.mjs";

// ---- one after another ----

const whose = async (service) => {
    const { a, b, root, eye } = all_of(service), bytes = scene("whose"), digest = sha256(bytes);
    check("what nobody has: 404", is(await remove(a, digest), 404, "not-found"));
    await put(a, bytes);
    const no = await remove(b, digest);
    check("another's: 404", is(no, 404, "not-found"), shown(no));
    check("... and it is there", await head(a, digest) === 200 && await head(b, digest) === 404);
    check("a viewer's role does not do", is(await remove(eye, digest), 403, "forbidden"));
    check("an administrator gives up what is his, which this is not: 404", is(await remove(root, digest), 404) && await head(a, digest) === 200);
    const gone = await remove(a, digest);
    check("one's own: 204, without a body", gone.status === 204 && gone.body.length === 0, shown(gone));
    check("... and nobody sees it any more", await head(a, digest) === 404 && await head(root, digest) === 404);
    check("... nor is it on the disk", !has_object(service, digest) && notes_of(service).length === 0);
    check("... again: 404", is(await remove(a, digest), 404, "not-found"));
    await put(a, bytes);
    check("... brought again it is there again", await head(a, digest) === 200 && has_object(service, digest));
    await remove(a, digest);
};

// By its own hands: a client that would tidy the path.
const raw = (service, path) => new Promise((go, fail) => {
    const r = request({ host: "127.0.0.1", port: service.port, method: "DELETE", path, headers: { Authorization: `Bearer ${admin}` }, agent: false },
        (answer) => { const parts = []; answer.on("data", (p) => parts.push(p)); answer.on("end", () => go({ status: answer.statusCode, body: Buffer.concat(parts) })); });
    r.on("error", fail);
    r.end();
});
const hostile = async (service) => {
    const before = objects_of(service).sort().join(), digest = sha256("x");
    const paths = ["short", digest.slice(1), `${digest}0`, digest.toUpperCase(), "..", "%2e%2e", "../jobs.sqlite", "..%2f..%2fjobs.sqlite", "%2e%2e%2f%2e%2e%2fjobs.lock",
        `${digest.slice(0, 61)}%00a`, `${digest.slice(0, 60)}/../`, `${digest}/..`, `../owners/a/${digest}`, `${digest.slice(0, 62)}%2f`, "%", "%zz", "*", "", `${"../".repeat(21)}a`, "\\..\\..\\jobs.sqlite"];
    const wrong = [];
    for (const path of paths) {
        const answer = await raw(service, `/v1/assets/${path}`);
        if (![400, 404, 405].includes(answer.status) || !slug(answer)) wrong.push(`${path}: ${shown(answer)}`);
    }
    check(`${paths.length} digests that are none: 400, 404 or 405`, wrong.length === 0, wrong.join("\n"));
    check("... a malformed one is 400 as for its siblings", is(await raw(service, "/v1/assets/short"), 400, "malformed-request") && is(await raw(service, `/v1/assets/${digest.toUpperCase()}`), 400));
    const body = await all_of(service).a.ask("DELETE", `/v1/assets/${digest}`, "x", { "Content-Length": 1 }), query = await raw(service, `/v1/assets/${digest}?purge=1`);
    check("... and a body or a query is refused", is(body, 400) && is(query, 400), `${shown(body)} ${shown(query)}`);
    check("... and nothing has gone", existsSync(join(service.data, "jobs.sqlite")) && objects_of(service).sort().join() === before);
};

const kept_by_jobs = async (service) => {
    const { a, b } = all_of(service), bytes = scene("kept"), digest = sha256(bytes);
    const map = Buffer.concat([Buffer.from("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"), Buffer.alloc(32, 0x80)]), sky = sha256(map);
    const side = Buffer.from(`beside ${Math.random()}`), beside = sha256(side);
    for (const one of [bytes, map, side]) await put(a, one);
    await put(b, bytes);
    const running = id_of(await job(a, digest, { ...long, environment: { asset: sky } }, { files: { "x.bin": beside } }));
    check("a job runs", await in_state(a, running, "running"));
    for (const [what, one] of [["scene", digest], ["map", sky], ["file beside it", beside]]) {
        const no = await remove(a, one);
        check(`its ${what} stays: 409, which names it`, is(no, 409, "asset-in-use") && String(no.body).includes(running), shown(no));
    }
    const paused = id_of(await job(a, digest, long));
    await a.ask("PATCH", `/v1/jobs/${paused}`, '{"paused": true}', { "Content-Type": "application/json" });
    const both = await remove(a, digest);
    check("so it does for one that is paused", is(both, 409) && String(both.body).includes(paused) && String(both.body).includes(running), shown(both));
    const more = [];
    for (let i = 0; i < 4; i++) more.push(id_of(await job(a, digest, long)));
    const many = await remove(a, digest);
    check("of many it names some, and says how many there are more", is(many, 409) && /and 2 more/.test(many.body), shown(many));
    check("another tenant who has it too learns of none, and may", is(await remove(b, digest), 204) && await head(b, digest) === 404);
    check("... the file stays", has_object(service, digest) && await head(a, digest) === 200);
    await put(b, bytes);
    for (const id of [paused, running, ...more]) await a.ask("DELETE", `/v1/jobs/${id}`);
    for (const id of [paused, running, ...more]) await ended(a, id);
    check("called off: it may go", is(await remove(a, digest), 204) && await head(a, digest) === 404);
    check("... but is there for the other", has_object(service, digest) && await head(b, digest) === 200);
    const drawn = id_of(await job(b, digest));
    check("... who draws it", await ended(b, drawn) === "finished");
    check("... and goes with him", is(await remove(b, digest), 204) && !has_object(service, digest));
    for (const one of [sky, beside]) check("what else the job named goes, too", is(await remove(a, one), 204) && !has_object(service, one));
};

const what_came_of_it = async (service) => {
    const { a } = all_of(service), before = new Set(objects_of(service)), bytes = scene("derived"), digest = sha256(bytes);
    const other = { image: { width: 40, height: 24 }, sampling: { spp: 1 } }; // no other part draws this picture
    await put(a, bytes);
    const id = id_of(await a.post({ scene: { asset: digest }, ...other }, { "Idempotency-Key": "the-derived" }));
    check("a job is drawn", await ended(a, id) === "finished");
    const pixels = await exr(a, id), files = objects_of(service).filter((one) => !before.has(one));
    check("of it there are: its asset, the scene's blob, two pictures", files.length === 4 && files.includes(digest) && files.includes(pixels), files.join());
    check("the asset goes", is(await remove(a, digest), 204));
    const left = objects_of(service).filter((one) => !before.has(one));
    check("... and the blob with it; the pictures stay", left.length === 2 && left.includes(pixels) && await exr(a, id) === pixels, left.join());
    const again = await job(a, digest, other);
    check("submitted again: the asset is missing, and its place is told", is(again, 422, "missing-asset") && JSON.parse(again.body).pointer === "/scene/asset", shown(again));
    const told = await a.post({ scene: { asset: digest }, ...other }, { "Idempotency-Key": "the-derived" });
    check("... but by the key that it came with it is found", told.status === 202 && id_of(told) === id && JSON.parse(told.body).existed, shown(told));
    check("... which takes no other", is(await a.post({ scene: { asset: digest }, ...other }, { "Idempotency-Key": "another" }), 422, "missing-asset"));
    await put(a, bytes);
    const second = id_of(await job(a, digest, other));
    check("brought again it is imported and drawn again, to the same bytes", await ended(a, second) === "finished" && await exr(a, second) === pixels);
    // One digest, two things: the picture of a job, brought as a map.
    const map = (await a.ask("GET", `/v1/jobs/${id}/frames/1/image.exr`)).body;
    await put(a, map);
    check("a picture that is an asset, too: given up", is(await remove(a, pixels), 204) && await head(a, pixels) === 404);
    check("... it is the job's picture still", has_object(service, pixels) && await exr(a, id) === pixels);
    await remove(a, digest);
};

const shared_blob = async (service) => { // two assets whose bytes differ import to the same blob
    const { a } = all_of(service), before = new Set(objects_of(service)), one = scene("twin 1"), two = scene("twin 2");
    for (const bytes of [one, two]) { await put(a, bytes); await ended(a, id_of(await job(a, sha256(bytes)))); }
    const blobs = () => objects_of(service).filter((name) => !before.has(name) && readFileSync(join(service.data, "objects", name.slice(0, 2), name.slice(2))).subarray(0, 2).toString() === "SW").length;
    const count = blobs();
    await remove(a, sha256(one));
    check("a blob that two imports gave stays with the second", count === 1 && blobs() === 1, `${count}, then ${blobs()}`);
    check("... which is drawn from it", await ended(a, id_of(await job(a, sha256(two)))) === "finished");
    await remove(a, sha256(two));
    check("... and goes with it", blobs() === 0, `${blobs()}`);
};

const quota = async (service) => {
    const { a } = all_of(service), block = (mark) => Buffer.alloc(600 << 10, mark);
    check("a file within the quota", (await put(a, block(1))).status === 201);
    check("... another one beyond: 429", is(await put(a, block(2)), 429, "quota-exceeded"));
    check("... the first is given up", is(await remove(a, sha256(block(1))), 204));
    check("... and there is room at once", (await put(a, block(2))).status === 201);
    check("... for one", is(await put(a, block(1)), 429));
    await service.kill();
    await service.start();
    check("after a restart, too", is(await put(a, block(1)), 429) && is(await remove(a, sha256(block(2))), 204) && (await put(a, block(1))).status === 201);
    // The same bytes brought and given up at once, over and over: what counts in the end is what is there.
    const small = Buffer.alloc(100 << 10, 9), digest = sha256(small);
    for (let i = 0; i < 60; i++) await Promise.all([put(a, small), remove(a, digest), put(a, small), remove(a, digest)]);
    await remove(a, digest);
    await remove(a, sha256(block(1)));
    const full = Buffer.alloc(1 << 20, 7);
    check("after 240 uploads and removals at once the whole quota is free, and no more", (await put(a, full)).status === 201 && is(await put(a, small), 429));
    await remove(a, sha256(full));
};

// ---- at once ----

// A submission passes the loop while a removal is on the store's thread, and the other way around.
const submitting = async (service) => {
    const { a } = all_of(service), wrong = [], count = { accepted: 0, missing: 0, removed: 0, kept: 0 };
    const one = async (i) => {
        const bytes = scene(`raced ${i % 8}`), digest = sha256(bytes);
        await put(a, bytes);
        const answers = await Promise.all(i % 2 ? [job(a, digest), remove(a, digest)] : [remove(a, digest), job(a, digest), remove(a, digest)]);
        for (const answer of answers) {
            if (answer.status === 204) count.removed++;
            else if (is(answer, 409, "asset-in-use")) count.kept++;
            else if (is(answer, 422, "missing-asset") && JSON.parse(answer.body).pointer === "/scene/asset") count.missing++;
            else if (answer.status !== 202 && !is(answer, 404, "not-found")) wrong.push(shown(answer));
        }
        const ids = answers.filter((x) => x.status === 202).map(id_of);
        count.accepted += ids.length;
        for (const id of ids) if (await ended(a, id) !== "finished") wrong.push(`${id}: ${JSON.stringify((await a.json(`/v1/jobs/${id}`)).error)}`);
        if (has_object(service, digest) !== (await head(a, digest) === 200)) wrong.push(`${digest}: disk and HEAD differ`);
        return digest;
    };
    for (let i = 0; i < 160; i++) await remove(a, await one(i));
    check(`submissions beside removals: ${count.accepted} accepted and drawn, ${count.missing} refused; ${count.removed} removals, ${count.kept} refused`,
        wrong.length === 0 && count.accepted > 0 && count.removed > 0 && count.missing > 0, wrong.join("\n"));
    check("... and nothing is left of them", Array.from({ length: 8 }, (_, i) => sha256(scene(`raced ${i}`))).every((digest) => !has_object(service, digest)));
};

const uploading = async (service) => {
    const { a, b } = all_of(service), wrong = [];
    let there = 0;
    for (let i = 0; i < 60; i++) {
        const bytes = Buffer.from(`uploaded ${i}`), digest = sha256(bytes);
        await put(a, bytes);
        const [up, down] = await Promise.all([put(b, bytes), remove(a, digest), remove(a, digest)]);
        const lies = await head(b, digest) !== 200 || !has_object(service, digest);
        if (up.status !== 201 || ![204, 404].includes(down.status) || lies) wrong.push(`${i}: ${up.status} ${down.status} ${lies}`);
        there += !lies;
        if (!is(await remove(b, digest), 204)) wrong.push(`${i}: b's stays`);
    }
    check(`60 uploads beside a removal of the same bytes: all ${there} are there`, wrong.length === 0, wrong.join("\n"));
    const left = await Promise.all(Array.from({ length: 60 }, (_, i) => sha256(Buffer.from(`uploaded ${i}`))).map((d) => has_object(service, d)));
    check("... and go with their last owner", !left.some(Boolean), `${left}`);
};

// The same picture is drawn again while an asset of its bytes is given up: one of both makes the file.
const drawing = async (service) => {
    const { a } = all_of(service), bytes = scene("drawn"), digest = sha256(bytes), wrong = [];
    await put(a, bytes);
    const first = id_of(await job(a, digest));
    await ended(a, first);
    const map = (await a.ask("GET", `/v1/jobs/${first}/frames/1/image.exr`)).body, pixels = sha256(map);
    await a.ask("DELETE", `/v1/jobs/${first}?purge=1`);
    for (let i = 0; i < 15; i++) {
        const id = id_of(await job(a, digest));
        let on = true;
        const swing = (async () => { while (on) { await put(a, map); await remove(a, pixels); } })();
        if (await ended(a, id) !== "finished") wrong.push(`${id} did not finish`);
        on = false;
        await swing;
        if (await exr(a, id) !== pixels) wrong.push(`${id} has lost its picture`);
        await a.ask("DELETE", `/v1/jobs/${id}?purge=1`);
    }
    check("15 pictures drawn while an asset of their bytes comes and goes are all there", wrong.length === 0, wrong.join("\n"));
    await remove(a, digest);
};

// ---- without tokens ----

const everybody = async () => {
    const service = await begin(build, "assets-open", { workers: 1 }), t = new Tenant(service), bytes = scene("open"), digest = sha256(bytes);
    await put(t, bytes);
    const running = id_of(await job(t, digest, long));
    const no = await remove(t, digest);
    check("without tokens: a job keeps its asset", is(no, 409, "asset-in-use") && String(no.body).includes(running), shown(no));
    await t.ask("DELETE", `/v1/jobs/${running}`);
    await ended(t, running);
    const drawn = id_of(await job(t, digest));
    await ended(t, drawn);
    check("... ended, it may go", await until(10, async () => (await remove(t, digest)).status === 204) && !has_object(service, digest) && is(await remove(t, digest), 404));
    // What an earlier removal has noted, of the same bytes, is no word on what was brought since.
    await put(t, bytes);
    note(service, digest);
    await put(t, bytes);
    await service.kill();
    await service.start();
    check("... brought again it stays there, after a restart, too", has_object(service, digest) && await head(t, digest) === 200 && notes_of(service).length === 0);
    const pixels = await exr(t, drawn);
    check("... a picture is no asset: 409", is(await remove(t, pixels), 409, "asset-in-use") && await exr(t, drawn) === pixels);
    await put(t, bytes);
    await service.kill();
    // Tokens come: what is of before is nobody's.
    service.args = ["--tokens", tokens.file];
    await service.start();
    const { a, root } = all_of(service);
    check("with tokens then: what is of before is no tenant's", is(await remove(a, digest), 404) && has_object(service, digest));
    check("... an administrator gives it up", is(await remove(root, digest), 204) && !has_object(service, digest));
    await put(a, bytes);
    service.args = [];
    await service.kill();
    await service.start();
    check("without them again a tenant's stays: 409", is(await remove(t, digest), 409, "asset-in-use") && has_object(service, digest));
    await service.kill();
};

const main = async () => {
    const service = await begin(build, "assets", { workers: 2, args: ["--tokens", tokens.file, "--tenant-assets", "1"] });
    for (const part of [whose, hostile, kept_by_jobs, what_came_of_it, shared_blob, quota, submitting, uploading, drawing]) await part(service);
    check("it is the same process all the time, but where it was killed", service.is_up && service.starts === 2);
    await service.kill();
    if (can_preload()) {
        await killed_at_each_step("fsync", 1, 5);
        check("... killed at its first write it is there", (await killed_at_each_step("write", 3, 4))[0] === "there");
        await bad_disks();
        await what_waits();
        await failed_uploads();
    } else {
        skip("killed at each step, disks that are full or hang, what waits and uploads that fail", "a sanitizer's allocator cannot be preloaded before");
    }
    await killed_at_random();
    await everybody();
    done();
};
await main();
