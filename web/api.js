// The HTTP contract (proto/openapi.yaml) as functions. Errors carry the server's own words.
import { askForToken } from "./sign_in.js";

export class ApiError extends Error {
  constructor(status, problem) {
    if (status === 401) askForToken(); // whatever it was that wanted one
    super(problem?.detail ?? problem?.title ?? `the server answered ${status}`);
    this.status = status;
    this.pointer = problem?.pointer;
  }
}

async function request(path, options) {
  const response = await fetch(path, { cache: "no-store", ...options });
  const text = await response.text();
  let body = null;
  try { body = text ? JSON.parse(text) : null; } catch { /* told by the status below */ }
  if (!response.ok) throw new ApiError(response.status, body);
  return body;
}

export const listJobs = (cursor) =>
  request(`/v1/jobs?limit=50${cursor ? `&cursor=${encodeURIComponent(cursor)}` : ""}`);
export const getJob = (id) => request(`/v1/jobs/${id}`);
export const cancelJob = (id) => request(`/v1/jobs/${id}`, { method: "DELETE" });
// What `change` has: priority, paused, region, near; or name, comment, labels, of a job that has ended, too. `last`: also while the page is left.
export const steerJob = (id, change, last = false) => request(`/v1/jobs/${id}`, {
  method: "PATCH", headers: { "Content-Type": "application/json" }, body: JSON.stringify(change), keepalive: last,
});
// The answer's view is what the feed names before its pixels.
export const moveCamera = (id, change) => request(`/v1/jobs/${id}`, {
  method: "PATCH", headers: { "Content-Type": "application/json" }, body: JSON.stringify(change),
});
// The same key is the same job.
export const submitJob = (document, key) => request("/v1/jobs", {
  method: "POST", headers: { "Content-Type": "application/json", "Idempotency-Key": key }, body: JSON.stringify(document),
});
export const listWorkers = () => request("/v1/workers");
export const eventsUrl = (id) => `/v1/jobs/${id}/events`;
// `after`: the revision that is there already, a BigInt; null for none. `alpha`: where it is not 1, too. `frame`: a
// finished one; null for what the feed shows.
export const pixelsUrl = (id, layer, format, after, alpha, frame = null) =>
  `/v1/jobs/${id}/pixels?layer=${encodeURIComponent(layer)}&format=${format}${alpha ? "&alpha=1" : ""}${after === null ? "" : `&after=${after}`}${frame === null ? "" : `&frame=${frame}`}`;
export const imageUrl = (id, frame, kind) => `/v1/jobs/${id}/frames/${frame}/image.${kind}`;
// What is at an address, unless it still is what `tag` names: {body, tag}, or null.
export async function getChanged(path, tag) {
  const response = await fetch(path, { cache: "no-store", headers: tag ? { "If-None-Match": tag } : {} });
  if (response.status === 304) return null;
  const body = await response.json().catch(() => null);
  if (!response.ok) throw new ApiError(response.status, body);
  return { body, tag: response.headers.get("ETag") };
}
export const jobUrl = (id) => `/v1/jobs/${id}`;
// Of those of {state, name, label, text, cursor, limit} that say something. A form's "+" is no blank there.
export const jobsUrl = (query) => `/v1/jobs?${Object.entries(query).filter(([, value]) => value)
  .map(([name, value]) => `${name}=${encodeURIComponent(value)}`).join("&")}`;
export const workersUrl = "/v1/workers";
export const drainWorker = (id, drain) => request(`/v1/workers/${id}`, {
  method: "PATCH", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ drain }),
});
// {plan} of a document that is only checked.
export const planJob = (document, signal) => request("/v1/jobs?dry_run=1", {
  method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(document), signal,
});
export async function hasAsset(sha256) {
  const { status } = await fetch(`/v1/assets/${sha256}`, { method: "HEAD", cache: "no-store" });
  if (status === 401) throw new ApiError(status, null);
  return status === 200;
}
export const assetUrl = (sha256) => `/v1/assets/${sha256}`;
