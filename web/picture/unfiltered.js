// A job's twin without filters: the same document and seed. Without a lens these are the same samples,
// averaged; with one, whose filter lets samples share light, they are paths with light of their own.
// What a filter or a target error adds to the plan's samples is left out. The key makes it one job,
// however often it is asked for.
import { getJob, submitJob } from "../api.js";

const AVERAGE = { method: "average", indirect: "average", glossy: "average", lens: "average" };

// {id, layers} of the twin. Throws with a sentence when there is nothing to leave out.
export async function unfilteredTwin(job) {
  const { document, view } = await getJob(job);
  const filter = document?.filter ?? {};
  if (filter.method === "none") throw new Error("This job has no filters: its paths are averaged already.");
  if (Object.keys(AVERAGE).every((name) => filter[name] === AVERAGE[name])) throw new Error("This job is unfiltered already.");
  const layers = document.layers.filter((name) => name !== "filter_width");
  const { lens_extra, target_error, max_spp, ...sampling } = document.sampling ?? {};
  const twin = { ...document, live: false, sampling, filter: { ...filter, ...AVERAGE }, layers: layers.length > 0 ? layers : ["beauty"] };
  return { id: (await submitJob(twin, `unfiltered-${job}${view ? `-${view.number}` : ""}`)).id, layers: twin.layers };
}
