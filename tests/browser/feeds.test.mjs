// Pixel feeds in the viewer: what it asks for again, and what it is sent then. TAP on standard output.
//   node tests/browser/feeds.test.mjs BUILD_DIR
import { execFileSync } from "node:child_process";
import { createServer, connect } from "node:net";
import { LayerSource } from "../../web/picture/layer_source.js";
import { BlockParser } from "../../web/picture/pixel_feed.js";
import { expect, look, openPage, runAll, startServer, submit, test, text, until } from "./house.mjs";

// A door before the server that can be shut: connections break, new ones are refused.
function makeDoor(port) {
  const open = new Set();
  let shut = false;
  const door = createServer((near) => {
    if (shut) { near.destroy(); return; }
    const far = connect(port, "127.0.0.1");
    for (const [from, to] of [[near, far], [far, near]]) {
      open.add(from);
      from.on("error", () => {});
      from.on("close", () => { open.delete(from); to.destroy(); });
      from.pipe(to);
    }
  });
  return new Promise((done) => door.listen(0, "127.0.0.1", () => done({
    port: door.address().port,
    shut() { shut = true; for (const socket of open) socket.destroy(); },
    open() { shut = false; },
    close() { this.shut(); door.close(); },
  })));
}

// Reads a feed until `enough(blocks)`; the blocks, sizes left out, and the last revision.
async function readFeed(url, enough, seconds = 20) {
  const control = new AbortController(), timer = setTimeout(() => control.abort(), seconds * 1000);
  const blocks = [], parser = new BlockParser();
  let revision = 0n;
  try {
    const reader = (await fetch(url, { signal: control.signal })).body.getReader();
    // Node.js 18 has a body's readers wait on when its fetch is aborted.
    control.signal.addEventListener("abort", () => reader.cancel().catch(() => {}));
    for (let got = await reader.read(); !got.done; got = await reader.read()) {
      for (const block of parser.feed(got.value)) {
        revision = block.revision;
        if (block.w) blocks.push(block);
      }
      if (enough(blocks)) break;
    }
  } catch (error) { if (error.name !== "AbortError") throw error; }
  clearTimeout(timer);
  control.abort();
  return { blocks, revision };
}

// Answers of a coordinator whose job has finished, in place of fetch: one feed after the other, the
// last again and again. An open one goes on without end.
function fakeFeeds(answers) {
  const real = globalThis.fetch, feeds = { asked: 0, end() { globalThis.fetch = real; } };
  globalThis.fetch = async (address, { signal }) => {
    if (!/pixels/.test(address)) return new Response(JSON.stringify({ state: "finished" }));
    const { body, open } = answers[Math.min(feeds.asked++, answers.length - 1)];
    return new Response(new ReadableStream({ start(control) {
      control.enqueue(new Uint8Array(body));
      if (open) signal.addEventListener("abort", () => control.error(signal.reason));
      else control.close();
    } }));
  };
  return feeds;
}

await runAll(async () => {
  const url = await startServer();
  const complaints = [];
  const id = submit(url, { layers: ["beauty", "albedo", "normal"] });
  await until("finished", async () => (await (await fetch(`${url}/v1/jobs/${id}`)).json()).state === "finished", 90);
  const albedo = new Uint8Array(await (await fetch(`${url}/v1/jobs/${id}/pixels?layer=albedo`)).arrayBuffer());

  await test("a layer that was left in the middle becomes whole when looked at again", async () => {
    const blocks = (image) => image.seen.reduce((sum, one) => sum + one, 0);
    for (const share of [0.1, 0.5, 0.98]) {
      const feeds = fakeFeeds([{ body: albedo.subarray(0, 32 + share * (albedo.length - 32)), open: true }, { body: albedo }]);
      const source = new LayerSource(id, "albedo");
      source.follow(() => {}, () => {});
      await until("some of it", () => source.image.numbers && blocks(source.image) >= Math.floor(24 * share));
      source.stop();
      expect(blocks(source.image) < 25 && !source.whole, `${blocks(source.image)} blocks of ${share}`);
      source.follow(() => {}, () => {});
      await until("the end", () => source.whole && !source.live);
      expect(blocks(source.image) === 25 && feeds.asked === 2, `${blocks(source.image)} blocks from ${feeds.asked} feeds`);
      source.follow(() => {}, () => {});
      expect(feeds.asked === 2, "a whole layer is asked for again");
      feeds.end();
    }
  });

  await test("feeds that end too early are asked for again after pauses that grow", async () => {
    const feeds = fakeFeeds([{ body: albedo.subarray(0, albedo.length / 2) }]), source = new LayerSource(id, "albedo");
    source.follow(() => {}, () => {});
    await new Promise((done) => setTimeout(done, 1200));
    source.stop();
    expect(feeds.asked === 3 && source.live === false, `${feeds.asked} feeds in 1.2 s`); // at 0, 0, 0.5 s
    feeds.end();
  });

  await test("a finished job's feed that is refused is not asked for again and again", async () => {
    const some = await openPage(complaints);
    let asked = 0;
    await some.route(/pixels\?layer=normal/, (route) => {
      asked++;
      return route.fulfill({ status: 409, contentType: "application/problem+json", body: JSON.stringify({ detail: "gone for the test" }) });
    });
    await some.goto(`${url}/#/jobs/${id}`);
    await until("the picture", async () => (await look(some)).lit > 0.8);
    await some.selectOption("#layer", "normal");
    await until("that it says so", async () => /layer normal cannot be shown: gone for the test/.test(await text(some, "canvas-note")));
    await some.waitForTimeout(1000);
    expect(asked === 2, `asked ${asked} times`);
    await some.selectOption("#layer", "beauty");
    expect(await some.isHidden("#canvas-note"), "the note stays over another layer");
    await some.close();
  });

  await test("a reader that comes again is sent what it has not", async () => {
    const running = submit(url, { image: { width: 1536, height: 1536 }, sampling: { spp: 100 } });
    const feed = `${url}/v1/jobs/${running}/pixels`;
    const first = await readFeed(feed, (blocks) => blocks.length > 24, 60);
    expect(first.blocks.length > 24, `${first.blocks.length} blocks in a minute`);
    const had = await readFeed(feed, () => false, 1.5);
    const again = await readFeed(`${feed}?after=${had.revision}`, () => false, 1.5);
    const whole = await readFeed(`${feed}?after=${1n << 62n}`, (blocks) => blocks.length >= had.blocks.length, 5);
    const places = new Set(had.blocks.map(({ x, y }) => `${x} ${y}`)), twice = again.blocks.filter(({ x, y }) => places.has(`${x} ${y}`));
    expect(twice.length < had.blocks.length / 2, `${twice.length} blocks again, of ${had.blocks.length}`);
    expect(whole.blocks.length >= had.blocks.length, `a revision of no life brought ${whole.blocks.length} blocks of ${had.blocks.length}`);
    expect(again.revision >= had.revision, "revisions fall");
    execFileSync("curl", ["-sS", "--noproxy", "*", "-X", "DELETE", `${url}/v1/jobs/${running}`]);
  });

  await test("the page goes on from its revision after the connection was cut", async () => {
    const door = await makeDoor(Number(new URL(url).port)), asked = [];
    const away = await openPage(complaints);
    await away.route("**/*", (route) => route.continue());
    away.on("request", (request) => { if (/pixels/.test(request.url())) asked.push(request.url()); });
    const running = submit(url, { image: { width: 768, height: 768 }, sampling: { spp: 36 } });
    await away.goto(`http://127.0.0.1:${door.port}/#/jobs/${running}`);
    await until("some picture", async () => (await look(away)).lit > 0.1, 60);
    door.shut();
    const at = (await look(away)).lit;
    await until("lost", async () => (await text(away, "connection")) !== "connected");
    expect((await look(away)).lit >= at - 0.01, "what was there is gone");
    door.open();
    await until("resumed", () => asked.some((address) => /after=[1-9]\d+/.test(address)));
    await until("finished", async () => /finished/.test(await text(away, "progress-text")), 240);
    await until("whole", async () => (await look(away)).lit > 0.8);
    door.close();
    await away.close();
  });

  await test("nothing was written to the console but what was cut", () => {
    const others = complaints.filter((line) => !/ERR_|404|400|409|503/.test(line)); // 503: busy with layers that were passed by
    expect(others.length === 0, others.join("; "));
  });
});
