// Every operation of proto/openapi.yaml with every kind of credential, for tests/system/access.sh:
//   access.mjs URL TOKENS.json     {"a_viewer": "sw_...", ...}, of tenants a and b, and an admin's
// What must come back follows from the contract: x-role, security and the documented statuses. TAP.
import { readFileSync } from "node:fs";
import { createHash } from "node:crypto";
import { createRequire } from "node:module";
import { request } from "node:http";

const require = createRequire(new URL("../browser/", import.meta.url));
const { parse } = require("yaml");
const contract = parse(readFileSync(new URL("../../proto/openapi.yaml", import.meta.url), "utf8"));
const [url, tokensFile] = process.argv.slice(2);
const tokens = JSON.parse(readFileSync(tokensFile, "utf8"));
const port = new URL(url).port;
const scene = readFileSync(new URL("../scenes/cornell-box/cornell-box.glb", import.meta.url));
const digest = (bytes) => createHash("sha256").update(bytes).digest("hex");
const ROLES = ["none", "viewer", "submitter", "admin"];
let count = 0, failed = 0;

function check(text, wrong) {
  count++;
  console.log(`${wrong.length ? "not ok" : "ok"} ${count} - ${text}`);
  for (const line of wrong.slice(0, 20)) console.log(`#   ${line}`);
  if (wrong.length) failed++;
}

// {status, head, body}; a stream is read for a moment.
function ask(method, path, { headers = {}, body, stream } = {}) {
  return new Promise((done, fail) => {
    const r = request(url + path, { method, headers, agent: false }, (answer) => {
      const parts = [];
      const end = () => { r.destroy(); done({ status: answer.statusCode, head: answer.headers, body: Buffer.concat(parts) }); };
      if (stream) setTimeout(end, 300);
      answer.on("data", (part) => parts.push(part));
      answer.on("end", end);
      answer.on("error", end);
    });
    r.on("error", (error) => error.code === "ECONNRESET" && stream ? null : fail(error));
    r.end(body);
  });
}
const bearer = (token) => ({ Authorization: `Bearer ${token}` });
const json = { "Content-Type": "application/json" };
const parsed = ({ body }) => JSON.parse(body.toString());

// What tenant a has.
const asset = digest(scene);
async function submit(token, more = {}, key) {
  const document = { scene: { asset }, image: { width: 64, height: 64 }, ...more };
  return ask("POST", "/v1/jobs", { headers: { ...bearer(token), ...json, ...key && { "Idempotency-Key": key } }, body: JSON.stringify(document) });
}
await ask("PUT", `/v1/assets/${asset}`, { headers: bearer(tokens.a_submitter), body: scene });
const done = parsed(await submit(tokens.a_submitter)).id;
const running = parsed(await submit(tokens.a_submitter, { image: { width: 1536, height: 1536 }, sampling: { spp: 1024 }, filter: { method: "none" } })).id;
for (let i = 0; i < 600; i++) {
  const { state } = parsed(await ask("GET", `/v1/jobs/${done}`, { headers: bearer(tokens.a_viewer) }));
  if (state === "finished") break;
  await new Promise((go) => setTimeout(go, 100));
}
const { workers } = parsed(await ask("GET", "/v1/workers", { headers: bearer(tokens.a_viewer) }));
await new Promise((go) => setTimeout(go, 500));

// How an operation is called on what tenant a has; what is not here is called by its path alone.
const recipes = {
  // What b brings is its own: a's it must not have.
  putAsset: (tenant) => tenant === "a" ? { body: scene } : { body: "b's", asset: digest("b's") },
  submitJob: () => ({ headers: json, body: JSON.stringify({ scene: { asset }, image: { width: 8, height: 8 } }) }),
  patchJob: () => ({ headers: json, body: '{"priority": 3}', id: running }),
  drainWorker: () => ({ headers: json, body: '{"drain": false}' }),
  followEvents: () => ({ stream: true }),
  followPixels: () => ({ stream: true }),
  // Each gives up his own; b tries what is a's, and so do those who may not.
  deleteAsset: async (tenant, name) => {
    if (tenant === "b") return {};
    const body = `to go: ${count} ${Math.random()}`;
    await ask("PUT", `/v1/assets/${digest(body)}`, { headers: bearer(tokens[name === "admin" ? name : "a_submitter"]), body });
    return { asset: digest(body) };
  },
  deleteJob: async (tenant) => ({ id: tenant === "a" ? parsed(await submit(tokens.a_submitter)).id : done }),
};
const fill = (path, id, sha256) => path.replace("{sha256}", sha256 ?? asset).replace("{id}", id ?? done).replace("{n}", "1")
  .replace("{worker}", workers[0].id).replace("{file}", "main.js");
const operations = Object.entries(contract.paths).flatMap(([path, item]) =>
  ["get", "head", "put", "post", "patch", "delete"].filter((m) => item[m]).flatMap((m) => {
    const one = { path, method: m.toUpperCase(), ...item[m] };
    return m === "get" ? [one, { ...one, method: "HEAD" }] : [one];
  }));
// Things that are somebody's.
const isObject = ({ path, method }) => /\{(id|sha256)\}/.test(path) && method !== "PUT";
const isPublic = (o) => o["x-role"] === "none";
const isDocumented = (o, status) => String(status) in o.responses;
const call = async (o, headers, tenant = "a", name = "a_submitter") => {
  const how = await recipes[o.operationId]?.(tenant, name) ?? {};
  return ask(o.method, fill(o.path, how.id, how.asset), { ...how, headers: { ...how.headers, ...headers }, stream: how.stream && o.method === "GET" });
};

check("every operation names its role", operations.filter((o) => !ROLES.includes(o["x-role"])).map((o) => o.operationId));
check("... and its security says the same", operations.flatMap((o) => {
  const schemes = (o.security ?? contract.security).flatMap(Object.keys);
  const wanted = isPublic(o) ? 0 : o.operationId === "signIn" ? 1 : 2;
  return schemes.length === wanted ? [] : [`${o.operationId}: ${schemes}`];
}));
const access = Object.fromEntries([...readFileSync(new URL("../../server/http/access.def", import.meta.url), "utf8")
  .matchAll(/^ACCESS\((\w+), (\w+)\)/gm)].map((m) => [m[1], m[2].toLowerCase()]));
const routes = [...readFileSync(new URL("../../server/http/route.def", import.meta.url), "utf8")
  .matchAll(/^ROUTE\((\w+), (\w+), "([^"]+)"/gm)];
check("the server's table has a role for every route, the documented one", routes.flatMap(([, name, method, path]) => {
  const o = operations.find((one) => one.path === path && one.method === method);
  return access[name] && access[name] === o?.["x-role"] ? [] : [`${name}: ${access[name]}, documented ${o?.["x-role"]}`];
}));

// Nobody.
const sessionOf = async (token) =>
  (await ask("POST", "/v1/session", { headers: bearer(token) })).head["set-cookie"]?.[0].split(";")[0];
const strangers = {
  "no credential": {},
  "an empty Authorization": { Authorization: "" },
  "a token without its scheme": { Authorization: tokens.a_submitter },
  "another scheme": { Authorization: `Basic ${Buffer.from(`a:${tokens.admin}`).toString("base64")}` },
  "a bearer of nothing": { Authorization: "Bearer " },
  "a malformed token": { Authorization: "Bearer \"'; --" },
  "a token cut by a letter": bearer(tokens.admin.slice(0, -1)),
  "a token with a letter more": bearer(`${tokens.admin}0`),
  "an unknown token": bearer(`sw_${"0".repeat(64)}`),
  "the hash of a token": bearer(digest(tokens.admin)),
  "two tokens in one": bearer(`${tokens.admin}, ${tokens.admin}`),
  "a very long token": bearer("a".repeat(8000)),
  "an unknown cookie": { Cookie: `shearwater-${port}=${"0".repeat(64)}`, Origin: url },
  "a token as a cookie": { Cookie: `shearwater-${port}=${tokens.admin}`, Origin: url },
  "a cookie of another port": { Cookie: (await sessionOf(tokens.admin)).replace(port, String(+port ^ 1)), Origin: url },
};
for (const [name, headers] of Object.entries(strangers)) {
  const wrong = [];
  for (const o of operations) {
    const answer = await call(o, headers), place = `${o.method} ${o.path}: ${answer.status}`;
    if (isPublic(o) ? answer.status >= 400 && answer.status !== 503 : answer.status !== 401) wrong.push(place);
    if (!isDocumented(o, answer.status)) wrong.push(`${place} is not documented`);
    if (answer.status === 401 && !/^Bearer/.test(answer.head["www-authenticate"])) wrong.push(`${place} without WWW-Authenticate`);
    if (answer.status === 401 && o.method !== "HEAD" && parsed(answer).type !== "urn:shearwater:problem:unauthenticated") wrong.push(`${place}: ${answer.body}`);
    if (!isPublic(o) && answer.body.includes(done)) wrong.push(`${place} tells of a job`);
  }
  check(`${name}: 401, but for what is everybody's`, wrong);
}
check("a token in the query is none", [await ask("GET", `/v1/workers?access_token=${tokens.admin}`)]
  .filter(({ status }) => status !== 400 && status !== 401).map(({ status }) => String(status)));
check("two Authorization fields are refused", [await new Promise((go, fail) => {
  const r = request(`${url}/v1/jobs`, { agent: false, headers: ["Host", `127.0.0.1:${port}`, "Authorization", `Bearer ${tokens.admin}`, "Authorization", `Bearer ${tokens.admin}`] }, (a) => { a.resume(); go(a.statusCode); });
  r.on("error", fail);
  r.end();
})].filter((status) => status !== 400).map(String));

// Each role, by header and by cookie; on what its own tenant has, and on another's.
const credentials = Object.entries(tokens).map(([name, token]) => ({ name, token, tenant: name[0] === "b" ? "b" : "a", role: name.replace(/^[ab]_/, "") }));
for (const { name, token, tenant, role } of credentials) {
  const cookie = await sessionOf(token);
  for (const [way, headers] of [["token", bearer(token)], ["cookie", { Cookie: cookie, Origin: url }]]) {
    const wrong = [];
    let allowed = 0;
    for (const o of operations) {
      if (o.operationId === "signOut" || (o.operationId === "signIn" && way === "cookie")) continue;
      const answer = await call(o, headers, tenant, name), { status } = answer, place = `${o.method} ${o.path}: ${status}`;
      if (!isDocumented(o, status)) wrong.push(`${place} is not documented`);
      const may = ROLES.indexOf(role) >= ROLES.indexOf(o["x-role"]);
      if (!may && status !== 403) wrong.push(`${place}, not 403`);
      if (may && tenant === "b" && isObject(o)) {
        if (status !== 404) wrong.push(`${place}, not 404`);
      } else if (may && o.operationId === "submitJob" && tenant === "b") {
        if (status !== 422 || !parsed(answer).type.endsWith("missing-asset")) wrong.push(`${place}, not a missing asset`);
      } else if (may) {
        if (status >= 400) wrong.push(`${place}: ${answer.body.subarray(0, 200)}`);
        allowed++;
      }
      if (tenant === "b" && (answer.body.includes(done) || answer.body.includes(running))) wrong.push(`${place} tells of another's job`);
    }
    check(`${name} by ${way}: what the role has, and ${tenant === "b" ? "nothing of another's" : "its own"} (${allowed})`, wrong);
  }
}

// Cookies and other pages.
const cookie = await sessionOf(tokens.admin);
const drain = (headers) => ask("PATCH", `/v1/workers/${workers[0].id}`, { headers: { ...json, Cookie: cookie, ...headers }, body: '{"drain": false}' });
const statuses = async (list) => (await Promise.all(list.map(async ([want, answer]) => [want, (await answer).status]))).filter(([a, b]) => a !== b).map(([a, b]) => `${b}, not ${a}`);
check("a cookie changes things only from our own page", await statuses([
  [200, drain({ Origin: url })], [403, drain({})], [403, drain({ Origin: "null" })], [403, drain({ Origin: "http://evil.example" })],
  [403, drain({ Origin: url.replace(port, "1") })], [403, drain({ Origin: url.replace("http", "https") })],
]));
const set = (await ask("POST", "/v1/session", { headers: bearer(tokens.a_viewer) })).head["set-cookie"][0];
check("the cookie is for this server and no script", ["HttpOnly", "SameSite=Strict", "Path=/", `shearwater-${port}=`].filter((part) => !set.includes(part)));
check("a cookie gets no further cookie", await statuses([[403, ask("POST", "/v1/session", { headers: { Cookie: cookie, Origin: url } })]]));
check("who one is", [
  [await ask("GET", "/v1/session", { headers: bearer(tokens.b_viewer) }), { tokens: true, name: "b_viewer", tenant: "b", role: "viewer" }],
  [await ask("GET", "/v1/session", { headers: { Cookie: cookie } }), { tokens: true, name: "admin", tenant: "ops", role: "admin" }],
  [await ask("GET", "/v1/session"), { tokens: true, name: null, tenant: null, role: null }],
].filter(([answer, want]) => JSON.stringify(parsed(answer)) !== JSON.stringify(want)).map(([answer]) => String(answer.body)));
await ask("DELETE", "/v1/session", { headers: { Cookie: cookie, Origin: url } });
check("signed out is signed out", await statuses([[401, drain({ Origin: url })]]));

// Keys and assets of tenants.
await ask("PUT", `/v1/assets/${asset}`, { headers: bearer(tokens.b_submitter), body: scene });
const mine = await submit(tokens.a_submitter, {}, "same-key"), again = await submit(tokens.a_submitter, {}, "same-key");
const theirs = await submit(tokens.b_submitter, {}, "same-key"), other = await submit(tokens.b_submitter, { priority: 1 }, "same-key");
check("a key is its tenant's own", [mine, again, theirs].some((a) => a.status !== 202) || parsed(mine).id !== parsed(again).id ||
  parsed(mine).id === parsed(theirs).id || parsed(theirs).existed || other.status !== 409 ? [`${mine.body} ${again.body} ${theirs.body} ${other.status}`] : []);
const secret = Buffer.from(`a's own ${Math.random()}`), own = digest(secret);
await ask("PUT", `/v1/assets/${own}`, { headers: bearer(tokens.a_submitter), body: secret });
const naming = (member) => ask("POST", "/v1/jobs", { headers: { ...bearer(tokens.b_submitter), ...json }, body: JSON.stringify(member) });
const refusals = await Promise.all([naming({ scene: { asset: own } }), naming({ scene: { asset, files: { "x.bin": own } } }),
  naming({ scene: { asset }, environment: { asset: own } })]);
check("another's asset cannot be named, wherever", refusals.filter((a) => a.status !== 422 || !parsed(a).type.endsWith("missing-asset")).map((a) => String(a.body)));
const put = await ask("PUT", `/v1/assets/${own}`, { headers: bearer(tokens.b_submitter), body: secret });
check("uploading it is being told nothing of others", [put.status === 201 ? "" : `${put.status}`].filter(Boolean));
check("... and makes it one's own", await statuses([[200, ask("HEAD", `/v1/assets/${own}`, { headers: bearer(tokens.b_submitter) })]]));
const listOf = async (token) => parsed(await ask("GET", "/v1/jobs?limit=100", { headers: bearer(token) })).jobs;
const [ofA, ofB, all] = [await listOf(tokens.a_viewer), await listOf(tokens.b_viewer), await listOf(tokens.admin)];
check("lists are of one tenant, an admin's of all", ofA.some((j) => j.owner !== "a") || ofB.some((j) => j.owner !== "b") || ofB.length === 0 ||
  new Set(all.map((j) => j.owner)).size < 2 ? [JSON.stringify([ofA.length, ofB.map((j) => j.owner), all.length])] : []);
const found = parsed(await ask("GET", `/v1/jobs?text=${done}`, { headers: bearer(tokens.b_viewer) })).jobs;
const byState = parsed(await ask("GET", "/v1/jobs?state=finished", { headers: bearer(tokens.b_viewer) })).jobs;
check("looking for it finds nothing of others", [...found, ...byState].filter((j) => j.owner !== "b").map((j) => j.id));

console.log(`1..${count}`);
process.exitCode = failed ? 1 : 0;
