// The picture of the viewer: zoom, values, probe, display, comparison. TAP on standard output.
//   node tests/browser/picture.test.mjs BUILD_DIR
import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { deflateSync } from "node:zlib";
import { figures } from "../../web/compare/compare.js";
import { readExr } from "../../web/picture/exr_file.js";
import { halfTable } from "../../web/picture/half.js";
import { LayerImage } from "../../web/picture/layer_image.js";
import { unfilteredTwin } from "../../web/picture/unfiltered.js";
import { build, expect, look, openPage, runAll, settle, shots, startServer, submit, test, text, tmp, until, viewText } from "./house.mjs";

const LAYERS = ["beauty", "direct", "indirect", "albedo", "normal", "depth", "error", "samples", "visibility", "filter_width", "slope_max"];

// The half float nearest to a value: what the feed has of it.
function toHalf(v) {
  const table = halfTable(), sign = v < 0 ? 0x8000 : 0, size = Math.abs(v);
  let low = 0, high = 0x7bff;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (table[middle] <= size) low = middle;
    else high = middle - 1;
  }
  if (low === 0x7bff) return table[low | sign];
  const under = size - table[low], over = table[low + 1] - size;
  return table[(under < over || (under === over && low % 2 === 0) ? low : low + 1) | sign];
}

// An EXR file of one deflated block of lines: as many channels of floats as told.
function exrFile({ width, height, channels, block }) {
  const words = (...numbers) => Buffer.from(Int32Array.from(numbers).buffer), text = (s) => Buffer.from(`${s}\0`);
  const list = Array.from({ length: channels }, (_, i) => Buffer.concat([text(`c${i}`), words(2, 0, 1, 1)]));
  const attribute = (name, type, body) => Buffer.concat([text(name), text(type), words(body.length), body]);
  const head = Buffer.concat([words(20000630, 2), attribute("channels", "chlist", Buffer.concat([...list, text("")])),
    attribute("compression", "compression", Buffer.of(3)), attribute("dataWindow", "box2i", words(0, 0, width - 1, height - 1)), text("")]);
  const bytes = Buffer.concat([head, words(head.length + 8, 0), words(0, block.length), block]);
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
}

const fault = async (promise) => { try { await promise; } catch (error) { return error.message; } return "none"; };
const press = async (page, ...keys) => { await page.focus("#stage"); for (const key of keys) await page.keyboard.press(key); };
const view = async (page) => (await viewText(page)).split(" ").map(Number);
const mean = async (page) => { await settle(page, 150); return (await look(page)).mean; };
// Of layers that were flicked through before some may be asked for again, while the server is busy.
async function meanAtRest(page) {
  let first = NaN;
  await until("a picture that stands still", async () => {
    const last = first;
    await settle(page, 800);
    first = await mean(page);
    return first === last;
  });
  return first;
}
const save = (page, name) => page.screenshot({ path: join(shots, `picture-${name}.png`), fullPage: true });

await runAll(async () => {
  const url = await startServer();
  const complaints = [];
  const page = await openPage(complaints, { viewport: { width: 1400, height: 1000 } });
  const id = submit(url, { layers: LAYERS, image: { width: 320, height: 320, view: "linear" }, filter: { method: "sheared" }, effects: { indirect_bounces: 1 } });
  const plain = submit(url, { layers: LAYERS.slice(0, 3), filter: { method: "average", indirect: "average" }, image: { width: 320, height: 320, pixel_type: "half" } });
  await page.goto(`${url}/#/jobs/${id}`);
  await until("finished", async () => /finished/.test(await text(page, "progress-text")), 90);
  await until("the picture", async () => (await look(page)).lit > 0.8);
  const bodyOf = async (job) => {
    const body = await (await page.request.get(`${url}/v1/jobs/${job}/frames/1/image.exr`)).body();
    return readExr(body.buffer.slice(body.byteOffset, body.byteOffset + body.byteLength));
  };

  await test("zoom, pan, fit and 1:1, by keys, wheel and mouse", async () => {
    const [fitted] = await view(page);
    await press(page, "1");
    await until("1:1", async () => (await view(page))[0] === 1);
    await press(page, "+", "+");
    await until("4:1", async () => (await view(page))[0] === 4);
    const before = await view(page);
    await press(page, "ArrowRight");
    await until("moved right", async () => (await view(page))[1] === before[1] + 16);
    const box = await page.locator("#stage").boundingBox();
    const under = async () => { const [zoom, x] = await view(page); return x + 300 / zoom; };
    const point = await under();
    await page.mouse.move(box.x + 300 + 1, box.y + 200);
    await page.mouse.wheel(0, -100);
    await until("the wheel zooms", async () => (await view(page))[0] > 4.5);
    expect(Math.abs(await under() - point) < 0.5, "what was under the mouse went away");
    const [zoom, x] = await view(page);
    await page.mouse.down();
    await page.mouse.move(box.x + 360, box.y + 200, { steps: 4 });
    await page.mouse.up();
    await until("dragged", async () => (await view(page))[1] < x - 40 / zoom);
    await press(page, "f");
    await until("fitted", async () => (await view(page))[0] === fitted);
  });

  await test("two fingers zoom where they are", async () => {
    const touch = await openPage(complaints, { viewport: { width: 500, height: 800 }, hasTouch: true });
    await touch.goto(`${url}/#/jobs/${id}`);
    await until("the picture", async () => (await look(touch)).lit > 0.8);
    const [fitted] = await view(touch), box = await touch.locator("#stage").boundingBox();
    const session = await touch.context().newCDPSession(touch);
    const fingers = (type, apart) => session.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] :
      [-1, 1].map((side, id) => ({ x: box.x + 200 + side * apart, y: box.y + 200, id })) });
    await fingers("touchStart", 30);
    for (const apart of [40, 60, 90]) await fingers("touchMove", apart);
    await fingers("touchEnd");
    await until("zoomed", async () => (await view(touch))[0] > fitted * 1.8);
    await touch.close();
  });

  await test("the probe shows the EXR's values, and so do the pixels", async () => {
    const exr = await bodyOf(id);
    const names = { beauty: ["R", "G", "B"], normal: ["normal.X", "normal.Y", "normal.Z"], depth: ["depth.Z"], samples: ["samples.N"] };
    await press(page, "1");
    const box = await page.locator("#stage").boundingBox();
    for (const [layer, channels] of Object.entries(names)) {
      await page.selectOption("#layer", layer);
      await until(layer, async () => (await look(page)).lit > 0.1);
      for (const [dx, dy] of [[-80.5, -60.5], [3.5, 100.5], [90.5, -10.5]]) {
        await page.mouse.move(box.x + box.width / 2 + dx, box.y + box.height / 2 + dy);
        const line = await until("a value", async () => /^\d+, \d+: [^n]/.test(await text(page, "readout")) && text(page, "readout"));
        const [, x, y, values] = /^(\d+), (\d+): (.*)$/.exec(line);
        const shown = values.split(/\s+/).map((v) => Number(v.replace("−", "-")));
        const want = channels.map((name) => exr.channels.get(name)[Number(y) * exr.width + Number(x)]);
        const exact = layer === "depth" || layer === "samples";
        expect(shown.length === want.length, line);
        want.forEach((v, i) => {
          const wanted = Number((exact ? v : toHalf(v)).toPrecision(exact ? 9 : 5));
          expect(shown[i] === wanted, `${layer}: ${line}, the file has ${want}`);
        });
      }
    }
    await page.selectOption("#layer", "beauty");
    await settle(page, 400);
    await press(page, "+", "+", "+", "+", "+", "+", "+");
    await press(page, "Shift+ArrowRight", "Enter");
    await until("a pinned probe", async () => (await page.locator("#pins li").count()) === 1);
    await save(page, "values");
    await press(page, "f");
  });

  await test("a half float EXR has exactly what the probe says", async () => {
    await until("finished", async () => (await (await page.request.get(`${url}/v1/jobs/${plain}`)).json()).state === "finished", 60);
    const exr = await bodyOf(plain);
    await page.goto(`${url}/#/jobs/${plain}`);
    await until("the picture", async () => (await look(page)).lit > 0.8);
    await press(page, "Shift+ArrowRight", "Shift+ArrowDown");
    const [, x, y, values] = /^(\d+), (\d+): (.*)$/.exec(await until("a value", async () => /: \d/.test(await text(page, "readout")) && text(page, "readout")));
    const want = ["R", "G", "B"].map((name) => exr.channels.get(name)[Number(y) * exr.width + Number(x)]);
    expect(exr.half.has("R"), "the file has no half floats");
    values.split(/\s+/).forEach((v, i) => expect(Number(v) === Number(want[i].toPrecision(5)), `${values}, the file has ${want}`));
    await page.goto(`${url}/#/jobs/${id}`);
    await until("the picture", async () => (await look(page)).lit > 0.8);
  });

  await test("gamma, filmic curve, marks and dither change what is shown, without a request", async () => {
    const asked = [];
    const listen = (request) => { if (/pixels|image/.test(request.url())) asked.push(request.url()); };
    page.on("request", listen);
    const before = await mean(page);
    await press(page, "g", "g", "g");
    await until("gamma that brightens", async () => await mean(page) > before + 3);
    await press(page, "0", "t");
    const filmic = await mean(page);
    expect(Math.abs(filmic - before) > 0.5, "the filmic curve changes nothing");
    await save(page, "filmic");
    await press(page, "0", "e", "e", "e", "e", "e", "e", "e", "e", "o");
    const marked = await mean(page);
    await save(page, "clipped");
    await press(page, "o");
    await until("marks", async () => Math.abs(await mean(page) - marked) > 0.5);
    await press(page, "0", "d");
    await mean(page);
    await press(page, "d");
    await page.selectOption("#shown-as", "colour");
    await until("false colours", async () => Math.abs(await mean(page) - before) > 3);
    await page.selectOption("#shown-as", "picture");
    page.off("request", listen);
    expect(asked.length === 0, asked.join());
  });

  await test("layers of numbers are shown in false colours, slopes by their signs", async () => {
    for (const [layer, shown] of [["depth", "colour"], ["error", "colour"], ["filter_width", "colour"], ["visibility", "colour"], ["slope_max", "sign"], ["normal", "vector"]]) {
      await page.selectOption("#layer", layer);
      await until(`${layer} is there`, async () => /nothing yet/.test(await text(page, "readout")) === false && (await look(page)).mean > 5);
      await settle(page, 400);
      expect(await page.inputValue("#shown-as") === shown, `${layer} as ${await page.inputValue("#shown-as")}`);
      await save(page, `layer-${layer}`);
    }
    await page.selectOption("#layer", "beauty");
    await press(page, "l");
    expect(await page.inputValue("#layer") === LAYERS[1], "the key l does not go to the next layer");
    await press(page, "Shift+L");
  });

  await test("numbers that are none are marked", async () => {
    const colors = await page.evaluate(async () => {
      const [{ Picture }, { LayerImage }] = await Promise.all([import("/picture/picture.js"), import("/picture/layer_image.js")]);
      const canvas = document.createElement("canvas");
      canvas.width = 128; canvas.height = 64;
      const image = new LayerImage();
      image.resize(128, 64);
      const numbers = new Float32Array(128 * 64 * 3).fill(0.1);
      numbers.fill(NaN, 0, 30 * 3);
      numbers.fill(Infinity, 100 * 3, 128 * 3);
      image.put({ x: 0, y: 0, w: 128, h: 64, numbers });
      const viewport = { zoom: 1, x: 0, y: 0, canvas: { width: 128, height: 64 } };
      const display = { exposure: 0, gamma: 1, low: 0, high: 1, dither: false, clipMarks: false, logarithmic: false, shownAs: "picture", curve: "linear" };
      const picture = new Picture(canvas, () => ({ first: image, other: null, viewport, display, compare: { shown: "off", line: () => [1, 0, 0] } }));
      const at = () => {
        picture.paint(picture.look());
        const bytes = new Uint8Array(128 * 4);
        picture.gl.readPixels(0, 63, 128, 1, picture.gl.RGBA, picture.gl.UNSIGNED_BYTE, bytes);
        return [0, 60, 102].map((x) => [...bytes.subarray(x * 4, x * 4 + 3)].join());
      };
      const near = at();
      viewport.zoom = 0.25; // four by four pixels on one, of which one row is bad
      picture.paint(picture.look());
      const far = new Uint8Array(4);
      picture.gl.readPixels(0, 63, 1, 1, picture.gl.RGBA, picture.gl.UNSIGNED_BYTE, far);
      return { near, far: [...far.subarray(0, 3)].join() };
    });
    expect(colors.near[0] === "255,0,255" && colors.near[2] === "0,255,255", JSON.stringify(colors));
    expect(Math.abs(Number(colors.near[1].split(",")[0]) - 89) <= 1, `0.1 is shown as ${colors.near[1]}, not sRGB's 89`);
    expect(colors.far === "255,0,255", `zoomed out, a NaN vanishes: ${colors.far}`);
  });

  await test("graphics that are taken away are spoken of, and come back with the picture", async () => {
    const before = await meanAtRest(page);
    await page.evaluate(() => {
      window.taken = document.getElementById("canvas").getContext("webgl2").getExtension("WEBGL_lose_context");
      window.taken.loseContext();
    });
    await until("the word of it", async () => (await page.isVisible("#canvas-note")) && /lost the picture's graphics/.test(await text(page, "canvas-note")));
    await press(page, "l"); // what is asked for meanwhile is drawn then
    await settle(page);
    expect(await page.isVisible("#canvas-note"), "another layer hides it");
    await page.evaluate(() => window.taken.restoreContext());
    await until("no word of it", () => page.isHidden("#canvas-note"));
    await until("another layer", async () => Math.abs(await mean(page) - before) > 3);
    await press(page, "Shift+L");
    await until("the picture", async () => Math.abs(await mean(page) - before) < 0.01);
  });

  await test("two layers: wipe at an angle, toggle, difference", async () => {
    const first = await meanAtRest(page);
    await press(page, "w");
    await page.selectOption("#other-layer", "albedo");
    await until("albedo", async () => Math.abs(await mean(page) - first) > 3);
    const wiped = await mean(page);
    await press(page, "]", "]", "]", "]", "]", "]", "]", "]", "]", "]");
    await until("the wipe, moved", async () => Math.abs(await mean(page) - first) < Math.abs(wiped - first));
    const box = await page.locator("#stage").boundingBox();
    await page.mouse.move(box.x + box.width * 0.7, box.y + 100);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.5, box.y + 100, { steps: 4 });
    await page.mouse.up();
    expect(await page.inputValue("#wipe-position") === "50", `the line was dragged to ${await page.inputValue("#wipe-position")}`);
    await press(page, "r", "r");
    await save(page, "wipe");
    await press(page, "b");
    await until("the other layer", async () => Math.abs(await mean(page) - first) > 3);
    await press(page, "b");
    await until("the layer, back", async () => Math.abs(await mean(page) - first) < 0.2);
    await press(page, "x");
    await save(page, "difference");
    await press(page, "x");
  });

  await test("two jobs: the figures are those of the command", async () => {
    await page.selectOption("#compare", "wipe");
    await page.fill("#other-job", plain);
    await page.press("#other-job", "Enter");
    await page.selectOption("#other-layer", "beauty");
    await press(page, "f");
    const files = [];
    for (const job of [id, plain]) {
      await until("a finished job", async () => (await (await page.request.get(`${url}/v1/jobs/${job}`)).json()).state === "finished");
      const file = join(tmp, `${job}.exr`);
      writeFileSync(file, await (await page.request.get(`${url}/v1/jobs/${job}/frames/1/image.exr`)).body());
      files.push(file);
    }
    const told = execFileSync(join(build, "shearwater"), ["compare", ...files]).toString();
    const number = (from, name) => Number(new RegExp(`${name}"?[\\s:]+([0-9.e+-]+)`, "i").exec(from)?.[1]);
    const alike = (said) => ["rmse", "relmse"].every((name) => Math.abs(number(said, name) / number(told, name) - 1) < 5e-3); // half floats here
    const shown = () => text(page, "figures"); // of the layer before, until the page finds the time
    await until("figures like the command's", async () => {
      const said = await shown();
      return /^RMSE .* over 102400 pixels in sight$/.test(said) && alike(said);
    }, 60, async () => `${await shown()} here, ${told}`);
    await save(page, "filtered-unfiltered");
    await page.fill("#other-job", "nonsense");
    await page.press("#other-job", "Tab");
    await until("the fault", async () => /not a job/.test(await text(page, "other-problem")));
    await page.selectOption("#compare", "off");
  });

  await test("filtered and unfiltered at one key, of the same samples", async () => {
    const before = await meanAtRest(page);
    await press(page, "u");
    await until("the twin's picture", async () => Number((/RMSE ([0-9.]+), .* over 102400 pixels in sight$/.exec(await text(page, "figures")) ?? [])[1]) > 0.002, 60);
    const twin = await page.inputValue("#other-job");
    const { document } = await (await page.request.get(`${url}/v1/jobs/${twin}`)).json();
    const own = (await (await page.request.get(`${url}/v1/jobs/${id}`)).json()).document;
    expect(document.filter.method === "average" && document.filter.indirect === "average", JSON.stringify(document.filter));
    expect(JSON.stringify(document.sampling) === JSON.stringify(own.sampling), "other samples");
    expect(await page.getAttribute("#flip", "aria-pressed") === "true", "the filtered one is shown");
    await save(page, "unfiltered");
    await press(page, "u");
    expect(await page.getAttribute("#flip", "aria-pressed") === "false", "the key does not go back");
    await until("the filtered picture, back", async () => Math.abs(await mean(page) - before) < 0.2, 60, async () => `${await mean(page)}, ${before} before`);
    await press(page, "x");
    await page.selectOption("#shown-as", "sign");
    await settle(page, 600);
    await save(page, "difference-signs");
    await page.selectOption("#shown-as", "picture");
    await page.selectOption("#compare", "off");
  });

  await test("the twin leaves out what a filter or a target error would add", async () => {
    const real = globalThis.fetch, image = { width: 32, height: 32 }, lens = { aperture_radius: 0.02, focus_distance: 2 };
    for (const changes of [{ sampling: { spp: 16, lens_extra: 9 }, lens, filter: { lens: "sheared" } }, { sampling: { spp: 16, target_error: 0.5 } }]) {
      const job = submit(url, { image, layers: ["beauty"], ...changes });
      globalThis.fetch = (path, options) => real(url + path, options);
      const twin = await unfilteredTwin(job).finally(() => { globalThis.fetch = real; });
      const { sampling } = (await (await page.request.get(`${url}/v1/jobs/${twin.id}`)).json()).document;
      expect(sampling.spp === 16 && !sampling.lens_extra && !sampling.target_error && !sampling.max_spp, JSON.stringify(sampling));
    }
  });

  await test("a file of one's own: the EXR is equal, the PNG nearly so", async () => {
    await page.selectOption("#compare", "wipe");
    const exr = await page.request.get(`${url}/v1/jobs/${id}/frames/1/image.exr`), png = await page.request.get(`${url}/v1/jobs/${id}/frames/1/image.png`);
    await page.setInputFiles("#other-file", { name: "mine.exr", mimeType: "image/x-exr", buffer: await exr.body() });
    const rmse = async () => Number(/RMSE ([0-9.e-]+)/.exec(await text(page, "figures"))?.[1] ?? NaN);
    await until("figures", async () => await rmse() < 1e-3); // the feed's half floats
    expect((await page.locator("#other-layer option").count()) === LAYERS.length, "layers of the file are missing");
    await page.setInputFiles("#other-file", { name: "mine.png", mimeType: "image/png", buffer: await png.body() });
    await until("figures of the PNG", async () => await rmse() > 1e-3); // the lamp is clipped
    await page.setInputFiles("#other-file", { name: "bad.exr", mimeType: "image/x-exr", buffer: Buffer.from([0x76, 0x2f, 0x31, 1, 2, 0, 0, 0, 0]) });
    await until("the fault", async () => /has no channels/.test(await text(page, "other-problem")));
    const whole = await exr.body();
    await page.setInputFiles("#other-file", { name: "cut.exr", mimeType: "image/x-exr", buffer: whole.subarray(0, whole.length / 2) });
    await until("that it is cut off", async () => /cut off/.test(await text(page, "other-problem")));
    for (const [number, name] of [[4, "PIZ"], [8, "DWAA"]]) { // as jobs of image.exr_compression have them
      const other = Buffer.from(whole);
      other[whole.indexOf("compression\0compression\0") + 28] = number;
      await page.setInputFiles("#other-file", { name: `${name}.exr`, mimeType: "image/x-exr", buffer: other });
      await until(`what to do with ${name}`, async () => (await text(page, "other-problem")).includes(`compressed with ${name}, which this page does not read: choose its job`));
    }
    await page.selectOption("#compare", "off");
  });

  await test("EXR files that say they are huge are refused", async () => {
    const fine = await readExr(exrFile({ width: 64, height: 16, channels: 2, block: deflateSync(Buffer.alloc(64 * 16 * 8, 128)) }));
    expect(fine.width === 64 && fine.channels.size === 2, "a file of that kind is not read");
    const many = await fault(readExr(exrFile({ width: 8192, height: 8192, channels: 9, block: Buffer.alloc(1) })));
    expect(/9 channels of 8192 x 8192 pixels/.test(many), many);
    const short = await fault(readExr(exrFile({ width: 8, height: 8192, channels: 1, block: Buffer.alloc(1) })));
    expect(/cut off/.test(short), short);
    const bomb = await fault(readExr(exrFile({ width: 4096, height: 16, channels: 1, block: deflateSync(Buffer.alloc(1 << 26)) })));
    expect(/larger than its lines/.test(bomb), bomb);
  });

  await test("figures of every third pixel are nearly those of all", () => {
    const area = { x0: 0, y0: 0, x1: 96, y1: 90 };
    const [first, other] = [0, 1].map((noise) => {
      const image = new LayerImage();
      image.resize(96, 90);
      image.put({ x: 0, y: 0, w: 96, h: 90, numbers: Float32Array.from({ length: 96 * 90 * 3 }, (_, i) => 1 + noise * 0.1 * Math.sin(i * 7.13)) });
      return image;
    });
    const all = figures(first, other, area), some = figures(first, other, area, 3);
    expect(all.pixels === 96 * 90 && some.pixels === 32 * 30, `${all.pixels} and ${some.pixels} pixels`);
    expect(Math.abs(some.rmse / all.rmse - 1) < 0.05, `${some.rmse} of some, ${all.rmse} of all`);
  });

  await test("nothing was written to the console but what was cut", () => {
    const others = complaints.filter((line) => !/ERR_|404|400|409|503/.test(line)); // 503: busy with layers that were passed by
    expect(others.length === 0, others.join("; "));
  });
});
