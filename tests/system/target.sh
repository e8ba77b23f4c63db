#!/usr/bin/env bash
# Errors that pictures know of themselves, against converged pictures; and sampling until a target
# error is reached: near it, the same bytes however the work is cut and whoever does it.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/target.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb

# The box below its lamp, whose edge would be most of all errors, seen from aside with a bent head:
# no edge runs along the pixels.
cat >"$tmp/box.json" <<J
{"scene": {"file": "$scene", "camera": {"eye": [0.4, 1.0, 2.6], "target": [0, 0.55, 0], "up": [0.15, 1, 0], "yfov_deg": 36}},
 "image": {"width": 96, "height": 96}, "sampling": {"spp": 16, "seed": 7},
 "effects": {"indirect_bounces": 3}, "layers": ["beauty", "error", "samples"]}
J
jq '.environment = {radiance: [0.2, 0.3, 0.4]}' "$tmp/box.json" >"$tmp/open.json"
truth() { # JOB: two of 192 paths, whose own error exr_calibration takes off
    local seed
    for seed in 901 902; do
        jq ".filter.method = \"none\" | .layers = [\"beauty\"] | .sampling = {spp: 192, seed: $seed}" "$tmp/$1.json" >"$tmp/truth.json"
        render truth "$1-$seed" || return 1
    done
}
known() { "$build/tests/bench/exr_calibration" "$tmp/$1-901.exr" "$tmp/$1-902.exr" "$tmp/$2.exr" | tee /dev/stderr; }
# Neighbours' paths make up for each other's gaps, which no pixel's samples can tell: filtered means err less.
calibrated() { known "$1" "$2" | jq -e '.within >= 0.85 and .within <= 0.995 and .estimate / .error > 0.7 and .estimate / .error < 1.6'; }
reached() { # JOB PICTURE TARGET
    known "$1" "$2" | jq -e ".error / $3 > 0.7 and .error / $3 < 1.3"
}

for job in box open; do
    check "$job: converged twice" truth $job
    for spp in 9 36; do
        check "$job: $spp samples" render $job few --spp $spp
        check "... know their error" calibrated $job few
    done
    jq '.filter.residual = "none"' "$tmp/$job.json" >"$tmp/plain.json"
    check "$job: 16 samples without the filter of paths" render plain few
    check "... know their error" calibrated $job few
    jq '.filter.method = "none"' "$tmp/$job.json" >"$tmp/paths.json"
    check "$job: 16 paths alone" render paths few
    check "... know their error" calibrated $job few
done
jq '.sampling.spp = 9 | .sampling.target_error = 0.02' "$tmp/open.json" >"$tmp/target.json"
check "sampling until a target" render target a --workers 1 --worker-threads 1 --tile 16
check "... reaches it" reached open a 0.02
check "... in rounds" counts a '.target.rounds > 1 and .target.error <= 0.02 and .target.error > 0.014'
check "... of more than the first" counts a '.target.paths + .target.bounces > 2 * 9 * 96 * 96'
check "... counts every sample" counts a '.target.paths <= .rays.paths and .rays.paths <= 2 * .target.paths'
check "... filters paths" counts a '.residual.pixels_filtered > 1000'
jq '.filter.residual = "none"' "$tmp/target.json" >"$tmp/unfiltered.json"
check "sampling until a target without that filter" render unfiltered plain
check "... reaches it" reached open plain 0.02
check "... by many more paths" jq -es '.[1].target.paths > 1.5 * .[0].target.paths' "$tmp/a.stats" "$tmp/plain.stats"
check "other workers" render target b --workers 3 --tile 16
check "... give the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"
check "blocks do not show: threads" render target b --workers 2 --worker-threads 2 --tile 16
check "... the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"
jq '.sampling.target_error = 0.004 | .sampling.max_spp = 64' "$tmp/target.json" >"$tmp/most.json"
check "a target out of reach ends" render most most
check "... with the most samples there may be" counts most '.target.paths == 64 * 96 * 96'
# Without a lamp, whose light fields would bring where there is no target.
jq '.sampling.target_error = 10 | .scene.lights = false' "$tmp/target.json" >"$tmp/met.json"
jq '.sampling.spp = 9 | .scene.lights = false' "$tmp/open.json" >"$tmp/plain.json"
check "a target that the first round meets" render met met --tile 16
check "... adds nothing" counts met '.target.rounds == 1 and .target.paths == 9 * 96 * 96'
check "... and changes nothing" render plain plain --tile 16
same() { "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$2.exr" --layer beauty | tee /dev/stderr | jq -e '.rmse == 0'; }
check "... the picture is that without a target" same met plain

# A box like varnish: glossy lobes keep a filter that is asked for, and it knows its error.
cat >"$tmp/varnish.json" <<'J'
{"Floor": {"pbrMetallicRoughness": {"baseColorFactor": [0.3, 0.25, 0.2, 1], "metallicFactor": 0, "roughnessFactor": 0.3},
           "extensions": {"KHR_materials_specular": {"specularFactor": 1}}}}
J
check "a glossy box" "$build/tests/golden/glb_edit" "$scene" "$tmp/varnish.json" "$tmp/glossy.glb"
jq --arg scene "$tmp/glossy.glb" '.scene.file = $scene | .filter.glossy = "virtual_hit"' "$tmp/box.json" >"$tmp/glossy.json"
check "glossy: converged twice" truth glossy
for spp in 9 16; do
    check "glossy: $spp samples" render glossy few --spp $spp
    check "... know their error" calibrated glossy few
    check "... are filtered" counts few '.glossy.pixels_filtered > 1000'
done
check "glossy: tiles of 64" render glossy a --spp 9 --tile 64
check "... and of 16, other workers" render glossy b --spp 9 --tile 16 --workers 2 --worker-threads 2
check "... know the same" cmp "$tmp/a.exr" "$tmp/b.exr"
jq '.sampling.spp = 9 | .sampling.target_error = 0.016' "$tmp/glossy.json" >"$tmp/shining.json"
check "glossy: sampling until a target" render shining a --workers 1 --worker-threads 1 --tile 16
check "... reaches it" reached glossy a 0.016
check "... in rounds" counts a '.target.rounds > 1 and .target.error <= 0.016'
check "... of filtered lobes" counts a '.glossy.pixels_filtered > 1000'
check "other workers and threads" render shining b --workers 3 --worker-threads 2 --tile 16
check "... give the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"

# Over the API: progress, warnings, workers that die.
serve_start "$tmp/data" --workers 2
"$build/shearwater" submit "$tmp/most.json" --server "$url" --quiet >"$tmp/id"
await_state "$(cat "$tmp/id")" finished 120
check "a warning says what was reached" bash -c "curl -sS --noproxy '*' '$url/v1/jobs/$(cat "$tmp/id")' | tee /dev/stderr | jq -e '.warnings | any(test(\"sampling ended at an estimated error of .* above the target of 0.004\"))'"
check "progress counts later rounds" bash -c "curl -sS --noproxy '*' '$url/v1/jobs/$(cat "$tmp/id")' | jq -e '.progress.tiles_done == .progress.tiles_total and .progress.fraction == 1 and .progress.tiles_total > 8'"
serve_stop
tap_done
