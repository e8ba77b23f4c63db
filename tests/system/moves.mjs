// Moves nodes of a live job and listens to its feed. TAP on standard output.
//   node tests/system/moves.mjs URL BUILD_DIR TMP
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { changeGlb } from "../bench/scenes/glb.mjs";
import { encodePicture } from "../bench/scenes/png.mjs";
import { end, expect, get, median, move, reach, test } from "./live_case.mjs";
import { LiveFeed, ask } from "./live_feed.mjs";

const [url, build, tmp] = process.argv.slice(2);
const scene = join(process.cwd(), "tests/scenes/cornell-box/cornell-box.glb");

const WIDTH = 320, HEIGHT = 180;
const photograph = join(tmp, "plain.png");
writeFileSync(photograph, encodePicture(Buffer.alloc(WIDTH * HEIGHT * 3, 120), WIDTH, HEIGHT));
const members = {
  image: { width: WIDTH, height: HEIGHT }, sampling: { spp: 4 }, effects: { indirect_bounces: 0 }, backplate: { file: photograph },
  catchers: ["Floor", "Ceiling", "BackWall", "RightWall", "LeftWall"], holdouts: ["Light_emitter_7"],
};

function submit(changes, own = {}) {
  const file = join(tmp, "moves-job.json");
  writeFileSync(file, JSON.stringify({ ...members, scene: { file: scene, ...own }, ...changes }));
  return execFileSync(join(build, "shearwater"), ["submit", file, "--server", url, "--quiet"]).toString().trim();
}
const exr = async (id) => (await ask("GET", `${url}/v1/jobs/${id}/frames/1/image.exr`)).bytes;
const to = (x, degrees = 0) => [{ node: "ShortBox", translation: [Math.fround(x), 0, 0.25], rotation_deg: degrees }];

const live = submit({ live: true });
const feed = new LiveFeed(url, live, "composite");
await feed.open;
const before = await reach(live, "resting").then(() => exr(live));

await test("the plan says which nodes there are, what they are, and where", async () => {
  const { nodes } = (await get(live)).plan;
  const box = nodes.find(({ name }) => name === "ShortBox");
  expect(box?.role === "virtual" && box.lowest.every((v, i) => v < box.highest[i]) && Math.abs(box.lowest[1]) < 0.01, JSON.stringify(box));
  expect(nodes.find(({ name }) => name === "Floor")?.role === "catcher" && nodes.find(({ name }) => name === "Light_emitter_7")?.role === "holdout", JSON.stringify(nodes));
});

await test("a moved object is soon seen where it is", async () => {
  const times = [], answered = [];
  for (let i = 0; i < 9; i++) {
    const from = performance.now(), answer = await move(live, { moves: to(i / 50) });
    expect(answer.status === 200, `${answer.status} ${JSON.stringify(answer.body)}`);
    expect(JSON.stringify(answer.body.moves) === JSON.stringify((await get(live)).document.scene.moves), JSON.stringify(answer.body));
    const { number } = answer.body.view, isFirst = ({ kind, view }) => kind === "block" && view === number;
    answered.push(answer.ms - from);
    times.push((feed.heard.find(isFirst) ?? await feed.next(isFirst)).ms - from);
    await reach(live, "resting");
  }
  console.log(`# from PATCH to the first block of a moved object, ${WIDTH} x ${HEIGHT}: answered after ${median(answered).toFixed(0)} ms, median ${median(times).toFixed(0)} ms, most ${Math.max(...times).toFixed(0)} ms`);
  const box = (await get(live)).plan.nodes.find(({ name }) => name === "ShortBox");
  expect(Math.abs(box.lowest[1]) < 0.01, JSON.stringify(box));
});

await test("at rest the picture is that of an ordinary job with the object there, byte by byte", async () => {
  const moves = to(0.3, 40);
  expect((await move(live, { moves })).status === 200, "it is not moved");
  await reach(live, "resting");
  const other = submit({}, { moves });
  await reach(other, "finished");
  const [moved, still] = [await exr(live), await exr(other)];
  expect(moved.length > 10000 && moved.equals(still) && !moved.equals(before), `${moved.length} and ${still.length} bytes`);
});

await test("what rests is not built again", async () => {
  const one = (await get(live)).statistics.skipped.rebuilt_triangles;
  await move(live, { moves: to(0.11) });
  await reach(live, "resting");
  const { rebuilt_triangles: two } = (await get(live)).statistics.skipped;
  expect(two > one, `${two} after ${one}`);
});

await test("moves faster than scenes are made: all are answered, the newest wins", async () => {
  const answers = await Promise.all(Array.from({ length: 20 }, (_, i) => move(live, i % 5 === 4 ? { camera: { eye: [0, 1, 6 + i / 100], target: [0, 1, 0], yfov_deg: 20 } } : { moves: to(i / 100) })));
  expect(answers.every(({ status }) => status === 200), JSON.stringify(answers.map(({ status, body }) => [status, body?.detail])));
  const { document } = await reach(live, "resting");
  expect(document.scene.moves[0].translation[0] === 0.18 && document.scene.camera.eye[2] === 6.19, JSON.stringify(document.scene));
  const other = submit({}, { moves: document.scene.moves, camera: document.scene.camera });
  await reach(other, "finished");
  expect((await exr(live)).equals(await exr(other)), "another picture");
});

await test("back where it was the picture is the first one", async () => {
  await move(live, { camera: null, moves: [] });
  await reach(live, "resting");
  expect((await exr(live)).equals(before), "another picture");
});

await test("moves that cannot be are refused at their place and change nothing", async () => {
  const { view } = await get(live);
  const cases = [
    [{ moves: [{ node: "Nobody" }] }, "/moves/0/node"],
    [{ moves: [{ node: "ShortBox" }, { node: "ShortBox" }] }, "/moves/1/node"],
    [{ moves: [{ node: "" }] }, "/moves/0/node"],
    [{ moves: [{ node: "x".repeat(256) }] }, "/moves/0/node"],
    [{ moves: [{ translation: [1, 0, 0] }] }, "/moves/0/node"],
    [{ moves: [{ node: "ShortBox", translation: [1, 0] }] }, "/moves/0/translation"],
    [{ moves: [{ node: "ShortBox", translation: [1e16, 0, 0] }] }, "/moves/0/translation/0"],
    [{ moves: [{ node: "ShortBox", rotation_deg: 361 }] }, "/moves/0/rotation_deg"],
    [{ moves: [{ node: "ShortBox", scale: 2 }] }, "/moves/0/scale"],
    [{ moves: Array.from({ length: 33 }, (_, i) => ({ node: `n${i}` })) }, "/moves"],
    [{ moves: null }, "/moves"],
    [{ moves: [], paused: true }, "/paused"],
  ];
  for (const [body, pointer] of cases) {
    const answer = await move(live, body);
    expect(answer.status === 422 && answer.body.pointer === pointer, `${JSON.stringify(body)}: ${answer.status} ${JSON.stringify(answer.body)}`);
  }
  const after = await get(live);
  expect(after.view.number === view.number && after.state === "resting", JSON.stringify(after.view));
});

await test("a node stands as if the file had it there", async () => {
  const moved = changeGlb(readFileSync(scene), ({ nodes }) => { nodes.find(({ name }) => name === "TallBox").translation = [0.1, 0, 0.2]; });
  writeFileSync(join(tmp, "elsewhere.glb"), moved);
  const other = submit({}, { file: join(tmp, "elsewhere.glb") });
  const same = submit({}, { moves: [{ node: "TallBox", translation: [0.1, 0, 0.2] }] });
  await Promise.all([reach(other, "finished"), reach(same, "finished")]);
  for (const [id, name] of [[other, "elsewhere"], [same, "same"]]) writeFileSync(join(tmp, `${name}.exr`), await exr(id));
  const { rmse } = JSON.parse(execFileSync(join(build, "shearwater"), ["compare", join(tmp, "elsewhere.exr"), join(tmp, "same.exr"), "--layer", "composite"]));
  expect(rmse < 1e-3, `RMSE ${rmse}`);
});

await test("moves that cannot be fail no others that wait with them", async () => {
  const bodies = [{ moves: to(0.05) }, { moves: [{ node: "Nobody" }] }, { moves: to(0.07) }, { moves: [{ node: "Nobody" }] }];
  const answers = await Promise.all(bodies.map((body) => move(live, body)));
  expect(answers.map(({ status }) => status).join() === "200,422,200,422", JSON.stringify(answers.map(({ body }) => body)));
  const { document } = await reach(live, "resting");
  expect([0.05, 0.07].some((x) => Math.abs(document.scene.moves[0].translation[0] - x) < 1e-6), JSON.stringify(document.scene));
});

await test("steady moves, which wait for no answers, are seen on the way", async () => {
  const heard = feed.heard.length, answers = [], from = performance.now();
  const seen = () => new Set(feed.heard.slice(heard).filter(({ kind }) => kind === "block").map(({ view }) => view)).size;
  while (seen() < 4 && performance.now() - from < 10000) {
    answers.push(move(live, { moves: to(answers.length % 100 / 200) }));
    await new Promise((go) => { setTimeout(go, 15); });
  }
  console.log(`# of ${answers.length} moves in ${(performance.now() - from).toFixed(0)} ms ${seen()} were seen meanwhile`);
  expect(seen() >= 4, `${seen()} views`);
  expect((await Promise.all(answers)).every(({ status }) => status === 200), "some failed");
  await reach(live, "resting");
});

await test("a mesh with a skin is moved, whether or not by its joints", async () => {
  const skinned = changeGlb(readFileSync(scene), (json) => {
    const { nodes, meshes, accessors, buffers, bufferViews, scenes } = json;
    const box = nodes.find(({ name }) => name === "ShortBox"), own = meshes[box.mesh].primitives[0].attributes;
    const { count } = accessors[own.POSITION], bytes = Buffer.alloc(20 * count);
    for (let i = 0; i < count; i++) bytes.writeFloatLE(1, 4 * count + 16 * i);
    buffers.push({ byteLength: bytes.length, uri: `data:application/octet-stream;base64,${bytes.toString("base64")}` });
    bufferViews.push({ buffer: 1, byteLength: 4 * count }, { buffer: 1, byteOffset: 4 * count, byteLength: 16 * count });
    accessors.push({ bufferView: bufferViews.length - 2, componentType: 5121, count, type: "VEC4" }, { bufferView: bufferViews.length - 1, componentType: 5126, count, type: "VEC4" });
    Object.assign(own, { JOINTS_0: accessors.length - 2, WEIGHTS_0: accessors.length - 1 });
    nodes.push({ name: "Bone" });
    scenes[0].nodes.push(nodes.length - 1);
    box.skin = 0;
    json.skins = [{ joints: [nodes.length - 1] }];
  });
  const file = join(tmp, "skinned.glb");
  writeFileSync(file, skinned);
  const id = submit({ live: true }, { file });
  const place = async () => (await reach(id, "resting")).plan.nodes.find(({ name }) => name === "ShortBox");
  const from = await place(), off = (box) => box.lowest.map((v, i) => v - from.lowest[i]);
  for (const node of ["ShortBox", "Bone"]) {
    expect((await move(id, { moves: [{ node, translation: [0.25, 0, -0.5] }] })).status === 200, "it is not moved");
    const moved = off(await place());
    expect([0.25, 0, -0.5].every((v, i) => Math.abs(moved[i] - v) < 1e-4), `${node}: ${moved}`);
  }
  await ask("DELETE", `${url}/v1/jobs/${id}`);
});

await test("a move that waits is told when its job ends", async () => {
  const moves = Array.from({ length: 12 }, (_, i) => move(live, { moves: to(i / 40) }));
  const [answers] = await Promise.all([Promise.all(moves), ask("DELETE", `${url}/v1/jobs/${live}`)]);
  expect(answers.every(({ status }) => status === 200 || status === 409), JSON.stringify(answers.map(({ status }) => status)));
  expect(answers.at(-1).status === 409, "the last is not told");
});

feed.close();
end();
