// A picture file of the person's own, to compare with: an EXR's layers, or a PNG's colours made
// linear. It never leaves the page.
import { readExr } from "./exr_file.js";
import { LayerImage } from "./layer_image.js";

const SETS = ["RGB", "XYZ"];

export class PictureFile {
  // `layers`: Map of a layer's name to its three channels; a fourth is its alpha.
  constructor(name, width, height, layers) { Object.assign(this, { name, width, height, layers }); }

  names() { return [...this.layers.keys()]; }

  // The layer as what the picture view shows; there is nothing to follow.
  source(layer) {
    const image = new LayerImage(), { width, height } = this;
    const channels = this.layers.get(layer), numbers = new Float32Array(width * height * 3);
    for (let i = 0; i < width * height; i++) for (let c = 0; c < 3; c++) numbers[i * 3 + c] = channels[c][i];
    image.resize(width, height);
    image.put({ x: 0, y: 0, w: width, h: height, numbers, alpha: channels[3] ?? null });
    return { job: this.name, layer, frame: null, image, stopFeed: null, follow() {}, stop() {} };
  }
}

export async function readPictureFile(file) {
  const head = new Uint8Array(await file.slice(0, 4).arrayBuffer());
  if (head[0] === 0x76 && head[1] === 0x2f) return fromExr(file.name, await readExr(await file.arrayBuffer()));
  if (head[0] === 0x89 && head[1] === 0x50) return fromPng(file);
  throw new Error("Only EXR and PNG files can be compared with.");
}

// R G B are beauty; direct.R .G .B the layer direct; depth.Z alone a layer of one number.
function fromExr(name, { width, height, channels }) {
  const groups = new Map();
  for (const [channel, values] of channels) {
    const dot = channel.lastIndexOf("."), layer = dot < 0 ? "beauty" : channel.slice(0, dot);
    if (!groups.has(layer)) groups.set(layer, new Map());
    groups.get(layer).set(channel.slice(dot + 1), values);
  }
  const layers = new Map();
  for (const [layer, group] of groups) {
    const set = SETS.find((letters) => [...letters].every((letter) => group.has(letter)));
    const one = group.values().next().value;
    const alpha = set === "RGB" && group.has("A") ? [group.get("A")] : [];
    layers.set(layer, set ? [...[...set].map((letter) => group.get(letter)), ...alpha] : [one, one, one]);
  }
  return new PictureFile(name, width, height, layers);
}

async function fromPng(file) {
  const bitmap = await createImageBitmap(file, { premultiplyAlpha: "none", colorSpaceConversion: "none" });
  const { width, height } = bitmap, canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d");
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, width, height);
  const linear = Float32Array.from({ length: 256 }, (_, i) => i / 255 <= 0.04045 ? i / 255 / 12.92 : ((i / 255 + 0.055) / 1.055) ** 2.4);
  const layer = [0, 1, 2].map((c) => Float32Array.from({ length: width * height }, (_, i) => linear[data[i * 4 + c]]));
  return new PictureFile(file.name, width, height, new Map([["beauty", layer]]));
}
