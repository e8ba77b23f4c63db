// Open Image Denoise on this build's own paths, and what its time would be on this machine.

// What it took where it ran: CPU seconds a megapixel, beside tracing the Cornell box at 16 paths of 8 bounces.
const MEASURED = { oidn_s: 2.6, scene: "cornell", spp: 16, trace_s: 1.57 / (640 * 480 / 1e6) };
const TIMES = 3;
const GUIDES = ["beauty", "albedo", "normal"];

// CPU seconds a megapixel that it would take here; null where that scene is not there.
export async function denoiserSeconds(farm, scenes, jobOf) {
  const scene = scenes.find((s) => s.name === MEASURED.scene), traces = [];
  if (!scene) return null;
  const { width, height } = scene.job.image;
  for (let i = 0; i < TIMES; i++) traces.push((await farm.run(jobOf(scene, "none", MEASURED.spp, 1))).statistics.cpu_s.trace);
  return MEASURED.oidn_s * Math.min(...traces) / (width * height / 1e6) / MEASURED.trace_s;
}

// Its picture of a job's paths at `out`. job: by the method none. Its line's members: program_s is the CPU time of our
// program, denoiser_s that of OIDN, and picture_s what paths and OIDN take together; none_s: the paths' alone.
export async function denoised(farm, tools, job, { weights, out, none_s, seconds }) {
  const paths = out.replace(/\.exr$/, "-paths.exr"), megapixels = job.image.width * job.image.height / 1e6;
  await farm.run({ ...job, layers: GUIDES }, paths);
  const program_s = tools.denoise(weights, paths, out), denoiser_s = seconds === null ? null : seconds * megapixels;
  return { paths: "own", program_s, denoiser_s, picture_s: none_s === undefined || denoiser_s === null ? null : none_s + denoiser_s };
}
