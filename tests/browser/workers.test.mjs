// The page of the workers in a real Chromium against a real coordinator with two. TAP.
//   node tests/browser/workers.test.mjs BUILD_DIR
import { join } from "node:path";
import { clean, narrow } from "./axe.mjs";
import { expect, openPage, runAll, shots, startServer, submit, test, text, until } from "./house.mjs";

await runAll(async () => {
  const url = await startServer();
  const complaints = [];
  const page = await openPage(complaints);
  const shot = (name) => join(shots, `workers-${name}.png`);
  const get = async (path) => (await page.request.get(url + path)).json();
  const cards = page.locator("#rows li");
  const fact = (card, name) => card.evaluate((li, wanted) => {
    const terms = [...li.querySelectorAll("dt")];
    return terms.find((dt) => dt.textContent === wanted).nextElementSibling.textContent;
  }, name);

  await test("both workers are there, with what the roster says of them", async () => {
    await page.goto(`${url}/workers.html`);
    await until("two cards", async () => (await cards.count()) === 2);
    expect(await page.title() === "Workers · Shearwater", await page.title());
    for (const worker of (await get("/v1/workers")).workers) {
      const card = page.locator(`#rows li[data-worker="${worker.id}"]`);
      expect(await card.locator("h2").textContent() === worker.name, "another name");
      expect(await fact(card, "Instructions") === worker.isa, await fact(card, "Instructions"));
      expect(await fact(card, "Build") === worker.build, await fact(card, "Build"));
      expect(await fact(card, "Threads") === String(worker.threads), await fact(card, "Threads"));
      expect(await fact(card, "Works on") === "nothing", await fact(card, "Works on"));
      expect((await fact(card, "Where")).includes(String(worker.pid)), await fact(card, "Where"));
    }
  });

  const id = submit(url, { image: { width: 1024, height: 1024 }, sampling: { spp: 400, tile_px: 32 } });
  await test("what they work on, and how fast, is told while they do", async () => {
    await until("their job", async () => (await cards.locator(`a[href="./#/jobs/${id}"]`).count()) === 2);
    await until("rates", async () => {
      const rates = [await fact(cards.nth(0), "Rate"), await fact(cards.nth(1), "Rate")];
      return rates.every((rate) => parseFloat(rate) > 0 && parseFloat(rate.split(", ")[1]) > 0);
    });
    await page.screenshot({ path: shot("working") });
  });

  await test("a worker is drained by a key, finishes what it holds, and the others go on", async () => {
    const card = cards.nth(0);
    await card.locator("button").focus();
    await page.evaluate(() => { window.button = document.activeElement; });
    await page.keyboard.press("Enter");
    await until("its state", async () => (await card.locator(".state").textContent()) === "draining");
    expect(/ is draining$/.test(await text(page, "said")), await text(page, "said"));
    await until("its hands empty", async () => (await fact(card, "Works on")) === "nothing", 60);
    expect(await page.evaluate(() => window.button === document.activeElement && window.button.textContent === "Take back"), "the focus is not on “Take back”");
    const done = await fact(card, "Done");
    await page.waitForTimeout(1500);
    expect(await fact(card, "Done") === done, "it goes on");
    expect((await fact(cards.nth(1), "Works on")).includes("frame 1"), "the other one rests, too");
    await page.screenshot({ path: shot("draining") });
    await clean(page, "a worker that drains");
  });

  await test("it is taken back by a click", async () => {
    const card = cards.nth(0);
    await card.locator("button").click();
    await until("work", async () => (await fact(card, "Works on")).includes("frame 1"));
    expect(await card.locator("button").textContent() === "Drain", "still to be taken back");
  });

  await test("a worker that goes leaves the page, one that comes joins it", async () => {
    const { workers } = await get("/v1/workers");
    process.kill(workers[0].pid, "SIGKILL");
    await until("its card gone", async () => (await page.locator(`#rows li[data-worker="${workers[0].id}"]`).count()) === 0);
    await until("its successor", async () => (await cards.count()) === 2);
    await page.request.delete(`${url}/v1/jobs/${id}`);
  });

  await test("no violations of WCAG 2.2 AA, on a phone or at 200 % either", async () => {
    await clean(page, "the workers");
    await narrow(page, "the workers", (width) => shot(String(width)));
  });

  await test("nothing was written to the console", async () => {
    expect(complaints.length === 0, complaints.join("; "));
  });
});
