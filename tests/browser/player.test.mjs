// Sequences in the viewer: the strip of frames, the player, the onion and the flicker map. TAP on standard output.
//   node tests/browser/player.test.mjs BUILD_DIR
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { readExr } from "../../web/picture/exr_file.js";
import { FrameCache, MOST_BYTES } from "../../web/sequence/frame_cache.js";
import { moving, movingJob } from "../bench/scenes/moving.mjs";
import { clean, narrow } from "./axe.mjs";
import { expect, openPage, runAll, settle, shots, startServer, submit, test, text, tmp, until, viewText } from "./house.mjs";

const FRAMES = 6, WIDE = 96, TALL = 72, POINT = { x: 40, y: 50 };
const press = async (page, ...keys) => { await page.focus("#stage"); for (const key of keys) await page.keyboard.press(key); };
const save = (page, name) => page.screenshot({ path: join(shots, `player-${name}.png`), fullPage: true });

// The jobs of the test: a block that goes across.
function writeScene() {
  const file = join(tmp, "moving.glb");
  writeFileSync(file, moving.find(({ name }) => name === "object").glb());
  return (more = {}) => movingJob(file, FRAMES, WIDE, 4, { layers: ["beauty", "depth"], ...more });
}

// A frame's light, three numbers a pixel: what the EXR has.
async function beautyOf(page, url, id, frame) {
  const body = await (await page.request.get(`${url}/v1/jobs/${id}/frames/${frame}/image.exr`)).body();
  const { channels } = await readExr(body.buffer.slice(body.byteOffset, body.byteOffset + body.byteLength));
  return ["R", "G", "B"].map((name) => channels.get(name));
}

// The first number that the readout says of a pixel.
const redAt = async (page) => Number(/-?\d[\d.e+-]*/.exec((await text(page, "readout")).split(/[:=]/).slice(1).join(" ").trim())?.[0]);
const near = (a, b, part = 2e-3) => Math.abs(a - b) <= part * Math.max(Math.abs(a), Math.abs(b)) + 1e-4;

await runAll(async () => {
  const url = await startServer(0, ["--worker-threads", "1"]);
  const complaints = [], job = writeScene();
  const page = await openPage(complaints, { viewport: { width: 1400, height: 1000 } });
  const shownFrame = async () => Number(/^Frame (\d+);/.exec(await text(page, "frame-text"))?.[1]);
  const at = (frame) => until(`frame ${frame}`, async () => (await shownFrame()) === frame, 60, () => text(page, "frame-text"));
  const slow = submit(url, job({ image: { width: 320, height: 240 }, sampling: { spp: 25 }, filter: { temporal: "none" } }));

  await test("while a job runs its strip says which frames wait, are traced and are done", async () => {
    const words = () => page.locator("#strip .state").allTextContents();
    await page.goto(`${url}/#/jobs/${slow}`);
    await until("all states", async () => {
      const seen = await words();
      return seen.length === FRAMES && ["waiting", "tracing", "done"].every((word) => seen.includes(word));
    }, 120, async () => (await words()).join());
  });

  await test("a frame that is done can be seen while others are traced, one that waits cannot", async () => {
    await page.locator("#strip button").last().click();
    await until("a word", async () => (await text(page, "frame-text")) === `Frame ${FRAMES} is not there: waiting.`);
    await page.locator("#strip button").first().click();
    await at(1);
    await until("its picture", async () => (await viewText(page)).endsWith("320 240"));
    await save(page, "running");
    await page.click("#frame-forming");
    await until("the frame that forms", async () => /^The frame that forms/.test(await text(page, "frame-text")));
    await until("finished", async () => /finished/.test(await text(page, "progress-text")), 120);
    await until("six done", async () => (await page.locator("#strip .state", { hasText: "done" }).count()) === FRAMES);
  });

  const id = submit(url, job()), frames = new Map();
  await test("the frames of a finished sequence have pictures in the strip", async () => {
    await page.goto(`${url}/#/jobs/${id}`);
    await until("finished", async () => /finished/.test(await text(page, "progress-text")), 90);
    await until("the pictures", async () => (await page.locator("#strip canvas[data-drawn]").count()) === FRAMES);
    for (let frame = 1; frame <= FRAMES; frame++) frames.set(frame, await beautyOf(page, url, id, frame));
    await save(page, "strip");
  });

  const pixel = POINT.y * WIDE + POINT.x;
  await test("each frame is shown with its own values, by keys", async () => {
    await at(1);
    await press(page, "1");
    await settle(page, 200);
    const [zoom, x, y] = (await viewText(page)).split(" ").map(Number), box = await page.locator("#canvas").boundingBox();
    await page.mouse.move(box.x + (POINT.x + 0.5 - x) * zoom, box.y + (POINT.y + 0.5 - y) * zoom);
    const differ = new Set();
    for (let frame = 1; frame <= FRAMES; frame++) {
      await at(frame);
      const wanted = frames.get(frame)[0][pixel];
      await until("its value", async () => near(await redAt(page), wanted), 20, async () => `${await text(page, "readout")}, not ${wanted}`);
      differ.add(wanted);
      if (frame < FRAMES) await page.keyboard.press(">");
    }
    expect(differ.size > 2, "the frames are alike");
    await page.keyboard.press("<");
    await at(FRAMES - 1);
    await press(page, "Home");
    await at(1);
    await press(page, "End");
    await at(FRAMES);
    expect((await page.getAttribute("#download-exr", "href")).includes(`/frames/${FRAMES}/`), "another download");
  });

  await test("zoom, exposure and layer stay as they are between frames", async () => {
    await press(page, "+", "ArrowLeft", "e", "e");
    const before = [await viewText(page), await text(page, "exposure-text")].join();
    await press(page, "Home");
    await at(1);
    expect([await viewText(page), await text(page, "exposure-text")].join() === before, "the view has changed");
    await page.selectOption("#layer", "depth");
    await press(page, ">");
    await at(2);
    expect(await page.inputValue("#layer") === "depth", "the layer has changed");
    await page.selectOption("#layer", "beauty");
    await press(page, "0", "f");
  });

  await test("the slider scrubs, with a name and a value in words", async () => {
    await page.focus("#frame");
    await page.keyboard.press("Home");
    await at(1);
    await page.keyboard.press("ArrowRight");
    await at(2);
    expect(await page.getAttribute("#frame", "aria-valuetext") === "frame 2, done", await page.getAttribute("#frame", "aria-valuetext"));
    expect(await page.getByRole("slider", { name: "Frame" }).count() === 1, "no name");
  });

  await test("the strip is one stop of the Tab key, its arrows move, Enter shows", async () => {
    expect(await page.locator('#strip button[tabindex="0"]').count() === 1, "not one stop");
    await page.locator('#strip button[tabindex="0"]').focus();
    await page.keyboard.press("End");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("Enter");
    await at(FRAMES - 1);
    expect(/Frame 5 *done/.test(await page.textContent('#strip button[aria-current="true"]')), "another is marked");
  });

  await test("it plays all frames in turn, at the job's rate at most, and stops", async () => {
    await page.evaluate(() => {
      window.seen = [];
      new MutationObserver(() => {
        const frame = Number(/^Frame (\d+);/.exec(document.getElementById("frame-text").textContent)?.[1]);
        if (frame && frame !== window.seen.at(-1)?.frame) window.seen.push({ frame, at: performance.now() });
      }).observe(document.getElementById("frame-text"), { childList: true, characterData: true, subtree: true });
    });
    await press(page, "k");
    await until("twice around", () => page.evaluate((n) => window.seen.length > 2 * n, FRAMES));
    expect(await page.getAttribute("#play", "aria-pressed") === "true", "not said");
    await press(page, "k");
    const seen = await page.evaluate(() => window.seen);
    seen.slice(1).forEach(({ frame }, i) => expect(frame === seen[i].frame % FRAMES + 1, `${frame} after ${seen[i].frame}`));
    const rate = 1000 * (seen.length - 1) / (seen.at(-1).at - seen[0].at);
    expect(rate < 24 * 1.15, `${rate} frames a second`);
    const stopped = await shownFrame();
    await settle(page, 400);
    expect(await shownFrame() === stopped, "it goes on");
    expect(await page.getAttribute("#play", "aria-pressed") === "false", "not said");
  });

  // At 1:1, the screen's bytes of the pixel without dither.
  const byteAt = (x, y) => page.evaluate(([px, py]) => {
    const canvas = document.getElementById("canvas"), [zoom, left, top] = canvas.dataset.view.split(" ").map(Number);
    const context = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
    context.drawImage(canvas, 0, 0);
    return [...context.getImageData(Math.floor((px + 0.5 - left) * zoom), Math.floor((py + 0.5 - top) * zoom), 1, 1).data].slice(0, 3);
  }, [x, y]);
  const srgb = (v) => Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * Math.min(1, v) ** (1 / 2.4) - 0.055));
  // Where two frames differ most, of what is not too bright to show.
  const mostUnlike = (a, b) => {
    const unlike = a[0].map((v, i) => Math.max(...a.map((c) => c[i]), ...b.map((c) => c[i])) < 1 ? Math.abs(v - b[0][i]) : 0);
    return unlike.indexOf(Math.max(...unlike));
  };

  await test("an onion is the mean of the frame and the one before, also while frames change", async () => {
    await page.selectOption("#curve", "linear");
    await press(page, "0", "1", "d", "Home", "q");
    await page.selectOption("#curve", "linear");
    expect(await page.inputValue("#compare") === "onion" && await page.isChecked("#other-before"), "no onion");
    for (const frame of [2, 3]) {
      await press(page, ">");
      await at(frame);
      const [now, before] = [frames.get(frame), frames.get(frame - 1)], i = mostUnlike(now, before);
      const wanted = now.map((plane, c) => srgb((plane[i] + before[c][i]) / 2)), alone = now.map((plane) => srgb(plane[i]));
      expect(wanted.some((v, c) => Math.abs(v - alone[c]) > 4), "the frames are alike there");
      await until("the mean", async () => (await byteAt(i % WIDE, Math.floor(i / WIDE))).every((v, c) => Math.abs(v - wanted[c]) <= 1), 20,
        async () => `${await byteAt(i % WIDE, Math.floor(i / WIDE))}, not ${wanted}`);
    }
    await press(page, "f");
    await settle(page, 200);
    await save(page, "onion");
    await press(page, "q", "d", "0");
  });

  await test("a difference with the frame before has its figures", async () => {
    await press(page, "End");
    await at(FRAMES);
    await press(page, "x");
    await page.check("#other-before");
    const [now, before] = [frames.get(FRAMES), frames.get(FRAMES - 1)];
    const rmse = Math.sqrt(now.reduce((sum, plane, c) => sum + plane.reduce((s, v, i) => s + (v - before[c][i]) ** 2, 0), 0) / (3 * WIDE * TALL));
    await until("the RMSE", async () => near(Number(/RMSE ([\d.e-]+)/.exec(await text(page, "figures"))?.[1]), rmse, 0.01), 20,
      async () => `${await text(page, "figures")}, not ${rmse}`);
    await press(page, "x");
  });

  await test("the flicker map has each pixel's mean change from frame to frame", async () => {
    const wanted = [0, 1, 2].map((c) => frames.get(1)[c].map((_, i) => {
      let sum = 0;
      for (let frame = 2; frame <= FRAMES; frame++) sum += Math.abs(frames.get(frame)[c][i] - frames.get(frame - 1)[c][i]);
      return sum / (FRAMES - 1);
    }));
    const gray = wanted[0].map((v, i) => (v + wanted[1][i] + wanted[2][i]) / 3);
    const mean = gray.reduce((sum, v) => sum + v, 0) / gray.length, most = gray.indexOf(Math.max(...gray)), least = gray.indexOf(Math.min(...gray));
    await press(page, "1", "z");
    const said = async () => /mean change ([\d.e-]+) over 5 pairs of frames/.exec(await text(page, "flicker-text"))?.[1];
    await until("the mean", async () => near(Number(await said()), mean, 0.01), 20, async () => `${await text(page, "flicker-text")}, not ${mean}`);
    expect(await page.getAttribute("#flicker", "aria-pressed") === "true", "not said");
    const [zoom, x, y] = (await viewText(page)).split(" ").map(Number), box = await page.locator("#canvas").boundingBox();
    for (const i of [most, least]) {
      await page.mouse.move(box.x + (i % WIDE + 0.5 - x) * zoom, box.y + (Math.floor(i / WIDE) + 0.5 - y) * zoom);
      await until("a pixel's", async () => {
        const shown = /flicker ([\d.e-]+)/.exec(await text(page, "readout"))?.[1];
        return shown !== undefined && Math.abs(Number(shown) - gray[i]) < 0.02 * gray[i] + 1e-3;
      }, 20, async () => `${await text(page, "readout")}, not ${gray[i]}`);
    }
    await settle(page, 300);
    const light = async (i) => (await byteAt(i % WIDE, Math.floor(i / WIDE))).reduce((a, b) => a + b);
    expect(await light(most) > await light(least) + 200, `${await light(most)} and ${await light(least)}`);
    expect(/steady/.test(await text(page, "legend")) && await page.isVisible("#legend"), "no legend");
    await press(page, "f");
    await settle(page, 400);
    await save(page, "flicker");
    await press(page, "z");
    expect(await text(page, "flicker-text") === "", "it stays");
    await until("no legend", () => page.isHidden("#legend"));
    await press(page, "z", "<");
    await at(FRAMES - 1);
    expect(await page.getAttribute("#flicker", "aria-pressed") === "false", "another frame does not end it");
  });

  await test("what was fetched is not fetched again", async () => {
    let asked = 0;
    page.on("request", (request) => { asked += /pixels/.test(request.url()); });
    await press(page, "Home");
    for (let frame = 2; frame <= FRAMES; frame++) { await press(page, ">"); await at(frame); }
    expect(asked === 0, `${asked} times`);
  });

  await test("the keys stand in the sheet, and nothing is in the way of readers", async () => {
    const sheet = await page.textContent("#keys-list");
    for (const words of ["play or stop a sequence", "previous frame, next frame", "onion", "flicker map"]) expect(sheet.includes(words), words);
    await clean(page, "a sequence");
    await narrow(page, "a sequence", (width) => join(shots, `player-${width}.png`));
  });

  await test("what is kept of large frames is bounded, and what is in sight stays", async () => {
    const forgotten = [], seen = new Set(), nothing = () => {};
    const cache = new FrameCache({ onBlock: nothing, onWhole: nothing, onForget: ({ frame }) => forgotten.push(frame), isSeen: (source) => seen.has(source) });
    cache.open(id);
    const first = cache.get("beauty", 1);
    first.image.numbers = new Uint16Array(MOST_BYTES / 2 / 4 - 1); // four have room
    first.whole = true;
    const kept = () => [...cache.kept.values()].map(({ frame }) => frame).sort((a, b) => a - b).join();
    cache.want("beauty", [1, 2, 3, 4, 5, 6]);
    expect(kept() === "1,2,3,4", kept());
    seen.add(first);
    cache.want("beauty", [6, 5, 7, 8, 9]);
    expect(kept() === "1,5,6,7,8" && forgotten.sort().join() === "2,3,4", `${kept()}; gone ${forgotten}`);
    expect([...cache.kept.values()].filter(({ live }) => live).length === 2, "not two at a time");
    cache.open(null);
    expect(kept() === "" && cache.room === 2, `${kept()}, ${cache.room}`);
  });

  await test("a list of frames begins with its own first, and a frame that it lacks is refused", async () => {
    const list = submit(url, job({ frames: "3-5x2" }));
    await page.goto(`${url}/#/jobs/${list}`);
    await until("finished", async () => /finished/.test(await text(page, "progress-text")), 90);
    await at(3);
    await until("the picture", async () => (await viewText(page)).endsWith(`${WIDE} ${TALL}`));
    await press(page, ">");
    await at(5);
    const status = async (query) => (await page.request.get(`${url}/v1/jobs/${list}/pixels?${query}`)).status();
    expect(await status("frame=3") === 200, "3 is refused");
    expect(await status("frame=4") === 409, "4 is not refused");
    for (const odd of ["", "-1", "1.5", "3x", "99999999999"]) expect(await status(`frame=${odd}`) === 400, `${odd} is not refused`);
  });

  await test("a job of one frame has neither strip nor player", async () => {
    const one = submit(url, job({ frames: { first: 2 } }));
    await page.goto(`${url}/#/jobs/${one}`);
    await until("finished", async () => /finished/.test(await text(page, "progress-text")), 90);
    expect(await page.isHidden("#player") && await page.isHidden("#strip"), "they are there");
    await press(page, "k", ">");
  });

  await test("nothing was complained of", async () => expect(complaints.length === 0, complaints.join("\n")));
});
