// Renders Khronos' test models, and rows of balls for extensions that they lack, into one sheet with a label each.
//   khronos_sheet.mjs BUILD_DIR [WORD [OUT]]      only models whose names contain the word
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { spawnSync } from "node:child_process";
import { tmpdir } from "node:os";
import { basename, extname, join } from "node:path";
import { readExr } from "../../web/picture/exr_file.js";
import { scenesFolder } from "./folders.mjs";
import { LETTER_PX, write } from "./scenes/letters.mjs";
import { lobes } from "./scenes/lobes.mjs";
import { encodePicture, toSrgb } from "./scenes/png.mjs";

const build = process.argv[2] ?? "build", word = (process.argv[3] ?? "").toLowerCase();
const WIDTH_PX = 320, HEIGHT_PX = 240, COLUMNS = 4, GAP_PX = 6, SPP = 64, OUT = process.argv[4] ?? `${build}/khronos-sheet.png`;
const CELL_PX = { width: WIDTH_PX + GAP_PX, height: HEIGHT_PX + LETTER_PX.height + 2 * GAP_PX };

// Files of models, each in a folder of its own or beside others.
function modelsIn(folder) {
  const entries = readdirSync(folder, { withFileTypes: true }).sort((a, b) => (a.name < b.name ? -1 : 1));
  return entries.flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return modelsIn(path);
    return [".gltf", ".glb"].includes(extname(entry.name)) ? [{ name: basename(entry.name, extname(entry.name)), path }] : [];
  });
}

function madeModels(folder) {
  return Object.entries(lobes).map(([name, bytes], i) => {
    const path = join(folder, `${i}.glb`);
    writeFileSync(path, bytes);
    return { name, path };
  });
}

function renderModel({ name, path }, exr) {
  const started = Date.now();
  const run = spawnSync(`${build}/shearwater`, ["render", path, "-o", exr, "--size", `${WIDTH_PX}x${HEIGHT_PX}`, "--spp", String(SPP), "--quiet"], { encoding: "utf8" });
  console.log(`${run.status === 0 ? "ok" : "FAILED"} ${name}: ${((Date.now() - started) / 1000).toFixed(1)} s${run.stderr ? `\n  ${run.stderr.trim().replaceAll("\n", "\n  ")}` : ""}`);
  return run.status === 0;
}

async function draw(exr, rgb, width, left, top) {
  const bytes = readFileSync(exr), { channels } = await readExr(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  const shown = (value) => Math.min(255, toSrgb(Math.min(1, Math.max(0, value))));
  for (let y = 0; y < HEIGHT_PX; y++)
    for (let x = 0; x < WIDTH_PX; x++) rgb.set(["R", "G", "B"].map((c) => shown(channels.get(c)[y * WIDTH_PX + x])), 3 * ((top + y) * width + left + x));
}

const given = join(scenesFolder(), "gltf"), folder = mkdtempSync(join(tmpdir(), "shearwater-sheet-"));
try {
  if (!existsSync(given)) console.log(`skipped: ${given} is no folder of models; SHEARWATER_SCENES names another (tests/golden/README.md)`);
  const models = [...(existsSync(given) ? modelsIn(given) : []), ...madeModels(folder)].filter(({ name }) => name.toLowerCase().includes(word));
  const lines = Math.ceil(models.length / COLUMNS), width = COLUMNS * CELL_PX.width + GAP_PX, height = lines * CELL_PX.height + GAP_PX;
  const rgb = Buffer.alloc(3 * width * height, 255);
  let failed = 0;
  for (const [i, model] of models.entries()) {
    const left = GAP_PX + i % COLUMNS * CELL_PX.width, top = GAP_PX + Math.floor(i / COLUMNS) * CELL_PX.height;
    const exr = join(folder, "model.exr");
    write(`${i + 1} ${model.name}`.slice(0, Math.floor(WIDTH_PX / LETTER_PX.width)), rgb, width, left, top);
    if (renderModel(model, exr)) await draw(exr, rgb, width, left, top + LETTER_PX.height + GAP_PX);
    else failed++;
  }
  writeFileSync(OUT, encodePicture(rgb, width, height));
  console.log(`${models.length - failed} of ${models.length} models are in ${OUT}`);
  process.exitCode = failed > 0 ? 1 : 0;
} finally {
  rmSync(folder, { recursive: true, force: true });
}
