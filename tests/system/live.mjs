// Moves a live job's camera and listens to its feed. TAP on standard output.
//   node tests/system/live.mjs URL BUILD_DIR TMP
// SHEARWATER_FIRST_BLOCK_MS is the bound of the median from PATCH to the first block of the new view.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { end, expect, get, median, move, pause, reach, slower, test } from "./live_case.mjs";
import { LiveFeed, ask } from "./live_feed.mjs";

const [url, build, tmp] = process.argv.slice(2);
const BOUND_MS = Number(process.env.SHEARWATER_FIRST_BLOCK_MS ?? 600) * slower;
const scene = join(process.cwd(), "tests/scenes/cornell-box/cornell-box.glb");

function submit(changes) {
  const file = join(tmp, "live-job.json");
  writeFileSync(file, JSON.stringify({ scene: { file: scene }, image: { width: 640, height: 360 }, ...changes }));
  return execFileSync(join(build, "shearwater"), ["submit", file, "--server", url, "--quiet"]).toString().trim();
}
const around = (angle) => ({ eye: [Math.fround(4 * Math.sin(angle)), 1, Math.fround(4 * Math.cos(angle))], target: [0, 1, 0], up: [0, 1, 0], yfov_deg: 39 });
const png = (id) => ask("GET", `${url}/v1/jobs/${id}/frames/1/image.png`);
const exr = async (id) => (await ask("GET", `${url}/v1/jobs/${id}/frames/1/image.exr`)).bytes;

const live = submit({ sampling: { spp: 9, tile_px: 128 }, layers: ["beauty", "depth"], live: true });
const feed = new LiveFeed(url, live);
await feed.open;

await test("a live job rests when its picture is complete", async () => {
  const job = await reach(live, "resting");
  expect(job.view.number === 1 && job.view.scale === 1 && job.view.complete, JSON.stringify(job.view));
  expect(job.progress.view.number === 1 && job.frames[0].exr === null, JSON.stringify(job.progress));
  const heard = feed.heard.filter(({ kind }) => kind !== "block").map(({ kind, x, y }) => `${kind} ${x}x${y}`);
  expect(heard[0] === "view 640x360" && heard[1] === "size 160x90" && heard.includes("size 640x360"), heard.join(", "));
});

await test("a move brings a coarse picture, then the full one, soon", async () => {
  const times = [];
  for (let i = 0; i < 15; i++) {
    const from = performance.now(), answer = await move(live, { camera: around(i / 10) });
    expect(answer.status === 200, `${answer.status} ${JSON.stringify(answer.body)}`);
    const { number } = answer.body.view;
    const known = feed.heard.find(({ kind, view }) => kind === "block" && view === number);
    const first = known ?? await feed.next(({ kind, view }) => kind === "block" && view === number);
    times.push(first.ms - from);
    if (i % 2) await reach(live, "resting");
  }
  console.log(`# from PATCH to the first block of its view, 640 x 360: median ${median(times).toFixed(1)} ms, most ${Math.max(...times).toFixed(1)} ms, of ${times.length}`);
  expect(median(times) <= BOUND_MS, `the median is above ${BOUND_MS} ms`);
});

await test("views only grow, each whole in itself", () => {
  let view = 0, size = null, begun = false;
  for (const heard of feed.heard) {
    if (heard.kind === "view") {
      expect(heard.x === 640 && heard.y === 360 && heard.h >= view, `view ${heard.h} after ${view}`);
      if (heard.h > view) begun = false;
      view = heard.h;
    } else if (heard.kind === "size") {
      size = heard;
      if (!begun) expect(heard.x === 160, `view ${view} begins with ${heard.x} x ${heard.y}`);
      begun = true;
    } else if (heard.kind === "block") expect(heard.x + heard.w <= size.x && heard.y + heard.h <= size.y, "a block outside its picture");
  }
});

await test("moves faster than pictures: newest wins, none waits", async () => {
  await reach(live, "resting");
  const { number: before } = (await get(live)).view, from = feed.heard.length;
  const answers = await Promise.all(Array.from({ length: 60 }, (_, i) => move(live, { camera: around(2 + i / 100) })));
  expect(answers.every(({ status }) => status === 200), "a move was refused");
  const numbers = answers.map(({ body }) => body.view.number), last = Math.max(...numbers);
  expect(new Set(numbers).size === 60 && last === before + 60, `${numbers}`);
  const job = await reach(live, "resting");
  expect(job.view.number === last, `${job.view.number} rests, not ${last}`);
  const newest = answers.find(({ body }) => body.view.number === last).body.camera;
  expect(JSON.stringify(job.document.scene.camera) === JSON.stringify(newest), "another camera");
  const seen = new Set(feed.heard.slice(from).filter(({ kind }) => kind === "view").map(({ h }) => h));
  console.log(`# of 60 moves at once ${seen.size} views were begun to be shown`);
  expect(seen.has(last), "the newest was never shown");
});

await test("no block of the view before comes after the next has begun", async () => {
  // A picture that is lit everywhere, then one that looks away from everything: all of it is black.
  const away = { eye: [0, 1, 100], target: [0, 1, 200], up: [0, 1, 0], yfov_deg: 39 };
  for (let i = 0; i < 6; i++) {
    await move(live, { camera: around(0) });
    await pause(i * 25); // in different states of the picture before
    const { number } = (await move(live, { camera: away })).body.view;
    await reach(live, "resting");
    await pause(50);
    const dark = feed.heard.filter(({ kind, view }) => kind === "block" && view === number);
    expect(dark.length > 0 && dark.every(({ bytes }) => bytes.every((v) => v === 0)), `move ${i}: pixels of another view`);
  }
});

await test("after many moves the picture is that of an ordinary job, byte by byte", async () => {
  for (let i = 0; i < 20; i++) { await move(live, { camera: around(i) }); await pause(i * 7 % 60); }
  await move(live, { camera: around(0.3) });
  await reach(live, "resting");
  const moved = await exr(live), { document } = await get(live);
  const other = submit({ scene: { file: scene, camera: document.scene.camera }, sampling: { spp: 9 }, layers: ["beauty", "depth"] });
  await reach(other, "finished");
  const still = await exr(other);
  expect(moved.length > 10000 && moved.equals(still), `${moved.length} and ${still.length} bytes`);
});

await test("once a view is begun to be shown it has a picture, with a tag of its own", async () => {
  const tags = [];
  for (let i = 0; i < 4; i++) {
    const { number } = (await move(live, { camera: around(i / 5) })).body.view;
    const ofView = ({ kind, view }) => kind === "block" && view === number;
    if (!feed.heard.find(ofView)) await feed.next(ofView);
    for (let job = {}; job.state !== "resting"; job = await get(live)) {
      const { status } = await png(live);
      expect(status === 200, `GET image.png: ${status}`);
    }
    tags.push((await png(live)).etag);
  }
  expect(tags[0] && new Set(tags).size === tags.length, tags.join(", "));
});

await test("a lens is moved, too, and taken away", async () => {
  const lens = { aperture_radius: 0.1, focus_distance: 4, blades: 0, blade_rotation_deg: 0 };
  const answer = await move(live, { lens });
  expect(JSON.stringify(Object.entries(answer.body.lens).sort()) === JSON.stringify(Object.entries(lens).sort()), JSON.stringify(answer.body));
  const job = await reach(live, "resting"), sharp = await exr(live);
  expect(job.plan.integrator === "lens_field", job.plan.integrator);
  expect((await move(live, { lens: null })).body.lens === null, "the lens stays");
  await reach(live, "resting");
  expect(!sharp.equals(await exr(live)), "the lens changes nothing");
});

await test("hostile moves are refused at their place and change nothing", async () => {
  const { view } = await get(live), camera = around(1);
  const cases = [
    ['{"camera": {"eye": [NaN, 0, 0], "target": [0, 0, 1]}}', 400, undefined],
    ['{"camera": {"eye": [1e999, 0, 0], "target": [0, 0, 1]}}', 422, undefined],
    [{ camera: { ...camera, target: camera.eye } }, 422, "/camera/target"],
    [{ camera: { ...camera, yfov_deg: 0 } }, 422, "/camera/yfov_deg"],
    [{ camera: { ...camera, yfov_deg: 180 } }, 422, "/camera/yfov_deg"],
    [{ camera: { ...camera, up: [camera.eye[0], 0, camera.eye[2]] } }, 422, "/camera/up"],
    [{ camera: { ...camera, up: [0, 0, 0] } }, 422, "/camera/up"],
    [{ camera: "no such camera" }, 422, "/camera"],
    [{ camera: 4000 }, 422, "/camera"],
    [{ camera, lens: { aperture_radius: 1 } }, 422, "/lens/focus_distance"],
    [{ camera, lens: { aperture_radius: 1, focus_distance: 0 } }, 422, "/lens/focus_distance"],
    [{}, 422, undefined],
    [{ camera, priority: 1 }, 422, "/priority"],
    ["[]", 422, undefined],
    ["", 400, undefined],
  ];
  for (const [body, status, pointer] of cases) {
    const answer = await move(live, body);
    expect(answer.status === status && answer.type === "application/problem+json", `${JSON.stringify(body)}: ${answer.status} ${JSON.stringify(answer.body)}`);
    expect(pointer === undefined || answer.body.pointer.startsWith(pointer), `${JSON.stringify(body)}: at ${answer.body.pointer}`);
  }
  const after = await get(live);
  expect(after.view.number === view.number && after.state === "resting", JSON.stringify(after.view));
});

await test("what is not live cannot be moved", async () => {
  const other = submit({ sampling: { spp: 400 } });
  const answer = await move(other, { camera: around(1) });
  expect(answer.status === 409 && /not a live job/.test(answer.body.detail), JSON.stringify(answer.body));
  await ask("DELETE", `${url}/v1/jobs/${other}`);
});

await test("a live job goes before others, and leaves them their turn", async () => {
  const other = submit({ image: { width: 512, height: 512 }, sampling: { spp: 36 } });
  await reach(other, "running");
  const from = performance.now(), { number } = (await move(live, { camera: around(3) })).body.view;
  const first = feed.heard.find(({ kind, view }) => kind === "block" && view === number) ??
    await feed.next(({ kind, view }) => kind === "block" && view === number);
  console.log(`# beside another job: ${(first.ms - from).toFixed(1)} ms`);
  await reach(live, "resting");
  await reach(other, "finished", 120);
});

await test("too many live jobs are refused, and a place is free again after one", async () => {
  const more = [];
  let refused = null;
  for (let i = 0; i < 12 && !refused; i++) {
    try { more.push(submit({ image: { width: 32, height: 18 }, live: true })); } catch (error) { refused = String(error.stderr ?? error); }
  }
  expect(refused && /live jobs are open/.test(refused) && more.length === 7, `${more.length} taken: ${refused}`);
  for (const id of more) await reach(id, "resting");
  const batch = submit({ image: { width: 64, height: 36 } });
  await reach(batch, "finished");
  await ask("DELETE", `${url}/v1/jobs/${more[0]}`);
  await reach(more[0], "cancelled");
  const again = submit({ image: { width: 32, height: 18 }, live: true });
  for (const id of [...more.slice(1), again]) await ask("DELETE", `${url}/v1/jobs/${id}`);
});

await test("however many come at once, no more are taken", async () => {
  const { document } = await get(live);
  await pause(200); // those that were called off are gone
  const one = { ...document, image: { ...document.image, width: 32, height: 18 } };
  const answers = await Promise.all(Array.from({ length: 16 }, () => ask("POST", `${url}/v1/jobs`, one)));
  const taken = answers.filter(({ body }) => body?.id).map(({ body }) => body.id);
  expect(taken.length === 7, `${taken.length} taken: ${answers.map(({ status }) => status)} ${JSON.stringify(answers[15].body)}`);
  for (const id of taken) await reach(id, "resting");
  for (const id of taken) await ask("DELETE", `${url}/v1/jobs/${id}`);
});

feed.close();
writeFileSync(join(tmp, "live-id"), live);
console.log(`# job ${live}`);
end();
