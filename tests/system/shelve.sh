#!/usr/bin/env bash
# A paused job whose memory others need goes back to its spool: what has landed is read again when it
# goes on, over kills, too, and its numbers are those of the undisturbed job: nothing counts twice.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/shelve.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
steer() { "$build/shearwater" steer "$1" --server "$url" "${@:2}" >/dev/null; }
# What does not depend on who traced when: rays, what was skipped, what the filters met.
counts() { get "$1" | jq -cS '.statistics | [.rays, .skipped, .pixels, .shadow, .indirect, .glossy, .lens, .target, .adaptive, .tiles.done]'; }
metric_rays() { http "$url/metrics" | sed -n 's/^shearwater_rays_total{.*} //p' | awk '{ sum += $1 } END { if (NR) printf "%.0f\n", sum }'; }
rays() { number "$1" '[.statistics.rays[]] | add'; }

names=(paths filtered rates target lens)
jobs=('"image": {"width": 256, "height": 256}, "sampling": {"spp": 25, "tile_px": 32}, "filter": {"method": "none"}'
    '"image": {"width": 256, "height": 256}, "sampling": {"spp": 25, "tile_px": 32}, "effects": {"indirect_bounces": 2}'
    '"image": {"width": 224, "height": 224}, "sampling": {"spp": 16, "tile_px": 32}, "effects": {"indirect_bounces": 2}, "filter": {"indirect": "adaptive"}'
    '"image": {"width": 224, "height": 224}, "sampling": {"spp": 16, "tile_px": 32, "target_error": 0.06, "max_spp": 256}, "filter": {"method": "none"}'
    '"image": {"width": 256, "height": 256}, "sampling": {"spp": 16, "tile_px": 32, "lens_extra": 4}, "lens": {"aperture_radius": 0.1, "focus_distance": 6}, "effects": {"indirect_bounces": 2}')
start
for i in "${!jobs[@]}"; do
    id=$(submit "${jobs[$i]}")
    check "${names[$i]}: the undisturbed job finishes" await_state "$id" finished 120
    exr "$id" "$tmp/${names[$i]}.exr"
    undisturbed[$i]=$(counts "$id")
    tiles[$i]=$(number "$id" .progress.tiles_total)
done

# Twelve paused jobs take what room there is for such.
fill() {
    local one i
    for i in 1 2 3 4 5 6 7 8 9 10 11 12; do
        one=$(submit '"image": {"width": 128, "height": 128}, "sampling": {"spp": 1024, "tile_px": 16}, "filter": {"method": "none"}, "priority": 20')
        pause_at "$one" 1 || return 1
    done
    eventually 20 shows "$one" '.paused and .progress.tiles_done > 0' && eventually 20 workers_empty
}
check "twelve jobs are paused" fill

# shelve JOB TILES: pauses it when so many have landed, whereupon it is dropped.
shelve() {
    pause_at "$1" "$2" && eventually 10 shows "$1" '.paused and .progress.tiles_done == 0'
}
finishes_as() { # finishes_as NAME JOB INDEX: the bytes and the counts of the undisturbed one
    check "$1: it finishes" await_state "$2" finished 120
    check "$1: every number is the undisturbed job's" is "$(counts "$2")" "${undisturbed[$3]}"
    exr "$2" "$tmp/again.exr"
    check "$1: ... and every byte" cmp "$tmp/${names[$3]}.exr" "$tmp/again.exr"
}
for i in "${!jobs[@]}"; do
    n=${names[$i]} all=${tiles[$i]} before=$(metric_rays)
    id=$(submit "${jobs[$i]}, \"priority\": 10")
    check "$n: one that is paused now goes back to its spool" shelve "$id" $((all / 3))
    check "$n: ... what it did is told all the same" shows "$id" ".statistics.tiles.done >= $((all / 3)) and .statistics.tiles.resumed == 0"
    steer "$id" --resume
    check "$n: ... and once more, later on" shelve "$id" $((all / 2))
    steer "$id" --resume
    finishes_as "$n" "$id" "$i"
    check "$n: tiles were read from disk" shows "$id" ".statistics.tiles.resumed >= $((all / 3))"
    check "$n: the metric counts its rays once" is "$(($(metric_rays) - before))" "$(rays "$id")"
done

# Cancelled there: what it cost is told.
id=$(submit "${jobs[0]}, \"priority\": 10")
check "cancelled on the shelf: it lies there" shelve "$id" $((tiles[0] / 4))
landed=$(number "$id" .statistics.tiles.done)
http -X DELETE "$url/v1/jobs/$id" >/dev/null
check "cancelled on the shelf: it is" await_state "$id" cancelled 20
check "cancelled on the shelf: what it did is told" shows "$id" ".statistics.tiles.done == $landed and .statistics.tiles.done >= $((tiles[0] / 4))"

# A kill while it lies there, and one while it is read again.
id=$(submit "${jobs[0]}, \"priority\": 10")
check "killed on the shelf: it lies there" shelve "$id" $((tiles[0] / 3))
settled du -sb "$tmp/data/spool" # what has landed is written soon
serve_stop -KILL
start
check "killed on the shelf: it is still paused" shows "$id" '.paused and .progress.tiles_done == 0'
steer "$id" --resume
finishes_as "killed on the shelf" "$id" 0
check "killed on the shelf: tiles were read from disk" shows "$id" ".statistics.tiles.resumed >= $((tiles[0] / 4))"
check "killed on the shelf: the metric has no rays of before" [ "$(metric_rays)" -lt "$(($(rays "$id") * 9 / 10))" ]

id=$(submit "${jobs[0]}, \"priority\": 30")
pause_at "$id" $((tiles[0] / 2)) && eventually 10 workers_empty
steer "$id" --resume
serve_stop -KILL
start
eventually 60 shows "$id" ".statistics.tiles.resumed > 20"
serve_stop -KILL
start
finishes_as "killed again while it is read" "$id" 0

tap_done
