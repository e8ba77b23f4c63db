// A web worker that computes SSIM and FLIP of two pictures while the page goes on.
import { flip } from "./flip.js";
import { displayPair } from "./display_pair.js";
import { ssim } from "./ssim.js";

addEventListener("message", ({ data }) => {
  const pair = displayPair(data), similarity = ssim(pair), errors = flip(pair);
  postMessage({ turn: data.turn, count: pair.count, ssim: similarity, flip: errors }, [similarity.map.buffer, errors.map.buffer]);
});
