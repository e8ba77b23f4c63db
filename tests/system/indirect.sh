#!/usr/bin/env bash
# Indirect light and ambient occlusion of light fields, alone and beside paths: the same light as
# paths bring, less noise where it is filtered, the same bytes however the frame is cut.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/indirect.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb

# The box under its lamp is light fields alone; with the sky it is paths beside them.
cat >"$tmp/alone.json" <<J
{"scene": {"file": "$scene"}, "image": {"width": 120, "height": 104},
 "sampling": {"spp": 9, "seed": 7},
 "effects": {"indirect_bounces": 5, "ambient_occlusion": {"distance": 0.4}},
 "layers": ["beauty", "direct", "indirect", "albedo", "emission", "samples", "diffuse_indirect",
            "occlusion", "filter_width"]}
J
jq '.environment = {radiance: [0.2, 0.3, 0.4]}' "$tmp/alone.json" >"$tmp/beside.json"
jq '.effects.indirect_bounces = 0' "$tmp/beside.json" >"$tmp/open.json"

figure() { "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$2.exr" --layer "$3" "${@:4}"; }
alike() { figure "$1" "$2" "$3" --box 8 | tee /dev/stderr | jq -e '.finite and ([.ratio[] | values | . > 0.985 and . < 1.015] | all)'; }

for job in alone beside open; do
    jq '.filter.method = "none" | .layers -= ["filter_width"] | .sampling.seed = 8' "$tmp/$job.json" >"$tmp/paths.json"
    # Errors are compared where light fields are alone, and those of the paths must be small beside them.
    check "$job: by paths" render paths "$job-paths" --spp $([ $job = alone ] && echo 512 || echo 256)
    check "$job: averaged" render "$job" "$job-average" --method average --spp 100
    check "... no filter runs" counts "$job-average" '.cpu_s.indirect == 0 and .indirect.pixels_filtered == 0'
    check "$job: filtered" render "$job" "$job-auto"
    check "... a filter runs" counts "$job-auto" '.cpu_s.indirect > 0 and .indirect.pixels_filtered > 1000 and .rays.indirect > 0'
    # The lamp's edge in beauty is of four samples where there are no paths.
    for layer in beauty direct indirect occlusion; do
        case $job-$layer in open-indirect | alone-beauty) continue ;; esac
        check "$job: $layer has the mean of paths, averaged" alike "$job-paths" "$job-average" "$layer"
        check "$job: $layer has the mean of paths, filtered" alike "$job-paths" "$job-auto" "$layer"
    done
done
check "light fields alone trace no path" counts alone-auto '.rays.paths == 0 and .rays.primary == 120 * 104'
check "beside them every path is traced, and more at edges" counts beside-auto '.rays.paths > 120 * 104 * 9 and .rays.paths < 120 * 104 * 9 * 1.5'
check "occlusion alone bounces once" counts open-auto '.rays.indirect <= .rays.paths and .rays.indirect_shadow == 0'

# 2.5 times less error, noise of the paths included: nine bounce rays stand for more than six times as
# many.
quieter() { # JOB LAYER
    local few=$(figure "$1-paths" "$1-auto" "$2" | jq .rmse) raw=$(figure "$1-paths" "$1-raw" "$2" | jq .rmse)
    echo "filtered $few, averaged $raw" && awk "BEGIN {exit !($few * 2.5 < $raw)}"
}
for job in alone beside; do
    check "$job: the average of nine" render "$job" "$job-raw" --indirect average
    check "... filters make it quieter" quieter "$job" diffuse_indirect
done

# Three passes, each filter; tiles, workers and threads do not show.
for filter in constant linear blend sheared; do
    check "$filter: one worker" render beside a --indirect $filter --spp 36 --workers 1 --worker-threads 1 --tile 32
    check "$filter: three workers, other tiles" render beside b --indirect $filter --spp 36 --workers 3 --tile 16
    check "... give the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"
done
check "auto: 64 bounce rays" render alone a --spp 64
check "... are fitted by lines" render alone b --spp 64 --indirect linear
same_light() { figure a b diffuse_indirect | jq -e '.finite and .rmse == 0'; }
check "... and nothing else" same_light # the files tell why a filter runs
check "alone, too" render alone a --workers 1 --tile 64
check "... with other tiles and workers" render alone b --workers 3 --tile 16
check "... the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"
refused() {
    "$build/shearwater" render "$tmp/alone.json" --indirect sharp -o "$tmp/x.exr" >"$tmp/log" 2>&1 && return 1
    grep -q '/filter/indirect' "$tmp/log" || { cat "$tmp/log"; return 1; }
}
check "a filter that there is not is refused by its place" refused
tap_done
