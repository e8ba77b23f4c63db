// A real coordinator with real workers on loopback, for measurements that need to know more of a job than
// `shearwater render` tells: its plan, wall time by stage, bytes over the links.
import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";

const START_S = 20;

// Job logs tell when stages began; what the last is called tells what it was.
const MOMENTS = { imported: /scene is imported/, planned: /tiles are given out/, drawn: /drawn and encoded/, finished: /^finished/ };

export class Farm {
  #build;
  #process;
  #folder;
  #url;

  // options: {workers, threads} of local workers
  static async start(build, { workers = 2, threads } = {}) {
    const farm = new Farm();
    farm.#build = build;
    farm.#folder = mkdtempSync(`${tmpdir()}/bench-`);
    farm.#process = spawn(`${build}/shearwater`, ["serve", "--listen", "127.0.0.1:0", "--data", `${farm.#folder}/data`, "--workers", String(workers),
      ...(threads ? ["--worker-threads", String(threads)] : [])], { stdio: ["ignore", "pipe", "pipe"] });
    let said = "";
    farm.#process.stderr.on("data", (chunk) => { said += chunk; });
    farm.#url = await new Promise((done, fail) => {
      let text = "";
      const timer = setTimeout(() => fail(new Error(`the coordinator is silent: ${said}`)), START_S * 1000);
      farm.#process.stdout.on("data", (chunk) => {
        text += chunk;
        const url = /listening on (\S+)/.exec(text)?.[1];
        if (url) { clearTimeout(timer); done(url); }
      });
      farm.#process.on("exit", (code) => fail(new Error(`the coordinator ended with ${code}: ${said}`)));
    });
    await farm.#until((m) => m.shearwater_workers >= workers);
    return farm;
  }

  async stop() {
    this.#process.removeAllListeners("exit");
    const ended = new Promise((done) => this.#process.on("exit", done));
    this.#process.kill("SIGTERM");
    await ended;
    rmSync(this.#folder, { recursive: true, force: true });
  }

  async #get(path) {
    const answer = await fetch(this.#url + path);
    if (!answer.ok) throw new Error(`${path}: ${answer.status} ${await answer.text()}`);
    return answer;
  }

  // Metrics without labels, by name.
  async #metrics() {
    const text = await (await this.#get("/metrics")).text();
    return Object.fromEntries([...text.matchAll(/^([a-z_]+) ([-+0-9.e]+)$/gm)].map(([, name, value]) => [name, Number(value)]));
  }

  async #until(holds) {
    for (const end = Date.now() + START_S * 1000; Date.now() < end; await new Promise((done) => setTimeout(done, 20)))
      if (holds(await this.#metrics())) return;
    throw new Error("the workers do not come");
  }

  // Seconds, by this process's clock, at which the last tile of the job landed.
  async #lastTile(id) {
    let rest = "", last = null;
    const decoder = new TextDecoder();
    for await (const chunk of (await this.#get(`/v1/jobs/${id}/events`)).body) {
      rest += decoder.decode(chunk, { stream: true });
      const events = rest.split("\n\n");
      rest = events.pop();
      if (events.some((e) => /^event: tile$/m.test(e))) last = Date.now() / 1000;
    }
    return last;
  }

  // Runs a job to its end: {plan, statistics, wall: {import, plan, draw, after_last_tile, files, total}, link:
  // {received_bytes, sent_bytes}}; wall in seconds.
  async run(job) {
    const path = `${this.#folder}/job.json`, before = await this.#metrics();
    writeFileSync(path, JSON.stringify(job));
    const { status, stdout, stderr } = spawnSync(`${this.#build}/shearwater`, ["submit", path, "--server", this.#url, "--quiet"], { encoding: "utf8" });
    if (status !== 0) throw new Error(`submit: ${stderr.trim()}`);
    const id = stdout.trim(), last = await this.#lastTile(id);
    const { state, plan, log, statistics, error } = await (await this.#get(`/v1/jobs/${id}`)).json();
    if (state !== "finished") throw new Error(`the job is ${state}: ${JSON.stringify(error)}`);
    const after = await this.#metrics(), begun = Date.parse(log[0].time) / 1000;
    const moment = Object.fromEntries(Object.entries(MOMENTS).map(([name, words]) => [name, Date.parse(log.find((l) => words.test(l.text)).time) / 1000]));
    const sent = (name) => after[`shearwater_link_${name}_bytes_total`] - before[`shearwater_link_${name}_bytes_total`];
    return { plan, statistics, link: { received_bytes: sent("received"), sent_bytes: sent("sent") },
      wall: { import: moment.planned - begun, tiles: Math.max(0, (last ?? moment.drawn) - moment.planned),
        after_last_tile: Math.max(0, moment.drawn - (last ?? moment.drawn)), files: moment.finished - moment.drawn, total: moment.finished - begun } };
  }
}
