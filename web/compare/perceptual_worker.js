// A worker: judges two pictures beside the page, which goes on meanwhile.
import { flip } from "./flip.js";
import { shownPair } from "./shown.js";
import { ssim } from "./ssim.js";

addEventListener("message", ({ data }) => {
  const pair = shownPair(data), likeness = ssim(pair), errors = flip(pair);
  postMessage({ turn: data.turn, count: pair.count, ssim: likeness, flip: errors }, [likeness.map.buffer, errors.map.buffer]);
});
