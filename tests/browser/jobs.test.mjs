// The page of all jobs and the panel of one, in a real Chromium against a real coordinator. TAP.
//   node tests/browser/jobs.test.mjs BUILD_DIR
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { clean, narrow } from "./axe.mjs";
import { timeLeft } from "../../web/job/progress_text.js";
import { expect, openPage, runAll, shots, startServer, stopServer, submit, test, text, until } from "./house.mjs";

await runAll(async () => {
  const url = await startServer();
  const complaints = [];
  const page = await openPage(complaints, { reducedMotion: "reduce" });
  const shot = (name) => join(shots, `jobs-${name}.png`);
  const get = async (path) => (await page.request.get(url + path)).json();
  const row = (id) => page.locator(`#rows li:has(a[href="./#/jobs/${id}"])`);
  const states = () => page.locator("#rows .state").allTextContents();
  const tiny = { image: { width: 16, height: 16 }, sampling: { spp: 1 }, layers: ["beauty"] };

  await test("the time left is a figure where one is told, else a range", () => {
    const words = (eta_s, eta_range_s, state = "running") => timeLeft({ state, progress: { eta_s, eta_range_s } });
    for (const [said, ...told] of [["13 s left", 12.2, [9.8, 15.3]], ["11 to 40 s left", null, [10.4, 40]], ["20 s to 7 min left", null, [20, 400]],
      ["1.5 to 2.5 h left", null, [5400, 9000]], ["", null, null], ["", 3, [2, 4], "finished"]]) expect(words(...told) === said, `${words(...told)}, not ${said}`);
  });

  await test("an empty list says that it is empty", async () => {
    await page.goto(`${url}/jobs.html`);
    await until("the sentence", async () => (await text(page, "count")) === "No jobs yet.");
    expect(await page.title() === "Jobs · Shearwater", await page.title());
    const states = await page.locator("#state option").evaluateAll((all) => all.map(({ value }) => value).filter(Boolean));
    const known = /JobState:\s+type: string\s+enum: \[([^\]]*)\]/.exec(readFileSync("proto/openapi.yaml", "utf8"))[1];
    expect(states.join(", ") === known, `${states}, in the contract ${known}`);
    await clean(page, "no jobs");
  });

  const slow = submit(url, { image: { width: 512, height: 512 }, sampling: { spp: 100, tile_px: 32 }, layers: ["beauty", "depth"] });
  await test("a job appears, its row follows it, and says 100 % only when it is finished", async () => {
    await until("the row", () => row(slow).count());
    await page.evaluate((id) => { document.querySelector(`#rows a[href="./#/jobs/${id}"]`).focus(); window.kept = document.activeElement; }, slow);
    const seen = new Set();
    await until("finished", async () => {
      const [state, value, words] = await row(slow).evaluate((li) =>
        [li.querySelector(".state").textContent, li.querySelector("progress").value, li.querySelector(".done").textContent]);
      expect(value < 100 || state === "finished", `${value} % while ${state}`);
      expect(!words.startsWith("100 %") || state === "finished", `"${words}" while ${state}`);
      seen.add(value);
      if (seen.size === 3) await page.screenshot({ path: shot("running") });
      return state === "finished";
    }, 120);
    expect(seen.size >= 3, `it stood at ${[...seen]} only`);
    expect((await row(slow).locator(".done").textContent()) === "100 %", "not 100 % at the end");
    expect(await page.evaluate(() => window.kept === document.activeElement), "the focus was lost while the row changed");
  });

  const others = [];
  for (let i = 0; i < 3; i++) others.push(submit(url, tiny));
  const special = submit(url, { ...tiny, sampling: { spp: 1, seed: 424243 } });
  const cancelled = submit(url, { image: { width: 1024, height: 1024 }, sampling: { spp: 900 }, priority: -100 });
  await page.request.delete(`${url}/v1/jobs/${cancelled}`);

  await test("the newest are first", async () => {
    await until("six rows", async () => (await page.locator("#rows li").count()) === 6);
    const ids = await page.locator("#rows li > a:first-child").evaluateAll((links) => links.map((link) => link.title));
    expect(ids.join() === [...ids].sort().reverse().join(), ids.join());
  });

  await test("a filter by state is in the address, and back and forward go along it", async () => {
    await until("all ended", async () => (await states()).every((state) => /finished|cancelled/.test(state)), 60);
    await page.selectOption("#state", "cancelled");
    await until("one row", async () => (await states()).join() === "cancelled");
    expect(new URL(page.url()).search === "?state=cancelled", page.url());
    await page.selectOption("#state", "finished");
    await until("five rows", async () => (await states()).join() === Array(5).fill("finished").join());
    await page.goBack();
    await until("one row again", async () => (await states()).join() === "cancelled");
    expect(await page.inputValue("#state") === "cancelled", "the choice did not go back");
    await page.goForward();
    await until("five rows again", async () => (await states()).length === 5);
    await page.click("#clear");
    await until("all rows", async () => (await states()).length === 6);
  });

  await test("a filter by text finds what is in documents, and a bookmark finds it again", async () => {
    await page.fill("#text", "424243");
    await page.keyboard.press("Enter");
    await until("the one job", async () => (await page.locator("#rows li").count()) === 1);
    expect(await row(special).count() === 1, "another job");
    const bookmark = page.url();
    expect(/\?text=424243$/.test(bookmark), bookmark);
    await page.goto("about:blank");
    await page.goto(bookmark);
    await until("the one job", async () => (await page.locator("#rows li").count()) === 1);
    expect(await page.inputValue("#text") === "424243", "the field is empty");
    expect((await page.title()).includes("424243"), await page.title());
    await page.goto(`${url}/jobs.html?text=${special.slice(-8).toUpperCase()}`);
    await until("found by its id", () => row(special).count());
    await page.goto(`${url}/jobs.html?text=${encodeURIComponent("no such thing % _ &")}`);
    await until("none", async () => (await text(page, "count")) === "No job matches.");
  });

  await test("a name and a label find a job by the keyboard; a label leads to all that have it", async () => {
    const named = submit(url, { ...tiny, name: "Gulls <b>over</b> the sea", labels: ["show:gulls", "sc 010"], comment: "for Ana" });
    await page.goto(`${url}/jobs.html`);
    await page.getByRole("searchbox", { name: "Name" }).fill("GULLS <b>");
    await page.keyboard.press("Enter");
    await until("the one job", async () => (await page.locator("#rows li").count()) === 1);
    expect((await row(named).locator("a").first().textContent()) === "Gulls <b>over</b> the sea", "another name");
    expect((await row(named).locator(".label").allTextContents()).join() === "sc 010,show:gulls", "other labels");
    const picture = row(named).getByRole("img", { name: "Gulls <b>over</b> the sea" });
    await until("its small picture", () => picture.evaluate((img) => img.complete && img.naturalWidth === 16));
    const asked = await page.evaluate((id) => performance.getEntriesByType("resource").map(({ name }) => name).filter((name) => name.includes(`${id}/thumbnail`)), named);
    await clean(page, "a named job");
    await page.screenshot({ path: shot("named") });
    await page.getByRole("link", { name: "Jobs with the label sc 010" }).click();
    await until("the label in its field", async () => (await page.inputValue("#label")) === "sc 010" && (await page.inputValue("#name")) === "");
    await until("the one job", async () => (await page.locator("#rows li").count()) === 1 && (await row(named).count()) === 1);
    await row(named).locator("a").first().click();
    await until("its name is the title", async () => (await text(page, "job-title")) === "Gulls <b>over</b> the sea");
    await until("its comment is on the page", async () => (await page.textContent("#panel, main")).includes("for Ana"));
    await page.getByRole("button", { name: "Name and labels" }).focus();
    await page.keyboard.press("Enter");
    const dialog = page.getByRole("dialog", { name: "Name and labels" });
    expect((await dialog.getByLabel("Labels").inputValue()) === "sc 010, show:gulls", "the labels are not in their field");
    await clean(page, "the dialog of marks");
    await dialog.getByLabel("Name", { exact: true }).fill("Terns");
    await dialog.getByLabel("Labels").fill("b, b");
    await page.keyboard.press("Enter");
    await until("the server's words", async () => /the label is there twice/.test(await text(page, "mark-problem")));
    await dialog.getByLabel("Labels").fill("sc 020");
    await page.keyboard.press("Enter");
    await until("the new name is the title", async () => (await text(page, "job-title")) === "Terns");
    expect(/sc 020/.test(await text(page, "standing")) && /for Ana/.test(await text(page, "standing")), await text(page, "standing"));
    const marked = await get(`/v1/jobs/${named}`);
    expect(marked.name === "Terns" && marked.labels.join() === "sc 020" && marked.document.comment === "for Ana", JSON.stringify(marked.labels));
    complaints.splice(0, complaints.length, ...complaints.filter((line) => !/422/.test(line)));
    await page.request.delete(`${url}/v1/jobs/${named}?purge=1`);
    expect(asked.length > 0 && new Set(asked).size === asked.length, `one was asked for twice: ${asked}`);
    expect((await page.request.get(`${url}/v1/jobs/${named}/thumbnail`)).status() === 404, "the picture outlives its job");
  });

  await test("an address by hand that the server refuses is told so", async () => {
    await page.goto(`${url}/jobs.html?state=done`);
    await until("the sentence", async () => /state must be/.test(await text(page, "problem")));
    complaints.splice(0, complaints.length, ...complaints.filter((line) => !/400/.test(line)));
  });

  await test("long lists come in pages", async () => {
    const answer = await get("/v1/jobs?limit=1");
    const { document } = await get(`/v1/jobs/${answer.jobs[0].id}`);
    document.image = { width: 8, height: 8 };
    document.sampling = { spp: 1, tile_px: 8 };
    for (let i = 0; i < 110; i++)
      await page.request.post(`${url}/v1/jobs`, { data: document });
    await page.goto(`${url}/jobs.html`);
    await until("a full page", async () => (await page.locator("#rows li").count()) === 50);
    const first = await page.locator("#rows li > a:first-child").first().getAttribute("title");
    await page.click("#older");
    await until("the second page", async () => (await page.locator("#rows li > a:first-child").first().getAttribute("title")) < first);
    await page.click("#older");
    await until("the last page", async () => (await page.locator("#rows li").count()) === 16 && await page.locator("#older").isHidden());
    expect(await row(slow).count() === 1, "the oldest job is not on the last page");
    const last = page.url();
    await page.reload();
    await until("the same page", async () => (await page.locator("#rows li").count()) === 16);
    expect(page.url() === last, page.url());
    await page.goBack();
    await until("the page before", async () => (await page.locator("#rows li").count()) === 50);
    await page.click("#newest");
    await until("the newest", async () => !/cursor/.test(page.url()));
  });

  await test("nothing moves, nothing is fetched anew: the list answers 304", async () => {
    const all = async () => (await get("/v1/jobs?state=queued")).jobs.length + (await get("/v1/jobs?state=running")).jobs.length + (await get("/v1/jobs?state=importing")).jobs.length;
    await until("all done", async () => (await all()) === 0, 120);
    await page.goto(`${url}/jobs.html`);
    const answers = [];
    page.on("response", (response) => { if (/\/v1\/jobs\?/.test(response.url())) answers.push(response.status()); });
    await until("three looks", async () => answers.length >= 3);
    page.removeAllListeners("response");
    expect(answers.slice(1).every((status) => status === 304), answers.join());
  });

  await test("the list has no violations of WCAG 2.2 AA, on a phone or at 200 % either", async () => {
    await page.goto(`${url}/jobs.html?state=finished`);
    await until("rows", async () => (await page.locator("#rows li").count()) === 50);
    await page.screenshot({ path: shot("list") });
    await clean(page, "the list");
    await narrow(page, "the list", (width) => shot(`list-${width}`));
  });

  await test("the panel has the figures of the resource", async () => {
    await page.goto(`${url}/#/jobs/${slow}`);
    await until("the panel", async () => /finished/.test(await text(page, "standing")));
    const job = await get(`/v1/jobs/${slow}`);
    const rowsOf = (id) => page.locator(`#${id} tbody tr`).evaluateAll((trs) => trs.map((tr) => [...tr.children].map((cell) => cell.textContent)));
    const stages = Object.entries(job.statistics.cpu_s).filter(([name, value]) => name !== "total" && value > 0);
    const times = await rowsOf("times");
    expect(times.length === stages.length && stages.length > 3, `${times.length} of ${stages.length} stages`);
    for (const [name, shown] of times) {
      const value = job.statistics.cpu_s[name.replaceAll(" ", "_")], number = parseFloat(shown) * (/ms$/.test(shown) ? 1e-3 : 1);
      expect(Math.abs(number - value) <= 0.0051 + value * 0.01, `${name}: ${shown}, not ${value}`);
    }
    for (const [name, shown] of await rowsOf("rays")) {
      const value = job.statistics.rays[name.replaceAll(" ", "_")], number = parseFloat(shown) * (/million/.test(shown) ? 1e6 : 1);
      expect(Math.abs(number - value) <= value * 0.005 + 5e3 * (value > 1e6), `${name}: ${shown}, not ${value}`);
    }
    const skipped = await page.locator("#skipped").evaluate((list) => [...list.children].map((one) => one.textContent));
    expect(skipped.join() === job.plan.skipped.flatMap(({ what, why }) => [what, why]).join(), skipped.join());
    expect((await text(page, "statistics")).includes(`${job.statistics.tiles.done} done`), await text(page, "statistics"));
    expect((await text(page, "plan")).includes(job.plan.filter_why), await text(page, "plan"));
    const label = await page.getAttribute("#times svg", "aria-label");
    expect(label.includes(times[0][0]) && label.includes(times[0][1]), label);
    const bars = await page.locator("#times rect").evaluateAll((all) => all.map((one) => Number(one.getAttribute("width"))));
    expect(bars.every((width, i) => i === 0 || width <= bars[i - 1]) && bars[0] > bars.at(-1), `bars ${bars}`);
  });

  await test("the panel has a log with times, from submission to the end", async () => {
    const { log, created } = await get(`/v1/jobs/${slow}`);
    const lines = await page.locator("#log li").evaluateAll((all) => all.map((li) => [li.querySelector("time").dateTime, li.querySelector("span").textContent]));
    expect(lines.map(([, words]) => words).join("; ") === "submitted; the scene is imported and the frame planned; " +
      "planned: tiles are given out; frame 1 is begun; frame 1 is drawn and encoded; finished: all files are stored", JSON.stringify(lines));
    expect(lines.map(([time]) => time).join() === log.map(({ time }) => time).join(), "other times");
    expect(lines[0][0] === created, `${lines[0][0]}, submitted ${created}`);
    const times = lines.map(([time]) => Date.parse(time));
    expect(times.every((time, i) => i === 0 || time >= times[i - 1]), times.join());
  });

  await test("a worker that is lost, and a cancellation, are in the log, and the log survives a restart", async () => {
    const id = submit(url, { image: { width: 1024, height: 1024 }, sampling: { spp: 400 } });
    await page.goto(`${url}/#/jobs/${id}`);
    await until("running", async () => (await get(`/v1/jobs/${id}`)).progress.tiles_done > 2);
    const { workers } = await get("/v1/workers");
    process.kill(workers[0].pid, "SIGKILL");
    await until("the line in the page", async () => /has left: a tile that it held is given out again/.test(await text(page, "log")));
    await page.screenshot({ path: shot("panel-running"), fullPage: true });
    await page.click("#cancel");
    await page.click("#cancel-yes");
    await until("the last line", async () => /cancelled$/.test(await text(page, "log")));
    const before = (await get(`/v1/jobs/${id}`)).log;
    expect(before.some(({ what, times }) => what === "worker" && times >= 1), JSON.stringify(before));
    await stopServer("SIGKILL");
    await startServer(new URL(url).port);
    const after = (await get(`/v1/jobs/${id}`)).log;
    expect(JSON.stringify(after) === JSON.stringify(before), "another log after the restart");
    complaints.length = 0; // of the time without a server
  });

  await test("what happened before the coordinator was killed is in the log of the job that goes on", async () => {
    const id = submit(url, { image: { width: 1024, height: 1024 }, sampling: { spp: 400 } });
    await until("running", async () => (await get(`/v1/jobs/${id}`)).progress.tiles_done > 2);
    process.kill((await get("/v1/workers")).workers[0].pid, "SIGKILL");
    await until("the line", async () => (await get(`/v1/jobs/${id}`)).log.some(({ what }) => what === "worker"));
    await page.waitForTimeout(4000);
    await stopServer("SIGKILL");
    await startServer(new URL(url).port);
    await until("running again", async () => (await get(`/v1/jobs/${id}`)).progress.tiles_done > 0);
    const lines = (await get(`/v1/jobs/${id}`)).log.map(({ text }) => text);
    const [lost, again] = [lines.findIndex((line) => /has left/.test(line)), lines.indexOf("taken up again after a restart of the coordinator")];
    expect(lost > 0 && again > lost, lines.join("; "));
    await page.request.delete(`${url}/v1/jobs/${id}`);
    complaints.length = 0;
  });

  await test("the panel has no violations of WCAG 2.2 AA, on a phone or at 200 % either", async () => {
    await page.goto(`${url}/#/jobs/${slow}`);
    await page.reload();
    await until("the panel", async () => /finished/.test(await text(page, "standing")));
    for (const id of ["skipped-part", "times", "rays"]) await page.locator(`#${id} summary`).click();
    await clean(page, "the panel");
    await page.setViewportSize({ width: 1600, height: 1000 });
    await page.evaluate(() => scrollTo(0, 0));
    const [stage, panel] = [await page.locator("#stage").boundingBox(), await page.locator("#panel").boundingBox()];
    expect(panel.x >= stage.x + stage.width && panel.y < stage.y, "the panel is not beside the picture");
    await page.screenshot({ path: shot("panel") });
    await narrow(page, "the panel", (width) => shot(`panel-${width}`));
  });

  await test("the pages lead to one another, by keys", async () => {
    await page.goto(`${url}/jobs.html`);
    await page.keyboard.press("Tab");
    expect(await page.evaluate(() => document.activeElement.className) === "skip", "the first stop is no skip link");
    await page.keyboard.press("Enter");
    expect(await page.evaluate(() => document.activeElement.id) === "content", "it skips to nowhere");
    for (const [name, title, path] of [["New job", "New job", "/submit.html"], ["Workers", "Workers", "/workers.html"],
      ["Jobs", "Jobs", "/jobs.html"], ["Viewer", "Shearwater", "/"]]) {
      await page.locator("nav.pages a", { hasText: new RegExp(`^${name}$`) }).focus();
      await page.keyboard.press("Enter");
      await page.waitForURL(url + path);
      expect((await page.title()).startsWith(title), await page.title());
      expect(await page.locator('nav.pages a[aria-current="page"]').textContent() === name, "another page is marked");
    }
  });

  await test("nothing was written to the console", async () => {
    expect(complaints.length === 0, complaints.join("; "));
  });
});
