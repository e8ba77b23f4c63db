// Where a layer's pixels come from: the feed of a job, followed while somebody looks, and gone on
// with from its revision when somebody looks again.
import { getJob, pixelsUrl } from "./api.js";
import { LayerImage } from "./layer_image.js";
import { followPixels } from "./pixel_feed.js";

const FLOATS = new Set(["depth", "id", "samples"]); // more than a half float can tell apart
const KEPT = 6; // layers whose pixels stay when nobody looks
const STILL = 1n; // the revision of pictures that will not change any more
const ENDED = new Set(["finished", "failed", "cancelled"]);

export class LayerSource {
  constructor(job, layer) {
    this.job = job;
    this.layer = layer;
    this.image = new LayerImage();
    this.revision = null;
    this.whole = false; // the job has finished and all of its picture is here
  }

  follow(onChange, onState) {
    this.stop();
    if (this.whole) return;
    const format = FLOATS.has(this.layer) ? "float" : "half";
    const feed = (after, onEnd) => {
      this.stopFeed = followPixels((revision) => pixelsUrl(this.job, this.layer, format, revision), after, (block) => {
        this.image.put(block);
        this.revision = block.revision;
        onChange(this);
      }, (state, error) => {
        onState(state, error);
        if (state === "ended") onEnd();
      });
    };
    // A live feed may end with blocks unsent; that of a finished job gives the whole picture.
    const look = async () => {
      this.whole = this.revision === STILL;
      if (this.whole) return;
      let state = null;
      try { ({ state } = await getJob(this.job)); } catch (error) { if (error.status === 404) return; }
      if (this.stopFeed === null) return;
      if (state === "finished") feed(null, look);
      else if (!ENDED.has(state)) this.again = setTimeout(() => feed(this.revision, look), 500);
    };
    this.stopFeed = () => {};
    if (this.revision === null) feed(null, look);
    else look();
  }

  stop() {
    clearTimeout(this.again);
    this.stopFeed?.();
    this.stopFeed = null;
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

  forget(name) {
    const source = this.kept.get(name);
    source.stop();
    this.kept.delete(name);
    this.onForget(source);
  }

  clear() { for (const name of [...this.kept.keys()]) this.forget(name); }
}
