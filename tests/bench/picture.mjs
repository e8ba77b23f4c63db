// Makes README's picture: a scene at nine samples a pixel, averaged and filtered, beside its reference. The caption
// in README.md, with what each panel took and how far off it is, is written anew, too.
//   picture.mjs BUILD_DIR
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { readExr } from "../../web/picture/exr_file.js";
import { programs } from "./accuracy/programs.mjs";
import { cornell } from "./scenes/indirect.mjs";
import { light } from "./scenes/light.mjs";
import { encodePicture, toSrgb } from "./scenes/png.mjs";

const build = process.argv[2] ?? "build", ROOT = new URL("../..", import.meta.url).pathname;
const README = `${ROOT}README.md`, OUT = `${ROOT}docs/images/average-filtered-reference.png`;
const BEGIN = "<!-- caption: written by make picture -->", END = "<!-- /caption -->";
const WIDTH_PX = 252, HEIGHT_PX = 264, GAP_PX = 6;

// `runs`: the fastest counts. `step`: channels are rounded to multiples of it, which noise hides, and which halves the
// file.
const panels = [
  { title: "plain average of 9 samples per pixel", method: "average", spp: 9, runs: 5, step: 8 },
  { title: "the same 9 samples, filtered", method: "auto", spp: 9, runs: 5, step: 1 },
  { title: "reference: 4,096 paths per pixel", method: "none", spp: 4096, runs: 1, step: 1 },
];

const camera = { eye: [0.037, 0.95, 3.1], target: [0.013, 0.86, 0], yfov_deg: 41 };
const lamp = light({ center: [0.05, 1.96, 0.1], target: [0.05, 0, 0.1], halfU: 0.32, turn: 0.2, level: [0.8, 0.75, 0.68] });
const jobOf = (file, { method, spp }) => ({
  scene: { file, camera }, image: { width: WIDTH_PX, height: HEIGHT_PX }, lights: [lamp], effects: { indirect_bounces: 4 },
  sampling: { spp, seed: 1 }, filter: { method },
});

const folder = mkdtempSync(join(tmpdir(), "shearwater-picture-"));
const { render, apart } = programs(build, folder);

function renderPanel(panel, name, file) {
  const exr = join(folder, `${name}.exr`);
  const costs = Array.from({ length: panel.runs }, () => render(jobOf(file, panel), exr).cpu_s.total);
  return { ...panel, exr, cpu_s: Math.min(...costs) };
}

async function draw({ exr, step }, rgb, left, width) {
  const bytes = readFileSync(exr), { channels } = await readExr(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  const shown = (value) => Math.min(255, step * Math.round(toSrgb(Math.min(1, Math.max(0, value))) / step));
  for (let y = 0; y < HEIGHT_PX; y++)
    for (let x = 0; x < WIDTH_PX; x++) rgb.set(["R", "G", "B"].map((c) => shown(channels.get(c)[y * WIDTH_PX + x])), 3 * (y * width + left + x));
}

function captionOf(drawn) {
  const error = ({ exr }) => apart(drawn.at(-1).exr, exr, { layer: "beauty", relative: true });
  const said = drawn.map((p) => `${p.title} (${p.cpu_s < 10 ? p.cpu_s.toPrecision(2) : Math.round(p.cpu_s)} CPU seconds${p.runs > 1 ? `, RMSE ${(100 * error(p)).toPrecision(2)} %` : ""})`);
  return `*Left to right: ${said.join("; ")}. Soft shadows and four bounces of indirect light. \`make picture\` renders it.*`;
}

// The text of README before and after its caption.
function readmeAround() {
  const text = readFileSync(README, "utf8"), from = text.indexOf(BEGIN), to = text.indexOf(END);
  if (from < 0 || to < from) throw new Error(`README.md has no lines "${BEGIN}" and "${END}"`);
  return [text.slice(0, from), text.slice(to)];
}

try {
  readmeAround(); // what is wrong with it is said before the work
  const file = join(folder, "box.glb"), width = panels.length * (WIDTH_PX + GAP_PX) - GAP_PX, rgb = Buffer.alloc(3 * width * HEIGHT_PX, 255);
  writeFileSync(file, cornell());
  const drawn = panels.map((panel, i) => renderPanel(panel, i, file));
  for (const [i, panel] of drawn.entries()) await draw(panel, rgb, i * (WIDTH_PX + GAP_PX), width);
  mkdirSync(dirname(OUT), { recursive: true });
  writeFileSync(OUT, encodePicture(rgb, width, HEIGHT_PX));
  const [before, after] = readmeAround();
  writeFileSync(README, `${before}${BEGIN}\n${captionOf(drawn)}\n${after}`);
  console.log(captionOf(drawn));
} finally {
  rmSync(folder, { recursive: true, force: true });
}
