// The viewer in a real Chromium against a real coordinator with real workers. TAP on standard output.
//   node tests/browser/viewer.test.mjs BUILD_DIR
// Screenshots are kept in BUILD_DIR/screenshots.
import { join } from "node:path";
import { expect, look, openPage, runAll, shots, startServer, stopServer, submit, test, text, until } from "./house.mjs";

await runAll(async () => {
  const url = await startServer();
  const port = new URL(url).port;
  const complaints = [];
  const page = await openPage(complaints);

  await test("the page loads and says that it is connected", async () => {
    const response = await page.goto(url);
    expect(response.status() === 200, `status ${response.status()}`);
    expect(/default-src 'none'/.test(response.headers()["content-security-policy"] ?? ""), "no strict policy");
    await until("connected", async () => (await text(page, "connection")) === "connected");
    await until("two workers", async () => /^2 workers/.test(await text(page, "workers")));
  });

  // Large enough that it cannot be over before the page has looked.
  const slow = submit(url, { image: { width: 640, height: 640 }, sampling: { spp: 49, tile_px: 32 } });
  await test("a submitted job appears in the list", async () => {
    await until("the job's row", () => page.locator(`a[href="#/jobs/${slow}"]`).count());
    await page.click(`a[href="#/jobs/${slow}"]`);
    await until("the job's title", async () => (await text(page, "job-title")).includes(slow));
  });

  await test("the picture fills in tile by tile, and the progress follows", async () => {
    const seen = [];
    let last = 0;
    await until("finished", async () => {
      const { lit } = await look(page);
      if (lit > last + 0.02) seen.push(last = lit);
      const value = await page.locator("#progress").evaluate((bar) => bar.value);
      const words = await text(page, "progress-text");
      expect(value < 100 || /finished/.test(words), `100 % with "${words}"`);
      if (seen.length === 4) await page.screenshot({ path: join(shots, "viewer-filling.png") });
      return /finished/.test(words);
    }, 120);
    expect(seen.length >= 4, `the picture grew in ${seen.length} steps only: ${seen}`);
    expect((await text(page, "progress-text")).startsWith("100 %"), "not 100 % at the end");
  });

  await test("the finished picture is whole", async () => {
    await until("all pixels", async () => (await look(page)).lit > 0.8);
    await page.screenshot({ path: join(shots, "viewer-finished.png") });
  });

  await test("exposure brightens the picture at once", async () => {
    const before = (await look(page)).mean;
    await page.locator("#exposure").focus();
    for (let i = 0; i < 8; i++) await page.keyboard.press("ArrowRight");
    await until("brighter", async () => (await look(page)).mean > before * 1.2);
    expect((await text(page, "exposure-text")) === "+2 EV", await text(page, "exposure-text"));
    await page.click("#exposure-reset");
    await until("as before", async () => Math.abs((await look(page)).mean - before) < 1);
  });

  await test("other layers can be looked at", async () => {
    const before = (await look(page)).mean;
    await page.selectOption("#layer", "albedo");
    await until("another picture", async () => {
      const now = await look(page);
      return now.lit > 0.8 && Math.abs(now.mean - before) > 3;
    });
    await page.screenshot({ path: join(shots, "viewer-albedo.png") });
    await page.selectOption("#layer", "normal");
    await until("normals", async () => (await look(page)).lit > 0.8);
    await page.selectOption("#layer", "beauty");
    await until("the beauty again", async () => Math.abs((await look(page)).mean - before) < 1);
  });

  await test("the download links give an EXR and a PNG", async () => {
    for (const kind of ["exr", "png"]) {
      const href = await page.getAttribute(`#download-${kind}`, "href");
      const answer = await page.request.get(new URL(href, url).href);
      const head = [...(await answer.body()).subarray(0, 4)];
      expect(answer.status() === 200, `${kind}: ${answer.status()}`);
      expect(kind === "exr" ? head[0] === 0x76 && head[1] === 0x2f : head[1] === 0x50, `${kind}: ${head}`);
    }
  });

  await test("a running job can be cancelled in the page", async () => {
    const id = submit(url, { image: { width: 1024, height: 1024 }, sampling: { spp: 400 } });
    await page.goto(`${url}/#/jobs/${id}`);
    await until("running", async () => /running/.test(await text(page, "progress-text")));
    await page.click("#cancel");
    await page.click("#cancel-yes");
    await until("cancelled", async () => /cancelled/.test(await text(page, "announce")));
    expect(await page.locator("#cancel").isDisabled(), "it can be cancelled twice");
  });

  await test("a job that does not exist is said to be none", async () => {
    await page.goto(`${url}/#/jobs/00000000000000000000000000`);
    await until("the sentence", async () => /no such job/.test(await text(page, "problem")));
  });

  await test("nothing was written to the console but that", () => {
    const others = complaints.filter((line) => !/404/.test(line));
    expect(others.length === 0, others.join("; "));
  });

  await test("the page says when the connection is lost, and finds it again", async () => {
    await stopServer();
    await until("lost", async () => /no connection|connecting/.test(await text(page, "connection")));
    await startServer(port);
    await until("connected", async () => (await text(page, "connection")) === "connected");
  });

  await test("everything fits a phone's width", async () => {
    await page.setViewportSize({ width: 360, height: 740 });
    await page.goto(`${url}/#/jobs/${slow}`);
    await until("the picture", async () => (await look(page)).lit > 0.8);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    await page.screenshot({ path: join(shots, "viewer-phone.png") });
    expect(wide <= 360, `the page is ${wide} px wide`);
  });
});
