// Two tenants: one has queued all of its jobs before the other comes; from then on each gets its share of the
// tiles by weight, whatever their jobs' ages. Tiles are counted as the coordinator shows them.
import { check, note, readFileSync, sha256, sleep, slower, writeFileSync } from "../service.mjs";
import { Tenant, begin, make_tokens, scene_bytes, spread } from "./clients.mjs";

export const defaults = { fair_s: 60, fair_jobs: 150, fair_within: 0.05, workers: 4 };

const document_of = (asset, seed) => ({
    scene: { asset }, image: { width: 320, height: 240 }, sampling: { spp: 32, seed, tile_px: 32 }, filter: { method: "none" },
    effects: { indirect_bounces: 2 },
});

const tiles_of = async (tenant) => (await tenant.jobs()).reduce((sum, job) => sum + job.progress.tiles_done, 0);
const is_busy = async (tenant) => (await tenant.jobs()).some((job) => job.state === "queued");

// The late tenant's weight is given by the file of tokens; the early one has 1.
export const run = async (build, want, weight = 1) => {
    const { file, token } = make_tokens(build, ["early", "late"]), due = weight / (1 + weight);
    if (weight > 1) writeFileSync(file, JSON.stringify({ ...JSON.parse(readFileSync(file)), tenants: { late: { weight } } }));
    const service = await begin(build, "fair", { workers: want.workers, threads: 1, args: ["--tokens", file] });
    const early = new Tenant(service, token.early), late = new Tenant(service, token.late);
    const scene = scene_bytes(), asset = sha256(scene);
    for (const tenant of [early, late]) await tenant.put(scene, asset);
    let accepted = 0;
    const submit = (tenant) => spread(want.fair_jobs, 16, async (i) => {
        const answer = await tenant.post(document_of(asset, i));
        if (answer.status === 202) accepted++; else note(String(answer.body));
    });
    await submit(early);
    await submit(late);
    check(`${2 * want.fair_jobs} jobs are accepted`, accepted === 2 * want.fair_jobs, `${accepted}`);
    // What was given before the late one came is not shared.
    const from = [await tiles_of(early), await tiles_of(late)], begun = performance.now(), points = [];
    let gained = [0, 0], busy = true;
    while (busy && performance.now() - begun < 1000 * slower * want.fair_s) {
        await sleep(1000);
        busy = await is_busy(early) && await is_busy(late);
        if (!busy) break;
        gained = [await tiles_of(early) - from[0], await tiles_of(late) - from[1]];
        points.push([(performance.now() - begun) / 1000, 100 * gained[1] / (gained[0] + gained[1])]);
    }
    const share = gained[1] / (gained[0] + gained[1]), took_s = (performance.now() - begun) / 1000;
    note(`${gained[0]} tiles of the early tenant, ${gained[1]} of the late one in ${took_s.toFixed(0)} s`);
    check("both had work all the time", busy, `one of them ran out after ${took_s.toFixed(0)} s: give fair_jobs=`);
    check(`the late tenant, of weight ${weight}, gets ${(100 * due).toFixed(0)} % of the tiles within ${100 * want.fair_within} %: ${(100 * share).toFixed(1)} %`, Math.abs(share - due) <= want.fair_within);
    await service.kill();
    return {
        figures: { early_tiles: gained[0], late_tiles: gained[1], late_share: share, seconds: took_s },
        plots: [{ title: "Tiles of the tenant that came late", xLabel: "s since both have work", yLabel: "% of all tiles", xLog: false, yLog: false, series: [{ name: "share", points }] }],
    };
};
