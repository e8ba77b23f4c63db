// The mathematics of moved cameras, and the pictures of views. TAP on standard output.
//   node tests/browser/orbit.test.mjs BUILD_DIR
import { CoarsePicture } from "../../web/picture/coarse_picture.js";
import { LayerImage } from "../../web/picture/layer_image.js";
import { LiveCamera } from "../../web/camera/live_camera.js";
import { basis, cameraOf, distanceAlongView, dolly, dropOnLevel, nearestBox, orbit, pan, rayThrough, rounded, shortest } from "../../web/camera/orbit.js";
import { expect, runAll, test, until } from "./house.mjs";

const camera = { eye: [0, 1, 5], target: [0, 1, 0], up: [0, 1, 0], yfov_deg: 40 };
const near = (a, b, what, by = 1e-9) => expect(a.every((v, i) => Math.abs(v - b[i]) <= by), `${what}: ${a} and not ${b}`);
const distance = ({ eye, target }) => Math.hypot(...eye.map((v, i) => v - target[i]));
const words = (numbers) => Uint16Array.from(numbers);
const block = (x, y, w, h, value) => ({ x, y, w, h, numbers: words(Array(w * h * 3).fill(value)) });

await runAll(async () => {
  await test("a quarter turn to the right comes to the side", () => {
    near(orbit(camera, Math.PI / 2, 0).eye, [5, 1, 0], "the eye");
    near(orbit(orbit(camera, 0.7, 0.3), -0.7, 0).eye, orbit(camera, 0, 0.3).eye, "there and back");
  });

  await test("the target and its distance stay, whatever the turn", () => {
    let c = { ...camera, up: [0.2, 1, -0.1] };
    for (let i = 0; i < 500; i++) c = orbit(c, Math.sin(i) * 0.5, Math.cos(i * 1.7) * 0.6);
    expect(Math.abs(distance(c) - 5) < 1e-9, `${distance(c)}`);
    near(c.target, camera.target, "the target");
  });

  await test("over the pole it stops, and up never lies along the view", () => {
    for (const way of [1, -1]) {
      let c = camera;
      for (let i = 0; i < 100; i++) c = orbit(c, 0.1, way * 0.3);
      const { forward, right } = basis(c);
      expect(Math.abs(forward[1]) < 1 && Math.hypot(...right) > 0.999, `${forward}`);
      expect(way * (c.eye[1] - 1) > 4.9, `it stopped at ${c.eye}`);
      near(orbit(c, 0, -way * 0.5).eye.slice(1, 2), [1 + way * 5 * Math.cos(0.52)], "and comes back", 1e-6);
    }
  });

  await test("a ray through a pixel meets the ground, and the nearer of two boxes", () => {
    const image = { width: 200, height: 100 };
    near(rayThrough(camera, { x: 100, y: 50 }, image).along, [0, 0, -1], "the middle");
    const ray = rayThrough(camera, { x: 150, y: 75 }, image), half = Math.tan(20 * Math.PI / 180);
    near(ray.along, [half, -half / 2, -1], "right of it and below");
    near(dropOnLevel(ray, 0), [2, 0, 5 - 2 / half], "the ground");
    expect(dropOnLevel(ray, 2) === null && dropOnLevel(rayThrough(camera, { x: 100, y: 50 }, image), 0) === null, "above, and level");
    const box = (z) => ({ lowest: [-1, 0, z], highest: [1, 2, z + 1] });
    const middle = rayThrough(camera, { x: 100, y: 50 }, image), [back, front, behind] = [box(-3), box(0), box(8)];
    expect(nearestBox(middle, [back, front, behind]) === front && nearestBox(middle, [behind]) === null, "another box");
  });

  await test("panning moves eye and target alike, by heights of the picture", () => {
    const c = pan(camera, 0, 1), tall = 2 * 5 * Math.tan(20 * Math.PI / 180);
    near(c.eye, [0, 1 + tall, 5], "the eye");
    near(c.target, [0, 1 + tall, 0], "the target");
    near(pan(camera, 0.5, 0).target, [tall / 2, 1, 0], "to the right");
  });

  await test("dollying goes along the view and never through the target", () => {
    near(dolly(camera, 0.5).eye, [0, 1, 2.5], "half-way");
    let c = camera;
    for (let i = 0; i < 1000; i++) c = dolly(c, 0.5);
    expect(distance(c) > 0 && c.eye.every(Number.isFinite), `${c.eye}`);
  });

  await test("a camera of the plan is looked through unchanged", () => {
    const c = cameraOf({ eye: [1, 2, 3], forward: [0, -0.6, -0.8], up: [0, 0.8, -0.6], yfov_deg: 30 }, 2);
    near(c.target, [1, 0.8, 1.4], "the target");
    near(c.up, [0, 1, 0], "a level horizon");
    near(basis(c).up, [0, 0.8, -0.6], "its up");
    near(cameraOf({ eye: [0, 0, 0], forward: [0, 0, -1], up: [0.6, 0.8, 0], yfov_deg: 30 }, 1).up, [0.6, 0.8, 0], "a tilted one");
  });

  await test("a depth along a ray is so far along the view", () => {
    const size = { width: 101, height: 101 };
    expect(distanceAlongView(3, 50, 50, size, 90) === 3, "in the middle");
    const corner = distanceAlongView(Math.sqrt(3), 100, 100, size, 90);
    expect(Math.abs(corner - 1) < 0.02, `in the corner ${corner}`);
  });

  await test("numbers are as short as floats can be told apart", () => {
    expect(shortest(0.1) === 0.1 && shortest(1 / 3) === 0.33333334 && shortest(-2) === -2 && shortest(0) === 0, `${shortest(1 / 3)}`);
    for (let i = 0; i < 2000; i++) {
      const v = Math.fround((i - 1000) * 1.234567e-3 ** (i % 3));
      expect(Math.fround(shortest(v)) === v, `${v} became ${shortest(v)}`);
    }
    expect(JSON.stringify(rounded(camera)) === JSON.stringify(camera), "a short one stays");
  });

  await test("a coarse picture is stretched over all of the full one", () => {
    const coarse = new CoarsePicture(2, 1), out = words(Array(5 * 3 * 3).fill(9));
    expect(!coarse.put(block(0, 0, 1, 1, 1)) && coarse.put(block(1, 0, 1, 1, 2)), "whole with its last block");
    coarse.stretch(out, 5, 3);
    for (let y = 0; y < 3; y++) expect([...out.subarray(15 * y, 15 * y + 15)].filter((_, i) => i % 3 === 0).join("") === "11222", `${out}`);
  });

  await test("nothing of a view is seen beside the next", () => {
    const image = new LayerImage(), seen = () => new Set(image.numbers);
    const view = (number) => image.put({ x: 128, y: 64, w: 0, h: number, numbers: words([]) });
    const size = (x, y) => image.put({ x, y, w: 0, h: 0, numbers: words([]) });
    view(1); size(64, 32); image.put(block(0, 0, 64, 32, 1));
    expect(image.view === 1 && image.width === 128 && [...seen()].join() === "1", "the coarse one is shown");
    size(128, 64); view(1); size(128, 64);
    image.put(block(0, 0, 64, 64, 2));
    expect([...seen()].sort().join() === "1,2", "the full one comes over it");
    view(2); size(65, 32);
    expect(image.view === 1, "until there is something the one before stays");
    image.put(block(0, 0, 64, 32, 3));
    expect(image.view === 1 && [...seen()].sort().join() === "1,2", "half of a coarse one is not shown");
    size(65, 32);
    image.put(block(64, 0, 1, 32, 3));
    expect(image.view === 2 && [...seen()].join() === "3", `after it ${[...seen()]}`);
    view(4); size(128, 64); image.put(block(0, 0, 64, 64, 4));
    expect([...seen()].sort().join() === "0,4" && image.at(100, 0) === null, "a full block alone clears what was there");
    size(128, 64);
    expect(image.at(0, 0) !== null, "a sign of life takes nothing away");
  });

  await test("of moves that come too fast only the newest is sent", async () => {
    const sent = [];
    let answer = null;
    globalThis.fetch = (path, { body }) => new Promise((done) => {
      sent.push(JSON.parse(body));
      answer = () => done({ ok: true, text: async () => JSON.stringify({ view: { number: sent.length }, camera: sent.at(-1).camera, lens: null }) });
    });
    const live = new LiveCamera(() => {});
    live.take("job", { document: { scene: { camera }, lens: null }, view: { number: 0 } }, 1);
    for (let i = 1; i <= 5; i++) live.move({ camera: dolly(camera, i) });
    expect(sent.length === 1, `${sent.length} at once`);
    answer();
    await until("the answer", () => live.number === 1);
    expect(sent.length === 1, "the next waits for pixels");
    live.drawn(1);
    await until("the next", () => sent.length === 2);
    near(sent[1].camera.eye, dolly(camera, 5).eye, "the newest", 1e-6);
    answer();
    await until("patience ends without pixels", () => live.settled, 2);
    expect(sent.length === 2 && live.firstPixels.length === 1, `${sent.length} sent`);
  });
});
