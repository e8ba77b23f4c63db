// Signing in where the server asks for tokens, in a real Chromium. TAP.
//   node tests/browser/sign_in.test.mjs BUILD_DIR
import { execFileSync } from "node:child_process";
import { rmSync } from "node:fs";
import { join } from "node:path";
import { clean } from "./axe.mjs";
import { build, expect, openPage, runAll, serverPid, shots, startServer, submit, test, text, tmp, until } from "./house.mjs";

await runAll(async () => {
  const tokens = join(tmp, "tokens.json");
  const make = (name, tenant, role) =>
    execFileSync(join(build, "shearwater"), ["token", tokens, "--name", name, "--tenant", tenant, "--role", role]).toString().trim();
  const ana = make("ana", "studio", "submitter"), eve = make("eve", "elsewhere", "viewer");
  const url = await startServer(0, ["--tokens", tokens]);
  const complaints = [], expected = /status of 401|status of 404|EventSource/;
  const page = await openPage(complaints);
  process.env.SHEARWATER_TOKEN = ana;
  const id = submit(url, { image: { width: 256, height: 256 } });
  const dialog = page.locator("#sign-in");
  const enter = async (token) => {
    await page.locator("#sign-in-token").fill(token);
    await page.locator("#sign-in-token").press("Enter");
  };

  await test("a page without a token asks for one, and shows nothing", async () => {
    await page.goto(`${url}/#/jobs/${id}`);
    await until("the question", () => dialog.isVisible(), 15);
    expect(await page.locator("#jobs li").count() === 0, "jobs are listed");
    expect((await page.evaluate(() => document.activeElement.id)) === "sign-in-token", "the field has no focus");
    await page.screenshot({ path: join(shots, "sign-in.png") });
    await clean(page, "the question for a token");
  });

  await test("a wrong token is refused in words", async () => {
    await enter("short");
    await until("the words", async () => /not a token/.test(await text(page, "sign-in-problem")), 5);
    await enter(`sw_${"0".repeat(64)}`);
    await until("other words", async () => /does not know/.test(await text(page, "sign-in-problem")), 5);
    expect(await dialog.isVisible(), "the question is gone");
  });

  await test("with the right one the job is there, live", async () => {
    await enter(ana);
    await until("who one is", async () => (await page.locator("#who").count()) === 1, 15);
    expect(/ana of studio/.test(await text(page, "who")), await text(page, "who"));
    await until("its end", async () => /finished/.test(await text(page, "progress-text")), 60);
    await until("the connection", async () => (await text(page, "connection")) === "connected", 10);
    expect(!await dialog.isVisible(), "it asks again");
    await clean(page, "signed in");
  });

  await test("scripts have neither token nor cookie, and the address neither", async () => {
    const found = await page.evaluate(() => JSON.stringify([document.cookie, { ...localStorage }, { ...sessionStorage }, location.href]));
    expect(!found.includes(ana.slice(3)) && !/shearwater-\d/.test(found), found);
    const [cookie] = await page.context().cookies();
    expect(cookie.httpOnly && cookie.sameSite === "Strict" && !cookie.value.includes(ana.slice(3)), JSON.stringify(cookie));
  });

  await test("what is changed from the page is taken", async () => {
    const long = submit(url, { image: { width: 1536, height: 1536 }, sampling: { spp: 4096 }, filter: { method: "none" } });
    await page.goto(`${url}/#/jobs/${long}`);
    await page.locator("#pause").click();
    await until("a pause", async () => (await (await page.request.get(`${url}/v1/jobs/${long}`)).json()).paused, 15);
    await page.locator("#cancel").click();
    await page.locator("#cancel-yes").click();
    await until("its end", async () => (await (await page.request.get(`${url}/v1/jobs/${long}`)).json()).state === "cancelled", 15);
  });

  await test("another tenant is told that there is no such job", async () => {
    await page.goto(`${url}/#/jobs/${id}`);
    await page.locator("#sign-out").click();
    await until("the question", () => dialog.isVisible(), 15);
    await enter(eve);
    await until("the answer", async () => /There is no such job/.test(await text(page, "problem")), 15);
    expect(await page.locator("#jobs li").count() === 0, "jobs are listed");
  });

  await test("a token that is withdrawn ends the session", async () => {
    rmSync(tokens);
    make("other", "studio", "viewer");
    process.kill(serverPid(), "SIGHUP");
    await until("the question", () => dialog.isVisible(), 40);
  });

  await test("the console has nothing but refusals", async () => {
    const others = complaints.filter((line) => !expected.test(line));
    expect(others.length === 0, others.join("\n"));
  });
});
