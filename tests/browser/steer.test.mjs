// Steering in the viewer: pause, resume, cancel, priority, what goes first, more samples; by mouse and
// by keys, against a real server and workers. TAP on standard output.
//   node tests/browser/steer.test.mjs BUILD_DIR
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { expect, look, openPage, runAll, settle, shots, startServer, submit, test, text, until, viewText } from "./house.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const LONG = { image: { width: 512, height: 512 }, sampling: { spp: 1024, tile_px: 32 }, filter: { method: "none" }, layers: ["beauty"] };
const SMALL = { image: { width: 192, height: 192 }, sampling: { spp: 4, seed: 5, tile_px: 32 }, filter: { method: "none" }, layers: ["beauty", "albedo"] };

await runAll(async () => {
  const url = await startServer();
  const complaints = [];
  const page = await openPage(complaints, { reducedMotion: "reduce" });
  const get = async (id) => (await fetch(`${url}/v1/jobs/${id}`)).json();
  const purge = (id) => fetch(`${url}/v1/jobs/${id}?purge=1`, { method: "DELETE" });
  const open = async (id) => {
    await page.goto(`${url}/#/jobs/${id}`);
    await until("the job's controls", async () => !await page.locator("#more").isDisabled());
  };
  const press = async (key) => { await page.focus("#stage"); await page.keyboard.press(key); };
  const said = (words) => until(words, async () => (await text(page, "said")).includes(words));
  const begun = (id) => until("some tiles", async () => (await get(id)).progress.tiles_done > 20, 60);
  // The canvas's place of a pixel of the picture.
  const place = (x, y) => page.evaluate(([px, py]) => {
    const canvas = document.getElementById("canvas"), box = canvas.getBoundingClientRect();
    const [zoom, left, top] = canvas.dataset.view.split(" ").map(Number), ratio = canvas.width / box.width;
    return { x: box.left + (px - left) * zoom / ratio, y: box.top + (py - top) * zoom / ratio };
  }, [x, y]);
  const clean = async (what) => {
    const session = await page.context().newCDPSession(page);
    const run = (expression, awaitPromise = false) => session.send("Runtime.evaluate", { expression, awaitPromise, returnByValue: true });
    await run(axe);
    const { result } = await run(`axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"] })
      .then((r) => JSON.stringify([r.passes.length, r.violations.map((v) => v.id + ": " + v.nodes.map((n) => n.target + n.failureSummary).join(", "))]))`, true);
    await session.detach();
    const [passes, violations] = JSON.parse(result.value);
    expect(passes > 15 && violations.length === 0, `${what}: ${passes} rules, ${violations.join("; ")}`);
  };

  const long = submit(url, LONG);

  await test("a click pauses a job, another lets it go on", async () => {
    await open(long);
    await begun(long);
    await page.click("#pause");
    await said("Job paused");
    expect((await get(long)).paused, "the server does not know");
    expect(await text(page, "pause") === "Resume" && /paused/.test(await text(page, "progress-text")), await text(page, "progress-text"));
    await page.waitForTimeout(1000);
    const { tiles_done: at } = (await get(long)).progress;
    await page.waitForTimeout(1000);
    expect((await get(long)).progress.tiles_done === at, "it goes on");
    await page.screenshot({ path: join(shots, "steer-paused.png"), fullPage: true });
    await clean("a paused job");
    await page.click("#pause");
    await said("Job resumed");
    await until("more tiles", async () => (await get(long)).progress.tiles_done > at);
  });

  await test("the key p does the same", async () => {
    await press("p");
    await said("Job paused");
    expect((await get(long)).paused, "not paused");
    await press("p");
    await said("Job resumed");
    expect(!(await get(long)).paused, "still paused");
  });

  await test("what somebody else does is shown at once", async () => {
    const patch = (change) => fetch(`${url}/v1/jobs/${long}`, { method: "PATCH", headers: { "Content-Type": "application/json" }, body: JSON.stringify(change) });
    await patch({ paused: true, priority: -30 });
    await until("both", async () => await text(page, "pause") === "Resume" && await text(page, "priority") === "−30", 3);
    await patch({ paused: false, priority: 0 });
    await until("both again", async () => await text(page, "pause") === "Pause" && await text(page, "priority") === "0", 3);
  });

  await test("priority goes up and down, by mouse and by keys", async () => {
    await page.click("#priority-raise");
    await said("Priority 10");
    await press(".");
    await said("Priority 20");
    expect((await get(long)).priority === 20 && await text(page, "priority") === "20", "the two differ");
    await page.click("#priority-lower");
    await said("Priority 10");
    await press(",");
    await said("Priority 0");
  });

  await test("what is seen goes first at a key, and nothing at another", async () => {
    await press("f");
    for (let i = 0; i < 2; i++) await press("+");
    await press("v");
    await said("Rendering first");
    const { region } = await get(long);
    const [zoom, left, top] = (await viewText(page)).split(" ").map(Number);
    expect(region.x === Math.max(0, Math.floor(left)) && region.y === Math.max(0, Math.floor(top)) && region.width < 512 && zoom > 1, JSON.stringify(region));
    await press("Shift+V");
    await said("No area goes first");
    expect((await get(long)).region === null, "it stays");
    await page.click("#first-seen");
    await until("a region", async () => (await get(long)).region !== null);
    await page.click("#first-clear");
    await until("none", async () => (await get(long)).region === null);
    await press("f");
  });

  await test("a region is drawn with the mouse, and its pixels come first", async () => {
    await press("p");
    await said("Job paused");
    await page.click("#first-draw");
    expect(await page.getAttribute("#first-draw", "aria-pressed") === "true", "not pressed");
    await page.locator("#stage").scrollIntoViewIfNeeded();
    const from = await place(384, 400), to = await place(480, 496);
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    await page.mouse.move((from.x + to.x) / 2, (from.y + to.y) / 2);
    await page.screenshot({ path: join(shots, "steer-drawing.png") });
    await page.mouse.move(to.x, to.y);
    await page.mouse.up();
    await said("Rendering first");
    const { region } = await get(long);
    expect(Math.abs(region.x - 384) <= 2 && Math.abs(region.y - 400) <= 2 && Math.abs(region.width - 96) <= 3 && Math.abs(region.height - 96) <= 3, JSON.stringify(region));
    expect(await page.getAttribute("#first-draw", "aria-pressed") === "false", "it draws on");
    expect((await text(page, "first-text")).includes(`${region.width} × ${region.height}`), await text(page, "first-text"));
    // Of the tiles that land next most are the region's.
    const tiles = await page.evaluate((id) => new Promise((done) => {
      const got = [], events = new EventSource(`/v1/jobs/${id}/events`);
      events.addEventListener("tile", (event) => { got.push(JSON.parse(event.data)); if (got.length === 8) { events.close(); done(got); } });
      events.onopen = () => document.getElementById("pause").click();
    }), long);
    const inside = tiles.filter(({ x, y }) => x >= 352 && x < 512 && y >= 384 && y < 512).length;
    expect(inside >= 5, JSON.stringify(tiles));
    await page.screenshot({ path: join(shots, "steer-region.png") });
    await press("Shift+V");
    await said("No area goes first");
  });

  await test("what is near the mouse goes first while that is on", async () => {
    await page.click("#follow");
    await page.locator("#stage").scrollIntoViewIfNeeded();
    const from = await place(100, 200), to = await place(300, 200);
    await page.mouse.move(from.x, from.y);
    // A hand that is fast: a move every five milliseconds.
    await page.evaluate(async ([x, y, far]) => {
      const ask = window.fetch;
      window.asked = []; // when; others look at the job's address, too
      window.fetch = (address, options) => {
        if (options?.method === "PATCH") window.asked.push(performance.now());
        return ask(address, options);
      };
      for (let i = 0; i < 200; i++) {
        document.getElementById("canvas").dispatchEvent(new PointerEvent("pointermove", { clientX: x + i * far / 200, clientY: y, bubbles: true }));
        await new Promise((done) => setTimeout(done, 5));
      }
    }, [from.x, from.y, to.x - from.x]);
    await page.mouse.move(to.x, to.y);
    await until("the last point", async () => { const { near } = await get(long); return near && Math.abs(near.x - 300) <= 1 && Math.abs(near.y - 200) <= 1; });
    const starts = await page.evaluate(() => window.asked);
    const gaps = starts.slice(1).map((at, i) => at - starts[i]);
    expect(gaps.length >= 2 && gaps.every((gap) => gap >= 145), `asked after ${gaps.map(Math.round)} ms`);
    await clean("following");
    await press("Shift+ArrowRight");
    await until("the key's point", async () => { const { near } = await get(long); return near && near.x >= 300 && near.x <= 302; });
    await press("n");
    await until("no point", async () => (await get(long)).near === null);
    expect(await page.getAttribute("#follow", "aria-pressed") === "false", "it is still on");
  });

  await test("leaving the job takes the point back", async () => {
    await press("n");
    const at = await place(50, 50);
    await page.mouse.move(at.x, at.y);
    await until("a point", async () => (await get(long)).near !== null);
    await page.evaluate(() => { location.hash = "#/"; });
    await until("none", async () => (await get(long)).near === null);
    await open(long);
  });

  await test("cancelling asks first; Escape and the first button let it go on", async () => {
    await page.focus("#cancel");
    await page.keyboard.press("Enter");
    await until("the question", () => page.locator("#cancel-dialog").evaluate((d) => d.open));
    await page.screenshot({ path: join(shots, "steer-cancel.png") });
    await clean("the question");
    await page.keyboard.press("Escape");
    await until("no question", () => page.locator("#cancel-dialog").evaluate((d) => !d.open));
    await press("Delete");
    await until("the question", () => page.locator("#cancel-dialog").evaluate((d) => d.open));
    expect(await page.evaluate(() => document.activeElement.id) === "cancel-no", "the dangerous button has the focus");
    await page.keyboard.press("Enter");
    await until("no question", () => page.locator("#cancel-dialog").evaluate((d) => !d.open));
    expect((await get(long)).state === "running", "it is cancelled");
  });

  await test("a paused job is cancelled by keys alone", async () => {
    await press("p");
    await said("Job paused");
    await press("Delete");
    await page.keyboard.press("Tab");
    await page.keyboard.press("Enter");
    await until("cancelled", async () => (await get(long)).state === "cancelled");
    await until("its controls are off", async () => await page.locator("#pause").isDisabled() && await page.locator("#cancel").isDisabled());
    await press("p");
    await said("The job has ended");
  });

  await test("more samples: one job, four times as many, over the old picture", async () => {
    const small = submit(url, SMALL);
    await open(small);
    await until("finished", async () => /finished/.test(await text(page, "progress-text")), 60);
    await until("the picture", async () => (await look(page)).lit > 0.8);
    for (const key of ["+", "+"]) await press(key);
    const view = await viewText(page);
    // A job before it in the queue holds the new one back, so that what lies under it is seen.
    const hold = submit(url, { ...LONG, priority: 50 });
    await begun(hold);
    await press("s");
    await until("another job", async () => !page.url().endsWith(small));
    const more = page.url().split("/").pop();
    await until("its own note", async () => (await text(page, "under-text")).includes(small.slice(-6)));
    expect((await look(page)).lit > 0.5, "the old picture is gone");
    const kept = await viewText(page);
    expect(kept === view, `the view has moved from ${view} to ${kept}`);
    await page.screenshot({ path: join(shots, "steer-more.png"), fullPage: true });
    expect((await get(more)).progress.tiles_done === 0, "it had begun");
    await press("Shift+ArrowRight");
    await until("the probe tells that there is nothing yet", async () => /nothing yet/.test(await text(page, "readout")));
    await clean("more samples");
    await purge(hold);
    await until("finished", async () => (await get(more)).state === "finished", 60);
    await until("all of it is the new one's", () => page.locator("#under-text").isHidden());
    // The same as the job that is submitted with them.
    const direct = submit(url, { ...SMALL, sampling: { ...SMALL.sampling, spp: 16 } });
    await until("the direct one", async () => (await get(direct)).state === "finished", 60);
    const exr = async (id) => Buffer.from(await (await fetch(`${url}/v1/jobs/${id}/frames/1/image.exr`)).arrayBuffer());
    expect((await exr(more)).equals(await exr(direct)), "the bytes differ");
    expect((await get(more)).document.sampling.spp === 16, "not four times the samples");
    // Again from the first: the same job.
    await open(small);
    await page.dblclick("#more");
    await until("the same job", async () => page.url().endsWith(more));
  });

  await test("a follow-up that was cancelled is not given again", async () => {
    const small = submit(url, { ...SMALL, sampling: { ...SMALL.sampling, seed: 6 } });
    await open(small);
    const hold = submit(url, { ...LONG, priority: 50 });
    await begun(hold);
    await press("s");
    await until("another job", async () => !page.url().endsWith(small));
    const first = page.url().split("/").pop();
    await until("its controls", async () => !await page.locator("#cancel").isDisabled());
    await press("Delete");
    await page.click("#cancel-yes");
    await until("cancelled", async () => (await get(first)).state === "cancelled");
    await open(small);
    await press("s");
    await until("a third job", async () => !page.url().endsWith(small));
    expect(!page.url().endsWith(first), "the cancelled one");
    await purge(hold);
  });

  await test("the sheet of keys has them", async () => {
    await press("?");
    const sheet = await text(page, "keys-list");
    for (const words of ["pause or resume", "priority", "the visible part first", "near the mouse", "more samples", "cancel the job"])
      expect(sheet.includes(words), words);
    // Keys pressed with Shift are lines of their own: the same arrows without it do something else.
    const keys = await page.$$eval("#keys-list dt", (terms) => terms.flatMap((term) => {
      const caps = [...term.querySelectorAll("kbd")].map((cap) => cap.textContent.toLowerCase());
      return caps[0] === "shift" ? caps.slice(1).map((cap) => `shift+${cap}`) : caps;
    }));
    const twice = keys.filter((key, i) => keys.indexOf(key) !== i);
    expect(keys.length > 30 && twice.length === 0, `${keys.length} keys, twice: ${twice}`);
    await page.screenshot({ path: join(shots, "steer-keys.png") });
    await page.keyboard.press("Escape");
  });

  await test("on a phone nothing is cut off", async () => {
    await page.setViewportSize({ width: 320, height: 700 });
    await settle(page, 200);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    await page.screenshot({ path: join(shots, "steer-phone.png"), fullPage: true });
    expect(wide <= 320, `${wide} px`);
    await clean("320 px");
  });

  await test("nothing was written to the console", () => expect(complaints.length === 0, complaints.join("; ")));
});
