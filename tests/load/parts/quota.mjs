// Quotas of tenants: jobs that have not ended, bytes of assets. Each refusal is a 429 that says when to ask
// again; nobody else's quota is touched; what ends makes room; a restart forgets nothing.
import { check, sha256, sleep } from "../service.mjs";
import { Tenant, begin, make_tokens, scene_bytes } from "./clients.mjs";

export const defaults = { quota_jobs: 50 };

const document_of = (asset, seed) => ({ scene: { asset }, image: { width: 64, height: 64 }, sampling: { spp: 4, seed } });

const is_refusal = (a) => a.status === 429 && Number(a.headers["retry-after"]) > 0 && a.headers["content-type"] === "application/problem+json" &&
    JSON.parse(a.body).type === "urn:shearwater:problem:quota-exceeded" && JSON.parse(a.body).status === 429;
const why = (a) => `${a.status} ${JSON.stringify(a.headers)} ${a.body}`;

const try_jobs = async (a, b, asset, most) => {
    const keyed = JSON.parse((await a.post(document_of(asset, 0), { "Idempotency-Key": "the-first" })).body).id;
    let last, accepted = 1;
    const answers = await Promise.all(Array.from({ length: 2 * most }, (_, i) => a.post(document_of(asset, i))));
    for (const answer of answers) if (answer.status === 202) { accepted++; last = JSON.parse(answer.body).id; }
    check(`of ${2 * most} at once ${most} are accepted`, accepted === most, `${accepted}`);
    const refused = answers.filter((x) => x.status !== 202);
    check("... and all others get 429 with Retry-After", refused.length === most + 1 && refused.every(is_refusal), refused[0] && why(refused[0]));
    // A key that is known names its job, quota or not; a new one has no room, nor has the same with another body.
    const again = await a.post(document_of(asset, 0), { "Idempotency-Key": "the-first" });
    check("... but a repeated key is answered with its job", again.status === 202 && JSON.parse(again.body).id === keyed && JSON.parse(again.body).existed, why(again));
    const other = await a.post(document_of(asset, 99), { "Idempotency-Key": "the-first" });
    check("... and refused with another body", other.status === 409, why(other));
    check("... a new key is refused", is_refusal(await a.post(document_of(asset, 0), { "Idempotency-Key": "another" })));
    check("another tenant goes on", (await b.post(document_of(asset, 0))).status === 202);
    return last;
};

const try_assets = async (a, b) => {
    const block = (mark) => Buffer.alloc(400 << 10, mark);
    const put = (tenant, mark) => tenant.put(block(mark), sha256(block(mark)));
    const first = [await put(a, 1), await put(a, 2)], beyond = await put(a, 3);
    check("assets within the quota are stored", first.every((x) => x.status === 201), why(first.at(-1)));
    check("... one beyond gets 429 with Retry-After", is_refusal(beyond), why(beyond));
    check("... and is not there", (await a.ask("HEAD", `/v1/assets/${sha256(block(3))}`)).status === 404);
    check("what one has counts once", (await put(a, 1)).status === 200);
    check("another tenant's quota is its own", (await put(b, 3)).status === 201);
};

export const run = async (build, want) => {
    const { file, token } = make_tokens(build, ["a", "b"]), most = want.quota_jobs;
    const service = await begin(build, "quota", { workers: 0, args: ["--tokens", file, "--tenant-jobs", String(most), "--tenant-assets", "1"] });
    const a = new Tenant(service, token.a), b = new Tenant(service, token.b), scene = scene_bytes(), asset = sha256(scene);
    for (const tenant of [a, b]) await tenant.put(scene, asset);
    const last = await try_jobs(a, b, asset, most);
    await try_assets(a, b);
    await service.kill();
    await service.start();
    const job = await a.post(document_of(asset, 1)), bytes = Buffer.alloc(400 << 10, 4), more = await a.put(bytes, sha256(bytes));
    check("a restart forgets neither quota", is_refusal(job) && is_refusal(more), `${why(job)} ${why(more)}`);
    check("what is called off makes room", (await a.ask("DELETE", `/v1/jobs/${last}`)).status < 300);
    let again;
    for (let i = 0; i < 50 && again?.status !== 202; i++) { again = await a.post(document_of(asset, 2)); if (again.status !== 202) await sleep(100); }
    check("... for one more", again.status === 202, why(again));
    check("... and no second", is_refusal(await a.post(document_of(asset, 3))));
    await service.kill();
    return { figures: { jobs: most, assets_mib: 1 }, plots: [] };
};
