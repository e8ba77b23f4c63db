#!/usr/bin/env bash
# Light fields at half resolution: fewer rays for about the picture that all of them make, which
# converges to the same light, and the same bytes however the work is cut, whoever does it, and whatever
# layers are asked for.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/half_field.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb

# The box is light fields alone; the glossy floor has lobes, beside paths.
cat >"$tmp/box.json" <<J
{"scene": {"file": "$scene"}, "image": {"width": 106, "height": 97},
 "sampling": {"spp": 4, "indirect_spp": 36, "field_scale": 0.5, "seed": 7}, "effects": {"indirect_bounces": 2},
 "layers": ["beauty", "diffuse_indirect", "samples", "albedo"]}
J
node tests/bench/scene_files.mjs glossy_floor 16 "$tmp" || exit 1
jq --arg file "$tmp/glossy_floor.glb" '.scene = {file: $file, lights: false, camera: .scene.camera} |
    .image = {width: 106, height: 97} | .sampling = {spp: 1, indirect_spp: 36, field_scale: 0.5, seed: 7} |
    .effects.indirect_bounces = 2 | .filter = {indirect: "constant", glossy: "virtual_hit"} |
    .layers = ["beauty", "indirect", "diffuse_indirect", "samples", "id"]' "$tmp/glossy_floor.json" >"$tmp/floor.json"

for job in box floor; do
    check "$job: one worker" render $job $job --workers 1 --worker-threads 1 --tile 64
    check "... leaves out more than half of the rays" counts $job '.skipped.half_field > .rays.indirect / 2'
    check "... and traces some anew" counts $job '.rays.anew > 0 and .rays.anew < .skipped.half_field'
    check "$job: three workers, other tiles" render $job b --workers 3 --tile 16
    check "... the same bytes" cmp "$tmp/$job.exr" "$tmp/b.exr"
    check "$job: threads, tiles that cut squares of four" render $job b --workers 1 --worker-threads 2 --tile 42
    check "... the same bytes" cmp "$tmp/$job.exr" "$tmp/b.exr"
    jq '.layers = ["beauty"]' "$tmp/$job.json" >"$tmp/bare.json"
    jq '.layers += ["error", "filter_width", "depth", "normal"]' \
        "$tmp/$job.json" >"$tmp/looked.json"
    check "$job: without layers" render bare bare
    check "... and with more of them" render looked looked
    for other in bare looked; do
        check "... $other, the same picture" eval "figure $job $other | jq -e .rmse==0"
    done
done

# A pixel of four has rays in the layer; light samples are in all.
few() { compared box box samples | jq -e '.mean_test | map(values) | .[0] > 4 + 36 / 4 and .[0] < 4 + 36 / 2'; }
check "the layer samples has the rays that there are" few

# 1024 rays, averaged, are the truth: the error falls as rays grow, and the light is right.
jq '.filter = {indirect: "average"} | .sampling = {spp: 4, indirect_spp: 1024, seed: 91}' "$tmp/box.json" >"$tmp/truth.json"
check "the truth" render truth truth
falls() {
    local rays error before=1e9
    for rays in 4 36 324; do
        jq ".sampling.indirect_spp = $rays" "$tmp/box.json" >"$tmp/rays.json"
        render rays rays || return 1
        error=$(compared truth rays diffuse_indirect | jq .rmse)
        echo "$rays rays: $(jq -c .rays.indirect "$tmp/rays.stats") bounce rays, error $error"
        awk "BEGIN {exit !($error < 0.7 * $before)}" || return 1
        before=$error
    done
}
check "the error falls as rays grow" falls
bright() { compared truth box diffuse_indirect --box 8 | jq -e '.finite and ([.ratio[] | values | . > 0.98 and . < 1.02] | all)'; }
check "the light is that of the truth" bright

for size in "1 1" "2 3" "1 37" "5 4"; do
    read -r width height <<<"$size"
    jq ".image = {width: $width, height: $height}" "$tmp/floor.json" >"$tmp/small.json"
    check "a frame of $width x $height" render small small
done
tap_done
