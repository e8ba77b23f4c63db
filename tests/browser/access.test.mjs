// The viewer for everybody: axe-core at WCAG 2.2 AA, keys, announcements. TAP on standard output.
//   node tests/browser/access.test.mjs BUILD_DIR
import { join } from "node:path";
import { clean as cleanPage } from "./axe.mjs";
import { expect, look, openPage, runAll, settle, shots, startServer, submit, test, text, until } from "./house.mjs";

await runAll(async () => {
  const url = await startServer();
  const complaints = [];
  const page = await openPage(complaints, { reducedMotion: "reduce", bypassCSP: false });

  const clean = (what) => cleanPage(page, what);

  const slow = submit(url, { image: { width: 512, height: 512 }, sampling: { spp: 100, tile_px: 32 }, layers: ["beauty", "albedo", "depth"] });

  await test("progress is announced every ten percent at most", async () => {
    await page.goto(url);
    await page.evaluate(() => {
      window.said = [];
      new MutationObserver(() => window.said.push(document.getElementById("announce").textContent))
        .observe(document.getElementById("announce"), { childList: true, characterData: true, subtree: true });
    });
    await page.evaluate((id) => { location.hash = `#/jobs/${id}`; }, slow);
    await until("finished", async () => /finished/.test(await text(page, "progress-text")), 120);
    const said = (await page.evaluate(() => window.said)).filter(Boolean);
    const tens = said.map((line) => /^(\d+) percent$/.exec(line)?.[1]).filter(Boolean).map((n) => Math.floor(n / 10));
    expect(said.includes("Job finished"), said.join());
    expect(tens.length >= 1 && tens.every((n, i) => i === 0 || n > tens[i - 1]), `announced ${said.join(", ")}`);
    expect(await page.getAttribute("#announce", "role") === "status", "no role");
  });

  await test("a finished job has no violations of WCAG 2.2 AA", async () => {
    await until("the picture", async () => (await look(page)).lit > 0.8);
    await clean("the job");
  });

  await test("neither have comparison, probes, false colours and the sheet of keys", async () => {
    await page.focus("#stage");
    for (const key of ["w", "Shift+ArrowRight", "Enter", "b"]) await page.keyboard.press(key);
    await page.selectOption("#layer", "depth");
    await settle(page, 400);
    await clean("everything open");
    await page.focus("#stage");
    await page.keyboard.press("?");
    await until("the sheet", () => page.locator("#keys").evaluate((dialog) => dialog.open));
    await page.screenshot({ path: join(shots, "access-keys.png") });
    await clean("the sheet");
    await page.keyboard.press("Escape");
    await until("the focus back on the picture", () => page.evaluate(() => document.activeElement.id === "stage"));
  });

  await test("nor the list without a job, nor a job that is none", async () => {
    await page.goto(`${url}/#/`);
    await clean("the list");
    await page.goto(`${url}/#/jobs/00000000000000000000000000`);
    await until("the sentence", async () => /no such job/.test(await text(page, "problem")));
    await clean("no job");
  });

  await test("the tab key reaches everything, and the focus is seen", async () => {
    await page.goto(`${url}/#/jobs/${slow}`);
    await until("the picture", async () => (await look(page)).lit > 0.8);
    await page.evaluate(() => document.activeElement?.blur());
    const reached = new Set(), unseen = [];
    for (let i = 0; i < 60; i++) {
      await page.keyboard.press("Tab");
      const { id, seen, name } = await page.evaluate(() => {
        const at = document.activeElement, style = getComputedStyle(at);
        return { id: at.id || at.tagName, name: at.outerHTML.slice(0, 80), seen: style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2 };
      });
      if (id !== "BODY" && !seen) unseen.push(name);
      reached.add(id);
    }
    const missing = await page.evaluate((ids) => [...document.querySelectorAll("main :is(button, select, input, a[href], summary, [tabindex='0'])")]
      .filter((e) => e.checkVisibility() && !e.disabled && e.id && !ids.includes(e.id)).map((e) => e.id), [...reached]);
    expect(missing.length === 0, `not reached: ${missing}`);
    expect(unseen.length === 0, `focus not seen: ${unseen.join("; ")}`);
  });

  await test("at twice the size and on a phone nothing is cut off", async () => {
    for (const width of [640, 320]) {
      await page.setViewportSize({ width, height: 500 });
      await settle(page, 200);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      await page.screenshot({ path: join(shots, `access-${width}.png`), fullPage: true });
      expect(wide <= width, `the page is ${wide} px wide of ${width}`);
      await clean(`${width} px`);
    }
  });

  await test("letters do nothing outside the picture", async () => {
    await page.focus("#layer");
    const before = await page.inputValue("#exposure");
    await page.keyboard.press("e");
    expect(await page.inputValue("#exposure") === before, "e acts on the list");
  });

  await test("the page asks nobody else for anything", async () => {
    const asked = [];
    page.on("request", (request) => { if (!request.url().startsWith(url)) asked.push(request.url()); });
    await page.reload();
    await until("the picture", async () => (await look(page)).lit > 0.8);
    expect(asked.length === 0, asked.join());
  });
});
