// The source of a layer's pixels: the feed of a job. It is followed while the layer is looked at, and
// resumed from its revision when it is looked at again.
import { getJob, pixelsUrl } from "../api.js";
import { LayerImage } from "./layer_image.js";
import { followPixels } from "./pixel_feed.js";

const FLOATS = new Set(["depth", "id", "samples"]); // more than a half float can tell apart
const KEPT = 6; // layers whose pixels are kept when they are not looked at
const STILL = 1n; // the revision of a whole picture that will not change any more
const ENDED = new Set(["finished", "failed", "cancelled"]);
const PAUSE_MS = 500, LONGEST_PAUSE_MS = 8000; // before a feed is asked for again

export class LayerSource {
  // `frame`: a finished one; null for what the feed shows.
  constructor(job, layer, frame = null) {
    this.job = job;
    this.layer = layer;
    this.frame = frame;
    this.image = new LayerImage();
    this.revision = null;
    this.whole = false; // the job has finished and all of its picture is here
    this.live = false; // more may come
  }

  // `onState` gets those of the feed, "refused" with the reason when a finished job's picture is not
  // to be had, and "still" when nothing more will come.
  follow(onChange, onState) {
    this.stop();
    if (this.whole) return;
    const turn = this.turn = {}; // whatever belongs to an earlier one comes too late
    let pause = PAUSE_MS;
    this.live = true;
    this.stopFeed = () => {};
    const rest = (state, error) => {
      this.live = false;
      if (error) onState(state, error);
      onState("still");
    };
    const feed = (after, finished) => {
      this.stopFeed = followPixels((revision) => pixelsUrl(this.job, this.layer, this.format, revision, this.layer === "beauty", this.frame), after, (block) => {
        this.image.put(block);
        this.revision = block.revision;
        onChange(this);
      }, (state, error) => {
        if (this.turn !== turn) return;
        if (state === "refused" && finished) { rest(state, error); return; } // it would be again
        if (state !== "refused") onState(state, error);
        if (state === "live" || state === "lost") return;
        this.whole = state === "ended" && this.revision === STILL;
        if (this.whole) rest();
        else look(finished);
      });
    };
    const later = (after, finished, wait) => { this.again = setTimeout(() => feed(after, finished), wait); };
    // A live feed may end with blocks unsent; that of a finished job gives the whole picture, unless
    // the coordinator stops.
    const look = async (cutShort) => {
      let state = null;
      try { ({ state } = await getJob(this.job)); } catch (error) { if (error.status === 404) state = "gone"; }
      if (this.turn !== turn) return;
      if (state === "finished" && cutShort) {
        later(null, true, pause);
        pause = Math.min(2 * pause, LONGEST_PAUSE_MS);
      } else if (state === "finished") feed(null, true);
      else if (state === "gone" || ENDED.has(state)) rest();
      else later(this.revision, false, PAUSE_MS);
    };
    if (this.revision === null) feed(null, false);
    else look(false);
  }

  get format() { return FLOATS.has(this.layer) ? "float" : "half"; }

  stop() {
    clearTimeout(this.again);
    this.stopFeed?.();
    this.stopFeed = this.turn = null;
    this.live = false;
  }
}

// The layers that were looked at last.
export class LayerSources {
  constructor(onForget) { this.onForget = onForget; this.kept = new Map(); }

  get(job, layer) {
    const name = `${job} ${layer}`;
    const source = this.kept.get(name) ?? new LayerSource(job, layer);
    this.kept.delete(name);
    this.kept.set(name, source); // the youngest is last
    for (const [old, { stopFeed }] of this.kept) {
      if (this.kept.size <= KEPT) break;
      if (!stopFeed && old !== name) this.forget(old);
    }
    return source;
  }

  // All that there are of a job.
  of(job) { return [...this.kept.values()].filter((source) => source.job === job); }

  forget(name) {
    const source = this.kept.get(name);
    source.stop();
    this.kept.delete(name);
    this.onForget(source);
  }

  clear() { for (const name of [...this.kept.keys()]) this.forget(name); }
}
