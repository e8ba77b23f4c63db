// axe-core at WCAG 2.2 AA, run in the page through the debugger: the page's policy lets no script in.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { expect } from "./house.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

async function violations(page) {
  const session = await page.context().newCDPSession(page);
  const run = (expression, awaitPromise = false) => session.send("Runtime.evaluate", { expression, awaitPromise, returnByValue: true });
  await run(axe);
  const { result, exceptionDetails } = await run(
    `axe.run(document, { runOnly: ${JSON.stringify(RULES)} }).then((r) => JSON.stringify({ passes: r.passes.length, violations:
      r.violations.map((v) => v.id + ": " + v.nodes.map((n) => n.target.join(" ") + " (" + n.failureSummary + ")").join(", ")) }))`, true);
  await session.detach();
  if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
  return JSON.parse(result.value);
}

export async function clean(page, what) {
  const found = await violations(page);
  expect(found.passes > 15, `${what}: only ${found.passes} rules were looked at`);
  expect(found.violations.length === 0, `${what}: ${found.violations.join("; ")}`);
}

// At a phone's width, and at 1280 px seen at 200 %: nothing beside the screen, nothing for axe to say.
export async function narrow(page, what, shot) {
  const before = page.viewportSize();
  for (const width of [640, 320]) {
    await page.setViewportSize({ width, height: 600 });
    await page.waitForTimeout(150);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    await page.screenshot({ path: shot(width), fullPage: true });
    expect(wide <= width, `${what} is ${wide} px wide of ${width}`);
    await clean(page, `${what} at ${width} px`);
  }
  await page.setViewportSize(before);
}
