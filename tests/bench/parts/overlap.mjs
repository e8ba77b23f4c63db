// What is left to do when a frame's last tile has come: decoding, filtering and encoding overlap with tracing,
// so that little is. And what links cost: the same frames over a Unix socket, over TCP, and under a key.
import { BOX, SMALL, withFarm } from "./farms.mjs";
import { median, summary } from "./runs.mjs";

const BOUND = 0.1, LOOSE = 4, LINKS = ["unix", "tcp", "sealed"];
const JOBS = {
  shadows: { about: "soft shadows, sheared", job: { effects: {} } },
  indirect: { about: "soft shadows and one bounce, weighted means", job: { effects: { indirect_bounces: 1 } } },
  lens: { about: "both through a lens, sheared", job: { effects: { indirect_bounces: 1 }, lens: { aperture_radius: 0.05, focus_distance: 6.5 } } } };

const jobOf = (name, [width, height]) => ({ scene: { file: BOX }, image: { width, height }, sampling: { spp: 9, seed: 1 }, layers: ["beauty"], ...JOBS[name].job });

export async function overlap(o) {
  await withFarm(o, { workers: o.cores }, async (farm) => {
    for (const name of Object.keys(JOBS)) {
      await farm.run(jobOf(name, [SMALL.width, SMALL.height]));
      for (const size of o.overlapSizes) {
        const [width, height] = size, runs = [];
        o.say(`overlap: ${name}, ${width}×${height}`);
        for (let i = 0; i < o.repeat; i++) runs.push(await farm.run(jobOf(name, size)));
        const late = runs.map(({ wall }) => wall.after_last_tile / wall.frame), value = median(late), what = `${name}, ${width}×${height}`;
        o.put("overlap", what, { kind: name, about: JOBS[name].about, width, height, late, ...summary(runs) });
        o.put("figure", `overlap ${what}`, { from: "overlap", figure: `${what}: after the last tile, of the frame's wall time`, value: Number(value.toPrecision(3)), bound: `<= ${BOUND}`, unit: "share", ok: value <= BOUND });
        // Other work on the machine moves it: the least says what the program does, of pictures that take longer
        // than a file's way to the disk.
        if (o.mode !== "smoke" && Math.min(...late) > LOOSE * BOUND) o.fail(`overlap: of ${what} ${(100 * Math.min(...late)).toFixed(0)} % of the frame's wall time came after the last tile`);
      }
    }
  });
}

async function withFarms(o, links, run, farms = []) {
  const [link, ...rest] = links;
  if (!link) return run(farms);
  return withFarm(o, { workers: o.cores, link }, (farm) => withFarms(o, rest, run, [...farms, { link, farm }]));
}

// In turn, so that what else the machine does meets all alike.
export async function links(o) {
  await withFarms(o, LINKS, async (farms) => {
    for (const name of Object.keys(JOBS)) {
      o.say(`links: ${name}`);
      const job = jobOf(name, o.overlapSizes.at(-1)), [width, height] = o.overlapSizes.at(-1), runs = farms.map(() => []);
      for (const { farm } of farms) await farm.run(jobOf(name, [SMALL.width, SMALL.height]));
      for (let i = 0; i < o.repeat; i++)
        for (const [k, { farm }] of farms.entries()) runs[k].push(await farm.run(job));
      const over = (k, of) => median(runs[k].map((r, i) => of(r) / of(runs[0][i]))), least = (k, of) => Math.min(...runs[k].map(of)) / Math.min(...runs[0].map(of));
      farms.forEach(({ link }, k) => o.put("links", `${name} ${link}`, { kind: name, about: JOBS[name].about, link_kind: link, width, height, ...summary(runs[k]),
        over_unix: { cpu: least(k, (r) => r.statistics.cpu_s.total), coordinate: least(k, (r) => r.statistics.cpu_s.coordinate), wall: over(k, (r) => r.wall.frame) } }));
    }
  });
}
