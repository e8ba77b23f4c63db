// A real coordinator with real workers on loopback, for measurements that need to know more of a job than
// `shearwater render` tells: its plan, wall time by stage, bytes over the links.
import { spawn, spawnSync } from "node:child_process";
import { randomBytes } from "node:crypto";
import { mkdtempSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";

const START_S = 20;

// Job logs tell when stages began; what the last is called tells what it was.
const MOMENTS = { imported: /scene is imported/, planned: /tiles are given out/, stored: /drawn and encoded/, finished: /^finished/ };

export class Farm {
  #build;
  #process;
  #folder;
  #url;
  #dialled = [];

  // options: {workers, threads} of local workers; link: "unix", or "tcp" or "sealed" for workers that dial over
  // loopback, in the clear or under a key
  static async start(build, { workers = 1, threads, link = "unix" } = {}) {
    const farm = new Farm();
    farm.#build = build;
    farm.#folder = mkdtempSync(`${tmpdir()}/bench-`);
    const key = link === "sealed" ? ["--worker-key", `${farm.#folder}/key`] : [], local = link === "unix" ? workers : 0;
    if (link === "sealed") writeFileSync(`${farm.#folder}/key`, `${randomBytes(32).toString("hex")}\n`, { mode: 0o600 });
    farm.#process = spawn(`${build}/shearwater`, ["serve", "--listen", "127.0.0.1:0", "--data", `${farm.#folder}/data`, "--workers", String(local),
      ...(threads ? ["--worker-threads", String(threads)] : []), ...(local === workers ? [] : ["--worker-listen", "127.0.0.1:0", ...key])], { stdio: ["ignore", "pipe", "pipe"] });
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
    if (local < workers) {
      await farm.#until(() => /worker_port=\d+ /.test(said)); // it is said beside, after the address
      farm.#dial(build, workers, threads, /worker_port=(\d+)/.exec(said)[1], key);
    }
    await farm.#until((m) => m.shearwater_workers >= workers);
    return farm;
  }

  // Workers of another machine, as far as they know; nice, as local ones are.
  #dial(build, workers, threads, port, key) {
    for (let i = 0; i < workers; i++)
      this.#dialled.push(spawn(`${build}/shearwater-worker`, ["--connect", `127.0.0.1:${port}`, "--name", `far-${i + 1}`, "--nice", "10", "--cache", `${this.#folder}/cache-${i}`,
        ...(threads ? ["--threads", String(threads)] : []), ...(key.length > 0 ? ["--key", key[1]] : [])], { stdio: "ignore" }));
  }

  async stop() {
    for (const worker of this.#dialled) worker.kill("SIGTERM");
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

  // Its stream of events ends with the job.
  async #ended(id) {
    for await (const chunk of (await this.#get(`/v1/jobs/${id}/events`)).body) void chunk;
  }

  // A reader of the file never sees half a picture.
  async #keep(id, picture) {
    const answer = await this.#get(`/v1/jobs/${id}/frames/1/image.exr`);
    writeFileSync(`${picture}.new`, Buffer.from(await answer.arrayBuffer()));
    renameSync(`${picture}.new`, picture);
  }

  // Runs a job to its end: {plan, statistics, wall: {import, tiles, drawn_late, after_last_tile, record, total}, link:
  // {received_bytes, sent_bytes}}; wall in seconds: what the coordinator says of frames, and the log of the rest.
  // picture: where its EXR goes, if it is wanted.
  async run(job, picture = null) {
    const path = `${this.#folder}/job.json`, before = await this.#metrics();
    writeFileSync(path, JSON.stringify(job));
    const { status, stdout, stderr } = spawnSync(`${this.#build}/shearwater`, ["submit", path, "--server", this.#url, "--quiet"], { encoding: "utf8" });
    if (status !== 0) throw new Error(`submit: ${stderr.trim()}`);
    const id = stdout.trim();
    await this.#ended(id);
    const { state, plan, log, statistics, error } = await (await this.#get(`/v1/jobs/${id}`)).json();
    if (state !== "finished") throw new Error(`the job is ${state}: ${JSON.stringify(error)}`);
    if (picture) await this.#keep(id, picture);
    const after = await this.#metrics(), begun = Date.parse(log[0].time) / 1000;
    const moment = Object.fromEntries(Object.entries(MOMENTS).map(([name, words]) => [name, Date.parse(log.find((l) => words.test(l.text)).time) / 1000]));
    const sent = (name) => after[`shearwater_link_${name}_bytes_total`] - before[`shearwater_link_${name}_bytes_total`];
    return { plan, statistics, link: { received_bytes: sent("received"), sent_bytes: sent("sent") },
      wall: { import: moment.planned - begun, tiles: statistics.frames.wall_s - statistics.frames.stored_late_s, drawn_late: statistics.frames.drawn_late_s,
        after_last_tile: statistics.frames.stored_late_s, frame: statistics.frames.wall_s, record: moment.finished - moment.stored, total: moment.finished - begun } };
  }
}
