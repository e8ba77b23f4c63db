// Small pictures of jobs in lists. The address changes with the picture, so a browser asks for each once.
import { ENDED, nameOf } from "./progress_text.js";

const PACE_MS = 3000; // of a picture that forms

// alt: what it is called, "" where its name stands beside it in the same link.
export function showThumbnail(image, job, alt = nameOf(job)) {
  const { thumbnail } = job, now = Date.now();
  if (image.getAttribute("alt") !== alt) image.alt = alt;
  image.hidden = !thumbnail;
  if (!thumbnail || image.getAttribute("src") === thumbnail) return;
  if (!ENDED.has(job.state) && now - (image.shownAt ?? 0) < PACE_MS) return;
  image.shownAt = now;
  image.src = thumbnail;
}
