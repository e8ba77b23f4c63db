#!/usr/bin/env bash
# Second sets of paths through the lens: as many as asked for, where they help, and the same bytes
# however the work is cut, whoever does it, and whoever dies over it.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/lens_extra.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb

cat >"$tmp/first.json" <<J
{"scene": {"file": "$scene"}, "image": {"width": 104, "height": 96},
 "sampling": {"spp": 9, "seed": 7}, "effects": {"indirect_bounces": 1},
 "lens": {"aperture_radius": 0.1, "focus_distance": 3},
 "layers": ["beauty", "samples", "filter_width", "depth"]}
J
jq '.sampling.lens_extra = 9' "$tmp/first.json" >"$tmp/extra.json"

check "one worker" render extra extra --workers 1 --worker-threads 1 --tile 64
pixels=$((104 * 96))
check "a quarter of the pixels has a second set" counts extra ".lens.second_paths == $((pixels / 4 * 36))"
check "... which is traced" counts extra '.rays.paths == .lens.second_paths'
check "three workers, other tiles" render extra b --workers 3 --tile 16
check "... the same bytes" cmp "$tmp/extra.exr" "$tmp/b.exr"
check "threads" render extra b --workers 1 --worker-threads 2 --tile 40
check "... the same bytes" cmp "$tmp/extra.exr" "$tmp/b.exr"
check "the first set alone" render first first
check "... has no other" counts first '.lens.second_paths == 0 and .rays.paths == 0'
more() { compared first extra samples | jq -e "(.bias * $pixels - 9 * $pixels | fabs) < 2 and .max == 36"; }
check "the layer samples has the second set on top of it" more

# 512 paths are the truth; the lamp's edge is most of its absolute error, and stays.
jq '.filter = {method: "none"} | .sampling.spp = 512 | .sampling.seed = 91' "$tmp/first.json" >"$tmp/truth.json"
jq '.layers = ["beauty"]' "$tmp/truth.json" >"$tmp/t.json" && mv "$tmp/t.json" "$tmp/truth.json"
check "the truth" render truth truth
falls() {
    local a b
    a=$(compared truth first beauty | jq .relmse)
    b=$(compared truth extra beauty | jq .relmse)
    awk "BEGIN {exit !($b < 0.99 * $a)}"
}
check "the error falls" falls
bright() { compared truth extra beauty --box 8 | jq -e '.finite and ([.ratio[] | values | . > 0.98 and . < 1.02] | all)'; }
check "the light is that of the truth" bright

for size in "1 1" "2 3" "1 37"; do
    read -r width height <<<"$size"
    jq ".image = {width: $width, height: $height}" "$tmp/extra.json" >"$tmp/small.json"
    check "a frame of $width x $height" render small small
done

# Workers that die in the middle of a second set.
jq '.image = {width: 256, height: 256} | .sampling.tile_px = 16 | .sampling.lens_extra = 36' "$tmp/extra.json" >"$tmp/large.json"
check "a frame of many paths" render large large
serve_start "$tmp/data" --workers 0
check "a worker that dies over a second set changes no byte" survives_second_set
serve_stop
tap_done
