// proto/openapi.yaml as a judge: for tests/system/openapi.sh.
//   contract.mjs structure                                   every reference leads somewhere, and so on
//   contract.mjs operations                                  METHOD PATH QUERY,QUERY... a line
//   contract.mjs statuses METHOD PATH                        the documented ones
//   contract.mjs check METHOD PATH STATUS TYPE HEAD BODY     an answer (files HEAD and BODY) fits
//   contract.mjs schema NAME FILE                            a JSON document fits components/schemas/NAME
//   contract.mjs judge                                       questions like these from standard input
// Exit status 0 when all is well; else what is wrong on standard output.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { createInterface } from "node:readline";

const require = createRequire(new URL("../browser/", import.meta.url));
const { parse } = require("yaml");
const contract = parse(readFileSync(new URL("../../proto/openapi.yaml", import.meta.url), "utf8"));
const METHODS = ["get", "head", "put", "post", "patch", "delete"];

function resolve(node) {
  if (!node?.$ref) return node;
  let at = contract;
  for (const part of node.$ref.replace(/^#\//, "").split("/"))
    at = at?.[part.replaceAll("~1", "/").replaceAll("~0", "~")];
  if (at === undefined) throw new Error(`${node.$ref} leads nowhere`);
  const { $ref, ...siblings } = node;
  return { ...resolve(at), ...siblings };
}

const KEYWORDS = new Set(["type", "enum", "const", "pattern", "minLength", "maxLength", "minimum", "maximum",
  "exclusiveMinimum", "minItems", "maxItems", "uniqueItems", "items", "required", "properties",
  "additionalProperties", "minProperties", "maxProperties", "oneOf", "description", "default", "example", "format",
  "contentMediaType"]);

const typeOf = (v) => v === null ? "null" : Array.isArray(v) ? "array" :
  Number.isInteger(v) ? "integer" : typeof v;
const isType = (v, want) => typeOf(v) === want || (want === "number" && typeOf(v) === "integer");

// The part of JSON Schema 2020-12 that the contract uses. Returns what does not fit.
function misfits(value, schema, at = "") {
  const s = resolve(schema);
  const found = [];
  const say = (text) => found.push(`${at || "/"}: ${text}`);
  for (const key of Object.keys(s)) if (!KEYWORDS.has(key)) say(`the schema's keyword ${key} is unknown here`);
  if (s.type && ![s.type].flat().some((t) => isType(value, t))) { say(`${typeOf(value)} is not ${s.type}`); return found; }
  if (s.enum && !s.enum.includes(value)) say(`${JSON.stringify(value)} is none of ${s.enum}`);
  if ("const" in s && s.const !== value) say(`${JSON.stringify(value)} is not ${JSON.stringify(s.const)}`);
  if (s.oneOf) {
    const tries = s.oneOf.map((one) => misfits(value, one, at));
    if (tries.filter((t) => t.length === 0).length !== 1) say(`fits not one of ${s.oneOf.length}: ${tries.flat()}`);
  }
  if (typeof value === "number") {
    if (value < s.minimum) say(`${value} is below ${s.minimum}`);
    if (value > s.maximum) say(`${value} is above ${s.maximum}`);
    if (value <= s.exclusiveMinimum) say(`${value} is not above ${s.exclusiveMinimum}`);
  }
  if (typeof value === "string") {
    if (s.pattern && !new RegExp(s.pattern, "u").test(value)) say(`"${value}" does not match ${s.pattern}`);
    if (value.length < s.minLength || value.length > s.maxLength) say("wrong length");
    if (s.format === "date-time" && Number.isNaN(Date.parse(value))) say(`"${value}" is no time`);
  }
  if (Array.isArray(value)) {
    if (value.length < s.minItems || value.length > s.maxItems) say(`${value.length} items`);
    if (s.uniqueItems && new Set(value.map((v) => JSON.stringify(v))).size < value.length) say("repeated items");
    if (s.items) value.forEach((v, i) => found.push(...misfits(v, s.items, `${at}/${i}`)));
  } else if (typeOf(value) === "object") {
    for (const name of s.required ?? []) if (!(name in value)) say(`${name} is missing`);
    if (Object.keys(value).length < s.minProperties) say("too few members");
    if (Object.keys(value).length > s.maxProperties) say("too many members");
    for (const [name, v] of Object.entries(value)) {
      if (s.properties && name in s.properties) found.push(...misfits(v, s.properties[name], `${at}/${name}`));
      else if (s.additionalProperties === false) say(`${name} is unknown`);
      else if (s.additionalProperties) found.push(...misfits(v, s.additionalProperties, `${at}/${name}`));
    }
  }
  return found;
}

const operations = () => Object.entries(contract.paths).flatMap(([path, item]) =>
  METHODS.filter((m) => item[m]).map((m) => ({ path, method: m.toUpperCase(), item, operation: item[m] })));
const parametersOf = ({ item, operation }) =>
  [...item.parameters ?? [], ...operation.parameters ?? []].map(resolve);
function find(method, path) {
  const one = operations().find((o) => o.path === path && o.method === method);
  if (!one) throw new Error(`${method} ${path} is not documented`);
  return one;
}

function structure() {
  const wrong = [], ids = new Set(), used = new Set();
  (function walk(node) {
    if (node === null || typeof node !== "object") return;
    if (node.$ref) { used.add(node.$ref); try { resolve(node); } catch (e) { wrong.push(e.message); } }
    Object.values(node).forEach(walk);
  })(contract);
  for (const { security } of [contract, ...operations().map((o) => o.operation)])
    for (const name of (security ?? []).flatMap(Object.keys)) used.add(`#/components/securitySchemes/${name}`);
  for (const [group, members] of Object.entries(contract.components))
    for (const name of Object.keys(members)) {
      const mention = new RegExp(`\`${name}\``);
      if (!used.has(`#/components/${group}/${name}`) && !mention.test(JSON.stringify(contract.paths)))
        wrong.push(`components/${group}/${name} is not used`);
    }
  for (const o of operations()) {
    const place = `${o.method} ${o.path}`;
    if (!o.operation.operationId || ids.has(o.operation.operationId)) wrong.push(`${place}: operationId`);
    ids.add(o.operation.operationId);
    const named = [...o.path.matchAll(/\{(\w+)\}/g)].map((m) => m[1]).sort().join();
    const inPath = parametersOf(o).filter((p) => p.in === "path").map((p) => p.name).sort().join();
    if (named !== inPath) wrong.push(`${place}: path parameters ${inPath}, not ${named}`);
    for (const [status, response] of Object.entries(o.operation.responses)) {
      const content = Object.keys(resolve(response).content ?? {});
      if (status >= 400 && content.join() !== "application/problem+json") wrong.push(`${place} ${status}: no problem`);
    }
    for (const [type, media] of Object.entries(o.operation.requestBody?.content ?? {}))
      for (const [name, example] of Object.entries(media.examples ?? {}))
        wrong.push(...misfits(example.value, media.schema).map((m) => `${place} ${type} ${name}${m}`));
  }
  return wrong;
}

function check([method, path, status, type, headFile, bodyFile]) {
  const response = resolve(find(method, path).operation.responses[status]);
  if (!response) return [`${status} is not documented`];
  const media = response.content?.[type];
  const wrong = [];
  const body = readFileSync(bodyFile);
  if (!response.content && (type || body.length)) wrong.push(`a body of ${type}, none is documented`);
  if (response.content && !media && method !== "HEAD") return [`"${type}" is not documented`];
  if (media && /json$/.test(type) && method !== "HEAD") wrong.push(...misfits(JSON.parse(body), media.schema));
  const head = readFileSync(headFile, "utf8").toLowerCase();
  for (const name of ["ETag", "Location", "Content-Range"])
    if (response.headers?.[name] && response.headers[name].required !== false && !head.includes(`\n${name.toLowerCase()}:`)) wrong.push(`${name} is missing`);
  return wrong;
}

const commands = {
  structure,
  check,
  schema: ([name, file]) => misfits(JSON.parse(readFileSync(file, "utf8")), { $ref: `#/components/schemas/${name}` }),
  statuses: ([method, path]) => {
    console.log(Object.keys(find(method, path).operation.responses).join("\n"));
    return [];
  },
  operations: () => {
    for (const o of operations())
      console.log(o.method, o.path, parametersOf(o).filter((p) => p.in === "query").map((p) => p.name).sort().join());
    return [];
  },
};
function judge([command, ...rest]) {
  let wrong;
  try { wrong = commands[command](rest); } catch (error) { wrong = [error.message]; }
  for (const line of wrong) console.log(line);
  return wrong.length ? 1 : 0;
}

const words = process.argv.slice(2);
if (words[0] !== "judge") process.exitCode = judge(words);
else // one process for a whole test: a question a line, words between tabs; an answer ends with "= STATUS"
  for await (const line of createInterface({ input: process.stdin })) console.log(`= ${judge(line.split("\t"))}`);
