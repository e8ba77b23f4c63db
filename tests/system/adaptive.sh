#!/usr/bin/env bash
# Adaptive sampling of indirect light: rays where they are asked for, the error falls as mu grows, and
# the same bytes however the work is cut, whoever does it, and whoever dies over it.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/adaptive.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb

# The box under its lamp is light fields alone; with the sky it is paths beside them. Of a glossy floor
# lobes get second sets, too.
cat >"$tmp/alone.json" <<J
{"scene": {"file": "$scene"}, "image": {"width": 104, "height": 96},
 "sampling": {"spp": 9, "seed": 7}, "effects": {"indirect_bounces": 2, "ambient_occlusion": {"distance": 0.4}},
 "filter": {"indirect": "adaptive"},
 "layers": ["beauty", "diffuse_indirect", "occlusion", "samples", "filter_width", "depth"]}
J
jq '.environment = {radiance: [0.2, 0.3, 0.4]} | .sampling.spp = 36' "$tmp/alone.json" >"$tmp/beside.json"
jq '.effects.indirect_bounces = 0' "$tmp/beside.json" >"$tmp/open.json"
node tests/bench/scene_files.mjs glossy_floor 16 "$tmp" || exit 1
jq --arg file "$tmp/glossy_floor.glb" '.scene = {file: $file, lights: false, camera: .scene.camera} |
    .image = {width: 104, height: 96} | .sampling = {spp: 9, seed: 7} | .effects.indirect_bounces = 2 |
    .filter = {indirect: "adaptive"} | .layers = ["beauty", "indirect", "diffuse_indirect", "samples", "id"]' \
    "$tmp/glossy_floor.json" >"$tmp/glossy.json"
jq '.filter.glossy = "bandlimit"' "$tmp/glossy.json" >"$tmp/bandlimit.json"
jq '.filter.glossy = "average"' "$tmp/glossy.json" >"$tmp/unfiltered.json"

for job in alone beside open glossy bandlimit unfiltered; do
    check "$job: one worker" render $job $job --workers 1 --worker-threads 1 --tile 64
    check "... asks for a second set" counts $job '.adaptive.first_rays > 16 * 8000 and .adaptive.second_rays > 0'
    check "$job: three workers, other tiles" render $job b --workers 3 --tile 16
    check "... the same bytes" cmp "$tmp/$job.exr" "$tmp/b.exr"
    case $job in alone | glossy) ;; *) continue ;; esac
    check "$job: threads" render $job b --workers 1 --worker-threads 2 --tile 40
    check "... the same bytes" cmp "$tmp/$job.exr" "$tmp/b.exr"
    check "... and the same rays" test "$(jq -c '.adaptive' "$tmp/$job.stats")" = "$(jq -c '.adaptive' "$tmp/b.stats")"
done
check "no ray is traced that was not asked for" counts alone '.rays.indirect <= 2 * (.adaptive.first_rays + .adaptive.second_rays)'
check "some pixels have enough" counts beside '.skipped.enough_rays > 0'

# Lobes' rays are counted: all pixels together have but one first set of bounce rays each.
check "lobes have a first set" test "$(jq .adaptive.first_rays "$tmp/glossy.stats")" -gt "$((16 * 104 * 96))"
check "they get what their filter does not matter to" \
    test "$(jq -c .adaptive "$tmp/glossy.stats")" = "$(jq -c .adaptive "$tmp/unfiltered.stats")"

# The layer shows what each pixel has got: its mean is what the statistics count.
sixteen() {
    jq '.sampling.indirect_spp = 16' "$tmp/alone.json" >"$tmp/sixteen.json"
    render sixteen sixteen && counts sixteen '.adaptive.second_rays == 0'
}
check "a cap of sixteen leaves the first set" sixteen
more() {
    local second=$(jq .adaptive.second_rays "$tmp/alone.stats")
    compared sixteen alone samples |
        jq -e "(.bias * .width * .height - $second | fabs) < 2 and .max <= 84 and (.max | sqrt | . == floor)"
}
check "the layer samples has the second set on top of it" more

# 1024 rays, averaged, are the truth: errors fall as mu grows.
jq '.filter = {indirect: "average"} | .sampling.indirect_spp = 1024 | .sampling.seed = 91' "$tmp/alone.json" >"$tmp/truth.json"
check "the truth" render truth truth
falls() {
    local mu error before=1e9
    for mu in 0.5 1 4; do
        jq ".filter.mu = $mu" "$tmp/alone.json" >"$tmp/mu.json"
        render mu mu || return 1
        error=$(compared truth mu diffuse_indirect | jq .rmse)
        echo "mu $mu: $(jq -c .adaptive "$tmp/mu.stats"), error $error"
        awk "BEGIN {exit !($error < $before)}" || return 1
        before=$error
    done
}
check "the error falls from mu 0.5 to 4" falls
bright() { compared truth alone diffuse_indirect --box 8 | jq -e '.finite and ([.ratio[] | values | . > 0.985 and . < 1.015] | all)'; }
check "the light is that of the truth" bright

jq '.filter = {indirect: "average", glossy: "average"} | .sampling.indirect_spp = 576' \
    "$tmp/glossy.json" >"$tmp/glossy_truth.json"
# The same seed puts sub-samples at the same places, whose silhouettes would hide all else.
check "the truth of the glossy floor" render glossy_truth glossy_truth
falls_on_the_floor() {
    local mu error before=1e9
    for mu in 0.25 1 3; do
        jq ".filter.mu = $mu" "$tmp/glossy.json" >"$tmp/mu.json"
        render mu mu || return 1
        error=$(compared glossy_truth mu indirect --where id,0.5,1.5 | jq .rmse)
        echo "mu $mu: $(jq -c .adaptive "$tmp/mu.stats"), error $error"
        awk "BEGIN {exit !($error < 0.9 * $before)}" || return 1
        before=$error
    done
}
check "... whose error falls" falls_on_the_floor

for size in "1 1" "2 3" "1 37"; do
    read -r width height <<<"$size"
    jq ".image = {width: $width, height: $height}" "$tmp/beside.json" >"$tmp/small.json"
    check "a frame of $width x $height" render small small
done
refused() { # FILTER SENTENCE
    jq "$1" "$tmp/alone.json" >"$tmp/no.json"
    ! render no no 2>"$tmp/refused" || return 1
    cat "$tmp/refused"
    grep -q "$2" "$tmp/refused"
}
check "it tells of no errors: the layer" refused '.layers += ["error"]' '/filter/indirect.*does not know its error'
check "... and the target" refused '.sampling.target_error = 0.1' '/filter/indirect.*does not know its error'

# Workers that die in the middle of a second set.
jq '.image = {width: 256, height: 256} | .filter.mu = 1.5 | .sampling.tile_px = 16' "$tmp/glossy.json" >"$tmp/large.json"
check "a frame of many rays" render large large
serve_start "$tmp/data" --workers 0
check "a worker that dies over a second set changes no byte" survives_second_set
serve_stop
tap_done
