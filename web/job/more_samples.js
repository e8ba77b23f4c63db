// A job once more with four times the samples: the same document otherwise, as if it had been
// submitted with them. The key makes it one job, however often it is asked for.
import { getJob, submitJob } from "../api.js";

const MOST = 65536; // samples a pixel, of any kind (proto/limits.h)
const EXTRA_MAX = 36; // of second sets through a lens
const TRIES = 16;
const more = (n) => Math.min(MOST, 4 * n);

// The document with more samples. Those of 0 follow spp. A job that samples until an error is reached
// aims at half of it, which takes four times the samples.
export function withMoreSamples(document) {
  const { sampling } = document;
  if (!(sampling.spp < MOST)) throw new Error(`This job has ${sampling.spp} samples per pixel, which is the most.`);
  const changed = {};
  for (const name of ["light_spp", "indirect_spp", "lens_spp", "lens_extra", "max_spp"])
    if (sampling[name] > 0) changed[name] = Math.min(more(sampling[name]), name === "lens_extra" ? EXTRA_MAX : MOST);
  if (sampling.target_error > 0) changed.target_error = sampling.target_error / 2;
  else changed.spp = more(sampling.spp);
  return { ...document, live: false, sampling: { ...sampling, ...changed } };
}

// {id, spp} of the job with more. One that was called off or failed is not given again: the next one is.
export async function submitMore(job) {
  const { document: before, view } = await getJob(job), document = withMoreSamples(before);
  let key = `more-${job}${view ? `-${view.number}` : ""}`; // a live job is another with each move
  for (let i = 0; i < TRIES; i++) {
    const { id, existed } = await submitJob(document, key);
    if (!existed) return { id, document };
    const { state } = await getJob(id);
    if (state !== "failed" && state !== "cancelled") return { id, document };
    key = `more-${id}`;
  }
  throw new Error("Every job with more samples was cancelled or failed.");
}
