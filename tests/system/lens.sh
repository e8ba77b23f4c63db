#!/usr/bin/env bash
# The light field of the lens: the same picture as paths through it, less noise where it is filtered,
# the same bytes however the frame is cut; a lens without an aperture is none.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/lens.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb

# Focused on the middle of the box, whose front and back are far out of focus.
cat >"$tmp/box.json" <<J
{"scene": {"file": "$scene"}, "image": {"width": 120, "height": 104},
 "sampling": {"spp": 9, "seed": 7}, "effects": {"indirect_bounces": 2},
 "lens": {"aperture_radius": 0.12, "focus_distance": 3.4, "blades": 6, "blade_rotation_deg": 10},
 "layers": ["beauty", "samples", "depth", "normal", "id", "filter_width"]}
J
jq '.lens.blades = 0' "$tmp/box.json" >"$tmp/round.json"
jq 'del(.lens)' "$tmp/box.json" >"$tmp/pinhole.json"
jq '.lens = {aperture_radius: 0, focus_distance: 3}' "$tmp/box.json" >"$tmp/closed.json"

alike() { figure "$1" "$2" --box 8 | tee /dev/stderr | jq -e '.finite and ([.ratio[] | values | . > 0.985 and . < 1.015] | all)'; }

# A pinhole pays nothing: neither samples nor bytes.
# (One worker: a busy machine makes a second one trace copies of late tiles, and they count.)
check "a closed lens" render closed closed --workers 1
check "... no lens" render pinhole pinhole --workers 1
check "... the same bytes" cmp "$tmp/closed.exr" "$tmp/pinhole.exr"
check "... and the same work" bash -c "
    diff <(jq -S '.rays, .skipped, .bytes_received' '$tmp/closed.stats') <(jq -S '.rays, .skipped, .bytes_received' '$tmp/pinhole.stats')"
check "... of which none is the lens's" counts closed '.rays.lens == 0 and .lens.pixels_filtered == 0 and .cpu_s.lens == 0'

for job in box round; do
    jq '.filter.method = "none" | .layers -= ["filter_width"] | .sampling.seed = 8' "$tmp/$job.json" >"$tmp/paths.json"
    check "$job: by paths" render paths "$job-paths" --spp 256
    check "$job: averaged" render "$job" "$job-average" --lens average --spp 100
    check "... every sample is a path of the lens" counts "$job-average" '
        .rays.lens == 120 * 104 * 100 and .rays.paths == 0 and .lens.pixels_filtered == 0 and .cpu_s.lens == 0'
    check "... the picture is that of paths" alike "$job-paths" "$job-average"
done

# Each filter; tiles, workers and threads do not show.
for filter in average axis_aligned sheared; do
    check "$filter: one worker" render box a --lens $filter --workers 1 --worker-threads 1 --tile 32
    check "$filter: three workers, other tiles" render box b --lens $filter --workers 3 --tile 16
    check "... give the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"
done

# Less error than the average of the same samples, and the same light.
quieter() { # FILTER FACTOR
    local few raw
    few=$(figure box-paths "$1" | jq .rmse) raw=$(figure box-paths average | jq .rmse)
    echo "filtered $few, averaged $raw" && awk "BEGIN {exit !($few * $2 < $raw)}"
}
check "average: nine samples" render box average --lens average
for filter in axis_aligned sheared; do
    check "$filter: nine samples" render box $filter --lens $filter
    check "... a filter runs" counts $filter '.cpu_s.lens > 0 and .lens.pixels_filtered > 1000 and .rays.lens == 120 * 104 * 9'
    check "... the light stays" alike box-paths $filter
done
check "the sheared filter is quieter than the average" quieter sheared 1.5
check "the axis-aligned one, too" quieter axis_aligned 1.05
check "auto is the sheared filter" render box auto
check "... and nothing else" bash -c "
    '$build/shearwater' compare '$tmp/auto.exr' '$tmp/sheared.exr' | jq -e '.finite and .rmse == 0'"

# What cannot be is refused, with its place; what can is a picture.
refused() { # LENS WORDS
    jq --argjson lens "$1" '.lens = $lens' "$tmp/box.json" >"$tmp/bad.json"
    "$build/shearwater" render "$tmp/bad.json" -o "$tmp/x.exr" >"$tmp/log" 2>&1 && return 1
    grep -q -- "$2" "$tmp/log" || { cat "$tmp/log"; return 1; }
}
check "focus at 0 is refused" refused '{"aperture_radius": 0.1, "focus_distance": 0}' '0 is not above 0'
check "focus behind the camera is refused" refused '{"aperture_radius": 0.1, "focus_distance": -2}' '/lens/focus_distance'
check "focus at infinity is refused" refused '{"aperture_radius": 0.1, "focus_distance": 1e300}' '/lens/focus_distance'
check "no focus is refused" refused '{"aperture_radius": 0.1}' 'has to be focused'
finite() { # LENS
    jq --argjson lens "$1" '.lens = $lens' "$tmp/box.json" >"$tmp/odd.json"
    render odd odd && figure odd odd | jq -e '.finite'
}
check "focus behind everything is a picture" finite '{"aperture_radius": 0.1, "focus_distance": 1e15}'
check "an aperture larger than the scene is a picture" finite '{"aperture_radius": 1000, "focus_distance": 3}'
check "focus on the lens itself is a picture" finite '{"aperture_radius": 0.1, "focus_distance": 1e-30}'
tap_done
