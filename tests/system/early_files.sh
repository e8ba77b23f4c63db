#!/usr/bin/env bash
# Files of a picture are written while it forms: rows of the EXR are on disk before the last tile, a job that is
# cancelled or whose coordinator is killed leaves nothing of them, and the bytes are those of another cut.
#   tests/system/early_files.sh BUILD_DIR
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/early_files.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
job() { # job SEED SPP
    jq -n --arg scene "$PWD/tests/scenes/cornell-box/cornell-box.glb" --argjson seed "$1" --argjson spp "$2" \
        '{scene: {file: $scene}, image: {width: 512, height: 768}, sampling: {spp: $spp, seed: $seed}, effects: {indirect_bounces: 1}}'
}
submit() { job "$1" "$2" >"$tmp/job.json" && id=$("$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet); }
files() { find "$tmp/data/tmp" -type f | wc -l; }
# Rows are on disk while tiles are still out; the job's own word for that they are.
early() {
    local i
    for i in $(seq 3000); do
        if [ "$(find "$tmp/data/tmp" -name 'image.exr.tmp-*' -size +256k | wc -l)" -gt 0 ]; then
            curl -sS --noproxy '*' "$url/v1/jobs/$id" | jq -e '.state == "running" and .progress.tiles_done < .progress.tiles_total' && return 0
            return 1
        fi
        sleep 0.02
    done
    return 1
}
no_files() { [ "$(files)" -eq 0 ] || { find "$tmp/data/tmp"; return 1; }; }
gone() { eventually 30 no_files; }

serve_start "$tmp/data" --workers 1 --worker-threads 1
submit 1 16
check "rows of the EXR are on disk while tiles are traced" early
check "the job ends" await_state "$id" finished 300
check "nothing is left beside its files" gone
fetch() { curl -sSf --noproxy '*' -o "$2" "$url/v1/jobs/$id/frames/1/image.$1"; }
check "it has its files" bash -c "$(declare -f fetch); url=$url id=$id; fetch exr '$tmp/a.exr' && fetch png '$tmp/a.png'"
check "little is left of the frame's time after the last tile" bash -c "
    curl -sS --noproxy '*' '$url/v1/jobs/$id' | jq -e '.statistics.frames | .stored_late_s < 0.5 * .wall_s and .drawn_late_s > 0'"
submit 2 16
check "... of another job, too" early
check "it is cancelled" "$build/shearwater" cancel "$id" --server "$url"
check "nothing is left of it" gone
submit 3 16
check "... and of a third" early
serve_stop -KILL
check "what a killed coordinator leaves" bash -c "[ $(files) -gt 0 ]"
serve_start "$tmp/data" --workers 1 --worker-threads 1
check "the next one clears away, and ends the job" await_state "$id" finished 300
check "nothing is left beside its files either" gone
serve_stop

# Blocks as they are never cut by themselves: rows end elsewhere, and the files are the same.
job 1 16 >"$tmp/job.json"
check "the same picture in blocks of 32 and tiles of 32" env SHEARWATER_BLOCK_PX=32 "$build/shearwater" render "$tmp/job.json" --quiet --workers 2 --tile 32 -o "$tmp/b.exr" --png "$tmp/b.png"
check "... the same EXR" cmp "$tmp/a.exr" "$tmp/b.exr"
check "... the same PNG" cmp "$tmp/a.png" "$tmp/b.png"
tap_done
