// The HTTP contract (proto/openapi.yaml) as functions. Errors carry the server's own words.

export class ApiError extends Error {
  constructor(status, problem) {
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
// The same key is the same job.
export const submitJob = (document, key) => request("/v1/jobs", {
  method: "POST", headers: { "Content-Type": "application/json", "Idempotency-Key": key }, body: JSON.stringify(document),
});
export const listWorkers = () => request("/v1/workers");
export const eventsUrl = (id) => `/v1/jobs/${id}/events`;
// `after`: the revision that is there already, a BigInt; null for none. `alpha`: where it is not 1, too.
export const pixelsUrl = (id, layer, format, after, alpha) =>
  `/v1/jobs/${id}/pixels?layer=${encodeURIComponent(layer)}&format=${format}${alpha ? "&alpha=1" : ""}${after === null ? "" : `&after=${after}`}`;
export const imageUrl = (id, frame, kind) => `/v1/jobs/${id}/frames/${frame}/image.${kind}`;
