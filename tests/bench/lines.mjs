// The bench's measurements: one JSON line each, in one file. Runs of one build add up: a line replaces
// the one that has its part and key; lines of other builds go when the first of a new one comes.
//   part: which part of the bench; key: what was measured, of all that the part measures
//   build, machine, time: by what, on what, when; the rest is the part's own (README.md)
import { existsSync, readFileSync, renameSync, writeFileSync } from "node:fs";

const parse = (path) => existsSync(path) ? readFileSync(path, "utf8").split("\n").filter(Boolean).map((l) => JSON.parse(l)) : [];

export class Lines {
  #path;
  #common;
  #lines;
  #fresh = new Set();

  // common: members of every line {build, machine}
  constructor(path, common) {
    [this.#path, this.#common] = [path, common];
    // What another build or machine measured is not to be joined with this one's.
    this.#lines = new Map(parse(path).filter((l) => l.build === common.build && l.machine === common.machine).map((l) => [`${l.part} ${l.key}`, l]));
  }

  // Keeps and prints it; a reader of the file never sees half a line.
  put(part, key, measured) {
    const line = { part, key, ...this.#common, time: new Date().toISOString().slice(0, 19) + "Z", ...measured };
    this.#lines.set(`${part} ${key}`, line);
    this.#fresh.add(line);
    writeFileSync(`${this.#path}.new`, this.all().map((l) => JSON.stringify(l) + "\n").join(""));
    renameSync(`${this.#path}.new`, this.#path);
    console.log(JSON.stringify(line));
    return line;
  }

  all() {
    return [...this.#lines.values()];
  }

  // Those that this process measured.
  fresh() {
    return [...this.#fresh];
  }
}
