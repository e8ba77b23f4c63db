// A service with tenants, its assets and what is on its disk, for assets.mjs and assets_killed.mjs.
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { Tenant, make_tokens, scene_bytes } from "../load/parts/clients.mjs";
import { join, marked_scene, readdirSync, sha256, until } from "../load/service.mjs";

export const build = process.argv[2];
export const box = scene_bytes(), scene = (mark) => marked_scene(box, mark);
export const picture = { image: { width: 32, height: 32 }, sampling: { spp: 1 } };
export const long = { image: { width: 1024, height: 1024 }, sampling: { spp: 1024 }, filter: { method: "none" } };
export const shown = (a) => `${a?.status} ${a?.body}`;
export const slug = (a) => /problem:([a-z-]+)/.exec(String(a.body))?.[1];
export const is = (a, status, kind) => a.status === status && (!kind || slug(a) === kind);

// What is on the disk.
export const in_folders = (path) => existsSync(path) ? readdirSync(path).flatMap((two) => readdirSync(join(path, two)).map((rest) => two + rest)) : [];
export const objects_of = (service) => in_folders(join(service.data, "objects"));
export const query = (service, sql, ...options) => execFileSync("sqlite3", ["-cmd", ".timeout 10000", ...options, join(service.data, "jobs.sqlite"), sql], { encoding: "utf8" }).split("\n").filter(Boolean);
export const notes_of = (service) => query(service, "SELECT lower(hex(object)) FROM removals", "-readonly");
export const note = (service, digest) => query(service, `INSERT OR IGNORE INTO removals VALUES (x'${digest}')`);
export const has_object = (service, digest) => existsSync(join(service.data, "objects", digest.slice(0, 2), digest.slice(2)));
export const remove = (t, digest) => t.ask("DELETE", `/v1/assets/${digest}`);
export const head = async (t, digest) => (await t.ask("HEAD", `/v1/assets/${digest}`)).status;
export const put = (t, bytes) => t.put(bytes, sha256(bytes));
export const job = (t, digest, more = picture, members = {}) => t.post({ scene: { asset: digest, ...members }, ...more });
export const id_of = (a) => { if (a.status !== 202) throw new Error(`not accepted: ${shown(a)}`); return JSON.parse(a.body).id; };
export const ended = (t, id) => until(60, async () => { const { state } = await t.json(`/v1/jobs/${id}`); return ["finished", "failed", "cancelled"].includes(state) && state; });
export const in_state = (t, id, state) => until(30, async () => (await t.json(`/v1/jobs/${id}`)).state === state);
export const exr = async (t, id) => { const a = await t.ask("GET", `/v1/jobs/${id}/frames/1/image.exr`); return a.status === 200 && sha256(a.body); };

export const tokens = make_tokens(build, ["a", "b"]);
export const admin = execFileSync(join(build, "shearwater"), ["token", tokens.file, "--name", "root", "--tenant", "ops", "--role", "admin"], { encoding: "utf8" }).trim();
export const viewer = execFileSync(join(build, "shearwater"), ["token", tokens.file, "--name", "eye", "--tenant", "a", "--role", "viewer"], { encoding: "utf8" }).trim();
export const all_of = (service) => ({ a: new Tenant(service, tokens.token.a), b: new Tenant(service, tokens.token.b), root: new Tenant(service, admin), eye: new Tenant(service, viewer) });
