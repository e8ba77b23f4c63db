#!/usr/bin/env bash
# The accuracy bench on a tiny picture: it runs, its figures have their shape, its arithmetic holds.
#   tests/system/accuracy.sh BUILD_DIR
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/accuracy.sh BUILD_DIR}
. tests/tap.bash

bench() { # missed bounds are no failure here: the picture is far too small for them
    local status=0
    node tests/bench/accuracy.mjs "$build" smoke "out=$tmp/bench" >"$tmp/lines" || status=$?
    [ $status -le 1 ]
}
lines() { jq -es "$1" "$tmp/bench/accuracy.jsonl"; }

check "the bench runs" bench
check "a line for each scene, method and count" lines '[.[] | [.scene, .method, .spp, .mu]] | length == 27 and (unique | length) == 27'
check "every figure is there" lines 'all(.[]; .finite and .judged.rmse > 0 and .judged.pixels > 100 and
    .judged.relmse > 0 and .judged.p999 > .judged.rmse and .cpu_s.trace > 0 and .cpu_s.judged > 0 and
    .wall_s > 0 and .rays.shadow > 0 and (.effect != "lens" or .away.rmse > 0)
    and (.effect != "combined" or (.away.rmse > 0 and .edges.rmse > 0)) and .peak_rss_bytes.worker > 0 and .reference.spp > 0)'
for effect in shadows indirect lens combined; do
    check "$effect: more samples, less error" lines '[.[] | select(.effect == "'$effect'" and .method == "average") | .judged.rmse]
        | length == 3 and . == (sort | reverse)'
done
check "the references are closer than what they judge" lines 'all(.[]; .reference.halves_rmse < .judged.rmse)'
check "every error that a reference's share is taken off has its doubt" lines 'all(.[]; if .effect == "shadows" then .judged.doubt == null
    else .judged.doubt > 0 and .judged.doubt < 0.25 and .reference.doubt > 0 end)'
check "filters take time, the plain average none" lines 'all(.[]; (.cpu_s[{shadows: "shadow", indirect: "indirect", lens: "lens", combined: "lens_relight"}[.effect]] > 0)
    == (.method != "average" and .method != "paths"))'
check "all filters are counted as time of filters" lines '[.[] | select(.scene == "all_box" and .method == "auto")]
    | length == 1 and all(.[]; .cpu_s | [.shadow, .indirect, .lens, .lens_relight] | all(. > 0))
    and all(.[].cpu_s; .judged as $all | [.trace, .pack, .decode, .reconstruct, .shadow, .indirect, .glossy, .lens, .lens_relight] | add - $all | fabs < 1e-6)'
check "all filters together take off more than half of the error" lines '[.[] | select(.scene == "all_box" and .spp == 9)] | INDEX(.method)
    | .auto.judged.rmse < 0.5 * .average.judged.rmse'
check "auto is one of the filters" lines '[.[] | select(.scene == "box" and .spp == 16)] | INDEX(.method)
    | .auto.judged.rmse == .constant.judged.rmse'
check "pictures have the path tracer's light" lines 'all(.[] | select(.effect == "indirect" or .effect == "combined"); .beauty.energy > 0.97 and .beauty.energy < 1.03)'
check "plots and a page" test -s "$tmp/bench/contacts-samples.svg" -a -s "$tmp/bench/contacts-seconds.svg" \
    -a -s "$tmp/bench/contacts-stages.svg" -a -s "$tmp/bench/box-samples.svg" -a -s "$tmp/bench/report.html"
check "an unknown effect is refused" bash -c "! node tests/bench/accuracy.mjs '$build' effect=none 2>/dev/null"
check "an unknown scene is refused" bash -c "! node tests/bench/accuracy.mjs '$build' scene=nowhere 2>/dev/null"
check "factors of equal error, by power laws" node --input-type=module -e '
    import assert from "node:assert/strict";
    import { equalError, reach } from "./tests/bench/accuracy/factors.mjs";
    const near = (a, b) => assert.ok(Math.abs(a / b - 1) < 1e-9, `${a} is not ${b}`);
    const points = [4, 16, 64].map((n) => [n, n ** -0.5]);
    near(reach(points, 0.2).x, 25);
    assert.equal(reach(points, 0.2).outside, false);
    near(reach(points, 0.05).x, 400);
    assert.equal(reach(points, 0.05).outside, true);
    assert.equal(reach([[4, 1], [9, 1]], 0.5), null);
    const row = (method, spp, rmse) => ({ scene: "s", method, spp, judged: { rmse }, cpu_s: { judged: spp } });
    const rows = [...points.map(([n, e]) => row("average", n, e)), row("sheared", 4, 0.25)];
    const [f] = equalError(rows, "average");
    near(f.samples, 4);
    near(f.seconds, 4);'
tap_done
