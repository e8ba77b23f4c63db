// Judging pictures in the viewer: SSIM and FLIP as the command has them, their maps, alpha. TAP on
// standard output.
//   node tests/browser/perceptual.test.mjs BUILD_DIR
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { readExr } from "../../web/picture/exr_file.js";
import { flip } from "../../web/compare/flip.js";
import { LayerImage } from "../../web/picture/layer_image.js";
import { BlockParser } from "../../web/picture/pixel_feed.js";
import { displayPair } from "../../web/compare/display_pair.js";
import { ssim } from "../../web/compare/ssim.js";
import { build, canvasText, expect, look, openPage, runAll, settle, shots, startServer, submit, test, text, tmp, until, viewText } from "./house.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const press = async (page, ...keys) => { await page.focus("#stage"); for (const key of keys) await page.keyboard.press(key); };
const save = (page, name) => page.screenshot({ path: join(shots, `perceptual-${name}.png`), fullPage: true });
const FIGURES = /^SSIM ([0-9.-]+), FLIP ([0-9.]+) \(weighted quartiles ([0-9.]+), ([0-9.]+), ([0-9.]+)\) as shown over (\d+) pixels$/;

// The page's middle pixels of the canvas as colours, without dither.
const colorsAt = (page, points) => page.evaluate((places) => {
  const canvas = document.getElementById("canvas"), copy = document.createElement("canvas");
  const [zoom, x, y] = canvas.dataset.view.split(" ").map(Number);
  copy.width = canvas.width;
  copy.height = canvas.height;
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  return places.map(([px, py]) => [...context.getImageData(Math.floor((px + 0.5 - x) * zoom), Math.floor((py + 0.5 - y) * zoom), 1, 1).data].slice(0, 3));
}, points);

await runAll(async () => {
  const url = await startServer();
  const complaints = [];
  const page = await openPage(complaints, { viewport: { width: 1400, height: 1000 } });
  // From outside: there is nothing around the box, and its edges cover parts of pixels.
  const camera = { eye: [0.3, 1.2, 6], target: [0, 1, 0], up: [0, 1, 0], yfov_deg: 30 };
  const scene = { file: join(process.cwd(), "tests/scenes/cornell-box/cornell-box.glb"), camera };
  const image = { width: 256, height: 256, view: "linear" }, layers = ["beauty", "albedo", "depth"];
  const fine = submit(url, { scene, image, layers, sampling: { spp: 64 }, filter: { method: "none" } });
  const rough = submit(url, { scene, image, layers, sampling: { spp: 4 }, filter: { method: "none" } });
  const plain = submit(url, { image: { width: 96, height: 96 }, layers: ["beauty"], scene: { file: scene.file, camera: { eye: [0, 1, 2.5], target: [0, 1, 0], up: [0, 1, 0], yfov_deg: 20 } } });
  const files = {};
  for (const [name, id] of Object.entries({ fine, rough, plain })) {
    await until("finished", async () => (await (await page.request.get(`${url}/v1/jobs/${id}`)).json()).state === "finished", 60);
    files[name] = join(tmp, `${name}.exr`);
    writeFileSync(files[name], await (await page.request.get(`${url}/v1/jobs/${id}/frames/1/image.exr`)).body());
  }
  const read = (name) => { const { buffer, byteOffset, byteLength } = readFileSync(files[name]); return readExr(buffer.slice(byteOffset, byteOffset + byteLength)); };
  const told = (...options) => JSON.parse(execFileSync(join(build, "shearwater"), ["compare", files.fine, files.rough, "--ssim", "--flip", ...options]).toString());
  const exr = await read("fine");

  await test("the page's metrics are the command's, on the same numbers", async () => {
    const pixels = ({ width, height, channels }) => ({ seen: new Uint8Array(width * height).fill(1),
      numbers: Float32Array.from({ length: width * height * 3 }, (_, i) => channels.get("RGB"[i % 3])[Math.floor(i / 3)]) });
    const first = pixels(exr), other = pixels(await read("rough")), { width, height } = exr;
    for (const view of [{ exposure: 0, gamma: 1, curve: "linear" }, { exposure: 1.5, gamma: 1.4, curve: "filmic" }, { exposure: 0.5, gamma: 1, curve: "agx" }]) {
      const pair = displayPair({ width, height, first, other, view }), similarity = ssim(pair), errors = flip(pair);
      const { ssim: wanted, flip: figures } = told("--exposure", String(view.exposure), "--gamma", String(view.gamma), "--curve", view.curve);
      const near = (a, b, what) => expect(Math.abs(a - b) < 1e-5, `${what}: ${a} here, ${b} by the command`);
      near(similarity.mean, wanted, "SSIM");
      near(errors.mean, figures.mean, "FLIP");
      near(errors.max, figures.max, "the largest");
      ["q1", "median", "q3"].forEach((name, i) => near(errors.quartiles[i], figures[name], name));
      expect(wanted < 0.95 && figures.mean > 0.02, "the two pictures are too alike for this test");
    }
  });

  await test("figures of what is in sight are the command's, of halves of floats", async () => {
    await page.goto(`${url}/#/jobs/${fine}`);
    await until("the picture", async () => (await look(page)).lit > 0.2);
    await page.selectOption("#compare", "wipe");
    await page.fill("#other-job", rough);
    await page.press("#other-job", "Enter");
    await page.selectOption("#other-layer", "beauty");
    const seen = async () => FIGURES.exec(await text(page, "alike"))?.slice(1).map(Number);
    // Until the page has seen that the two are others, it shows the figures of those before.
    const shows = async (pixels, { ssim: similarity, flip: errors }) => {
      const wanted = [similarity, errors.mean, errors.q1, errors.median, errors.q3];
      let found = null;
      const near = async () => { found = await seen() ?? found; return found?.[5] === pixels && wanted.every((v, i) => Math.abs(found[i] - v) < 1e-3); };
      await until("the command's figures", near, 30).catch((error) => { throw new Error(`${error.message}: ${found} here, ${wanted} by the command`); });
    };
    await shows(256 * 256, told());
    await press(page, "e", "e", "e", "e", "t");
    await shows(256 * 256, told("--exposure", "1", "--curve", "filmic"));
    await press(page, "0", "1", "+", "+", "+");
    const inSight = async () => {
      const [zoom, x, y] = (await viewText(page)).split(" ").map(Number);
      const size = await page.locator("#canvas").evaluate(({ width, height }) => [width, height]);
      const [x0, y0] = [x, y].map((v) => Math.max(0, Math.floor(v))), [x1, y1] = [x + size[0] / zoom, y + size[1] / zoom].map((v) => Math.min(256, Math.ceil(v)));
      return [x0, y0, x1 - x0, y1 - y0];
    };
    const part = await until("the part in sight", async () => { const [x, y, w, h] = await inSight(); return w * h < 256 * 256 && (await seen())?.[5] === w * h && [x, y, w, h]; });
    await shows(part[2] * part[3], told("--crop", part.join()));
    await press(page, "f");
  });

  await test("maps are shown with a legend, where they differ", async () => {
    const map = {};
    for (const [key, metric] of [["i", "ssim"], ["y", "flip"]]) {
      await press(page, key);
      expect(await page.inputValue("#compare") === metric, `the key ${key} shows ${await page.inputValue("#compare")}`);
      await until("the legend", async () => (await page.isVisible("#legend")) && FIGURES.test(await text(page, "alike")));
      await settle(page, 500);
      await save(page, metric);
      // The empty corner is dark, the box is not.
      map[metric] = await colorsAt(page, [[3, 3], [128, 100]]);
      const [corner, box] = map[metric].map((color) => color.reduce((a, b) => a + b, 0));
      expect(box > corner + 15, `${metric}: the corner is ${map[metric][0]}, the box ${map[metric][1]}`);
      await press(page, "Shift+ArrowRight");
      const said = await until("what the probe says", async () => /SSIM ([0-9.−e]+) {2}FLIP ([0-9.e−]+)$/.exec(await text(page, "readout")));
      expect(Number(said[1].replace("−", "-")) < 1 && Number(said[2].replace("−", "-")) > 0, said[0]);
    }
    await press(page, "y");
    await until("the legend to go", () => page.isHidden("#legend"));
    await page.selectOption("#layer", "depth");
    await page.selectOption("#compare", "wipe");
    await until("that depths are no pictures", async () => /shown as pictures/.test(await text(page, "alike")));
    await page.selectOption("#layer", "beauty");
  });

  await test("the page goes on while a worker computes", async () => {
    await page.selectOption("#compare", "flip");
    await until("figures", async () => FIGURES.test(await text(page, "alike")));
    // Were it one task of the page, it would be the longest by far.
    const [took, longest] = await page.evaluate(() => new Promise((done) => {
      const alike = document.getElementById("alike"), before = alike.textContent, start = performance.now();
      let most = 0;
      const watch = new PerformanceObserver((list) => { for (const { duration } of list.getEntries()) most = Math.max(most, duration); });
      watch.observe({ entryTypes: ["longtask"] });
      document.getElementById("exposure").value = "2";
      document.getElementById("exposure").dispatchEvent(new Event("input"));
      const look = () => {
        if (!/^SSIM \d/.test(alike.textContent) || alike.textContent === before) setTimeout(look, 10);
        else done([performance.now() - start, most]);
      };
      look();
    }));
    expect(took > 100 && longest < took / 2, `a task of ${longest} ms while ${took} ms of judging went on`);
    await press(page, "0");
  });

  await test("axe-core finds nothing with a map and its legend", async () => {
    await until("figures", async () => FIGURES.test(await text(page, "alike")));
    const session = await page.context().newCDPSession(page);
    await session.send("Runtime.evaluate", { expression: axe });
    const { result } = await session.send("Runtime.evaluate", { awaitPromise: true, returnByValue: true,
      expression: `axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"] }).then((r) => r.passes.length + ";" + r.violations.map((v) => v.id + ": " + v.nodes.map((n) => n.target.join(" ")).join(", ")).join("; "))` });
    await session.detach();
    expect(/^\d\d+;$/.test(result.value), result.value);
    await page.selectOption("#compare", "off");
  });

  await test("the probe's alpha is the EXR's", async () => {
    const { width, channels } = exr, alpha = channels.get("A");
    const partial = alpha.findIndex((a, i) => a > 0.2 && a < 0.8 && i % width > 20 && i % width < 236);
    expect(partial > 0, "the test's picture has no edge");
    await press(page, "f");
    const [zoom, x, y] = (await viewText(page)).split(" ").map(Number), box = await page.locator("#stage").boundingBox();
    for (const i of [partial, 3 * width + 3, 128 * width + 128]) {
      const px = i % width, py = Math.floor(i / width);
      await page.mouse.move(box.x + 1 + (px + 0.5 - x) * zoom, box.y + 1 + (py + 0.5 - y) * zoom);
      const said = await until("its alpha", async () => new RegExp(`^${px}, ${py}: .*A ([0-9.e-]+)$`).exec(await text(page, "readout")));
      expect(Math.abs(Number(said[1]) - alpha[i]) < 5e-4, `${said[0]}, the file has ${alpha[i]}`);
    }
    expect(alpha[3 * width + 3] === 0 && alpha[128 * width + 128] === 1, "the test's picture is not what it was");
  });

  await test("what is transparent shows black, a checkerboard, white or alpha", async () => {
    await press(page, "d");
    const places = [[3, 3], [4, 4], [5, 3], [6, 4], [7, 5], [128, 128]], seen = {};
    for (const name of ["black", "checkerboard", "white", "alpha"]) {
      expect(await page.inputValue("#behind") === name, `it is ${await page.inputValue("#behind")}, not ${name}`);
      await settle(page, 200);
      seen[name] = (await colorsAt(page, places)).map((color) => color.join());
      await save(page, `behind-${name}`);
      await press(page, "h");
    }
    await press(page, "d");
    expect(seen.black[0] === "0,0,0" && seen.white[0] === "255,255,255" && seen.alpha[0] === "0,0,0", JSON.stringify(seen));
    expect(new Set(seen.checkerboard.slice(0, 5)).size === 2, `no checkerboard: ${seen.checkerboard}`);
    expect(seen.black[5] === seen.white[5] && seen.black[5] === seen.checkerboard[5] && seen.alpha[5] === "255,255,255", "what is opaque lets the ground through");
  });

  await test("a file's alpha is shown, too", async () => {
    await page.selectOption("#compare", "toggle");
    await page.setInputFiles("#other-file", { name: "mine.exr", mimeType: "image/x-exr", buffer: readFileSync(files.rough) });
    // The panel of comparing moves the picture away under a mouse that rests.
    await until("both alphas", async () => {
      const box = await page.locator("#stage").boundingBox();
      await page.mouse.move(box.x + box.width / 2 + Math.random(), box.y + box.height / 2);
      return /A [0-9.e-]+ \| .*A [0-9.e-]+/.test(await text(page, "readout"));
    });
    await page.selectOption("#compare", "off");
  });

  await test("feeds without alpha, and opaque pictures, carry none", async () => {
    const formats = async (job, query) => {
      const bytes = new Uint8Array(await (await page.request.get(`${url}/v1/jobs/${job}/pixels?${query}`)).body()), found = new Set();
      let size = 0;
      for (const { w, alpha } of new BlockParser().feed(bytes)) if (w) found.add(alpha !== null);
      size = bytes.length;
      return { found: [...found].sort().join(), size };
    };
    expect((await formats(fine, "layer=beauty")).found === "false", "alpha comes unasked");
    expect((await formats(fine, "layer=beauty&alpha=1")).found === "false,true", "no block with alpha, or none without");
    expect((await formats(fine, "layer=albedo&alpha=1")).found === "false", "albedo has alpha");
    const [without, asked] = [await formats(plain, "layer=beauty"), await formats(plain, "layer=beauty&alpha=1")];
    expect(asked.found === "false" && asked.size === without.size, `${asked.size} bytes of an opaque picture, ${without.size} without asking`);
    const bad = await page.request.get(`${url}/v1/jobs/${fine}/pixels?alpha=yes`);
    expect(bad.status() === 400 && /alpha must be/.test(await bad.text()), `${bad.status()}`);
    await page.goto(`${url}/#/jobs/${plain}`);
    await until("the picture", async () => (await look(page)).lit > 0.8, 60, () => canvasText(page));
    await until("no ground to choose for an opaque picture", () => page.isHidden("#behind-label"));
  });

  await test("what lies under a job's first blocks keeps its alpha", () => {
    const [old, now] = [new LayerImage(), new LayerImage()], [half, one] = [0x3800, 0x3c00];
    const block = (x, alpha) => ({ x, y: 0, w: 64, h: 64, numbers: new Uint16Array(64 * 64 * 3), alpha });
    old.resize(128, 64);
    for (const x of [0, 64]) old.put(block(x, new Uint16Array(64 * 64).fill(half)));
    now.showOver(old);
    expect(now.alpha?.every((v) => v === half), "the older one's alpha is gone");
    now.put(block(64, null));
    expect(now.alpha.every((v, i) => v === (i % 128 < 64 ? half : one)), "an opaque block shows what was under it");
    expect(old.alpha.every((v) => v === half) && now.alphaAt(3, 3) === null && now.alphaAt(70, 3) === 1, "the two are mixed up");
  });

  await test("nothing was written to the console", () => { expect(complaints.filter((line) => !/400|503/.test(line)).length === 0, complaints.join("; ")); });
});
