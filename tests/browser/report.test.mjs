// The bench's report in Chromium: it is whole without a server or a network, is read by people and by screen
// readers, at any width.
//   report.test.mjs BUILD
import { spawnSync } from "node:child_process";
import { join } from "node:path";
import { clean, narrow } from "./axe.mjs";
import { build, expect, openPage, runAll, shots, test, tmp } from "./house.mjs";

const complaints = [], asked = [];

await runAll(async () => {
  await test("a report is made", async () => {
    const { status, stderr } = spawnSync(process.execPath, ["tests/bench/bench.mjs", build, "smoke", "part=accuracy,workers,skips", "scene=contacts", `out=${tmp}/bench`],
      { encoding: "utf8", maxBuffer: 1 << 26 });
    // 1: some figure moved, which is for the gate's own test to say.
    expect(status === 0 || status === 1, stderr);
  });
  const page = await openPage(complaints);
  page.on("request", (request) => asked.push(request.url()));
  await page.goto(`file://${join(tmp, "bench/report/index.html")}`);

  await test("it has bounds, errors, costs, skips and how it was measured", async () => {
    const titles = await page.locator("h2").allTextContents();
    for (const words of [/Bounds/, /Errors: soft shadows/, /cost as they grow/, /not needed/, /How it was measured/])
      expect(titles.some((t) => words.test(t)), `no section ${words} in ${titles.join(", ")}`);
  });
  await test("its plots have names and descriptions, and nothing is drawn outside of them", async () => {
    const plots = await page.evaluate(() => [...document.querySelectorAll("svg")].map((svg) => {
      const box = svg.getBoundingClientRect(), beyond = [...svg.querySelectorAll("text, circle, rect")].filter((e) => {
        const r = e.getBoundingClientRect();
        return r.width > 0 && (r.left < box.left - 1 || r.right > box.right + 1 || r.top < box.top - 1 || r.bottom > box.bottom + 1);
      });
      return { name: svg.querySelector("title")?.textContent, desc: svg.querySelector("desc")?.textContent ?? "", beyond: beyond.map((e) => e.textContent) };
    }));
    expect(plots.length >= 5, `${plots.length} plots`);
    for (const p of plots) {
      expect(p.name && p.desc.length > 40, `${p.name}: ${p.desc}`);
      expect(p.beyond.length === 0, `${p.name}: outside of it: ${p.beyond.join(", ")}`);
    }
  });
  await test("labels of lines do not cover each other", async () => {
    const covered = await page.evaluate(() => [...document.querySelectorAll("svg")].flatMap((svg) => {
      const boxes = [...svg.querySelectorAll('text[font-weight="500"]')].map((e) => ({ words: e.textContent, box: e.getBoundingClientRect() }));
      return boxes.flatMap((a, i) => boxes.slice(i + 1).filter((b) => a.box.top < b.box.bottom - 4 && b.box.top < a.box.bottom - 4 && a.box.left < b.box.right && b.box.left < a.box.right)
        .map((b) => `${svg.querySelector("title").textContent}: ${a.words}, ${b.words}`));
    }));
    expect(covered.length === 0, covered.join("; "));
  });
  await test("every picture shows", async () => {
    await page.evaluate(() => { for (const image of document.images) image.loading = "eager"; });
    await page.waitForFunction(() => [...document.images].every((i) => i.complete));
    expect(await page.evaluate(() => document.images.length >= 6 && [...document.images].every((i) => i.naturalWidth > 0 && i.alt)), "a picture is absent or has no words");
  });
  await test("it asks nobody for anything", async () => {
    expect(asked.every((url) => url.startsWith("file:") || url.startsWith("data:")), asked.join(" "));
    expect(complaints.length === 0, complaints.join("; "));
  });
  await page.screenshot({ path: join(shots, "report.png"), fullPage: true });
  await test("WCAG 2.2 AA", () => clean(page, "the report"));
  await test("at 640 and 320 px", () => narrow(page, "the report", (width) => join(shots, `report-${width}.png`)));
});
