#!/usr/bin/env bash
# Tiles that were finished before the coordinator was killed are not traced again after it: they are
# taken from disk, whatever the frame does with them, and not a byte of its file is another. What is
# torn, damaged or of another frame is traced again.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/resume.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
spool_files() { find "$tmp/data/spool" -type f; }
spool_is_empty() { [ -z "$(find "$tmp/data/spool" -mindepth 1)" ]; }

# Kills it when that many tiles have landed, and starts it again.
crash_at() { # crash_at JOB TILES
    eventually 60 has_landed "$1" "$2" || return 1
    serve_stop -KILL
    return 0 # not what the killed one ends with
}

plain='"image": {"width": 256, "height": 256}, "sampling": {"spp": 24, "tile_px": 32}, "filter": {"method": "none"}'
names=(plain filtered rates target lens)
jobs=("$plain"
    '"image": {"width": 256, "height": 256}, "sampling": {"spp": 25, "tile_px": 32}, "effects": {"indirect_bounces": 2}'
    '"image": {"width": 224, "height": 224}, "sampling": {"spp": 16, "tile_px": 32}, "effects": {"indirect_bounces": 2}, "filter": {"indirect": "adaptive"}'
    '"image": {"width": 224, "height": 224}, "sampling": {"spp": 16, "tile_px": 32, "target_error": 0.06, "max_spp": 256}, "filter": {"method": "none"}'
    '"image": {"width": 224, "height": 224}, "sampling": {"spp": 16, "tile_px": 32, "lens_extra": 8}, "lens": {"aperture_radius": 0.1, "focus_distance": 6}, "effects": {"indirect_bounces": 2}')

start
for i in "${!jobs[@]}"; do
    id=$(submit "${jobs[$i]}") || { cat "$tmp/job.json"; }
    check "${names[$i]}: the undisturbed job finishes" await_state "$id" finished 120
    exr "$id" "$tmp/${names[$i]}.exr"
    tiles[$i]=$(number "$id" .progress.tiles_total)
done
check "nothing is left of finished jobs" eventually 5 spool_is_empty

# Killed twice, at a third of the tiles and at two thirds, which is in the second round of those that have one.
for i in "${!jobs[@]}"; do
    n=${names[$i]} all=${tiles[$i]}
    id=$(submit "${jobs[$i]}")
    check "$n: killed at a third" crash_at "$id" $((all / 3))
    start
    check "$n: takes these up" eventually 30 shows "$id" ".statistics.tiles.resumed >= $((all / 4))"
    check "$n: killed at two thirds" crash_at "$id" $((all * 2 / 3))
    start
    check "$n: finishes" await_state "$id" finished 120
    resumed=$(number "$id" .statistics.tiles.resumed)
    echo "# $n: $resumed of $all tiles taken from disk the second time"
    # What had not been written when it was killed is: on a busy disk that may be as much as came since.
    check "$n: what had landed long before is not traced again" [ "$resumed" -ge $((all / 3)) ]
    check "$n: all tiles are counted once" is "$(number "$id" .statistics.tiles.done)" "$all"
    exr "$id" "$tmp/again.exr"
    check "$n: the same bytes" cmp "$tmp/$n.exr" "$tmp/again.exr"
    check "$n: its spool has gone" eventually 5 spool_is_empty
done
# A spool that is not what it was. The job is held when it is half done; what landed lies in one file.
half_done() { # half_done SIGNAL: a job of the plain kind that was killed half-way; sets $id, $landed, $spool
    id=$(submit "$plain")
    pause_at "$id" 48
    eventually 10 workers_empty
    settled du -sb "$tmp/data/spool" # what has landed is written soon
    landed=$(number "$id" .progress.tiles_done)
    serve_stop "$1"
    spool=$(spool_files)
}
goes_on() { # goes_on NAME LEAST MOST [ARGS]: as many are taken up, and the file is the undisturbed one
    start "${@:4}"
    "$build/shearwater" steer "$id" --server "$url" --resume >/dev/null
    check "$1: it finishes" await_state "$id" finished 120
    resumed=$(number "$id" .statistics.tiles.resumed)
    check "$1: $resumed of $landed taken up, $2 to $3 expected" [ "$resumed" -ge "$2" -a "$resumed" -le "$3" ]
}
same_bytes() { exr "$id" "$tmp/again.exr" && cmp "$tmp/plain.exr" "$tmp/again.exr"; }
flip() { # flip FILE OFFSET
    local byte; byte=$(od -An -tu1 -j "$2" -N1 "$1" | tr -d ' ')
    printf "\\x$(printf %02x $((byte ^ 64)))" | dd of="$1" bs=1 seek="$2" conv=notrunc status=none
}

half_done -TERM
goes_on "stopped in order" "$landed" "$landed"
check "... the same bytes" same_bytes

half_done -KILL
truncate -s $(($(stat -c %s "$spool") - 100)) "$spool"
goes_on "a torn tail" $((landed - 1)) $((landed - 1))
check "... the same bytes" same_bytes

half_done -KILL
flip "$spool" $((44 + 40 + 1000))
goes_on "a bit of a payload" $((landed - 16)) $((landed - 1))
check "... the same bytes" same_bytes

half_done -KILL
flip "$spool" $((44 + 4))
goes_on "a bit of the first record's length" 0 0
check "... the same bytes" same_bytes

half_done -KILL
head -c 100000 /dev/urandom >"$spool"
goes_on "no spool at all" 0 0
check "... the same bytes" same_bytes

half_done -KILL
goes_on_smaller() { SHEARWATER_ISA=sse4.2 goes_on "another instruction set" 0 0; }
goes_on_smaller
serve_stop
start

half_done -KILL
mkdir -p "$tmp/data/spool/01aaaaaaaaaaaaaaaaaaaaaaaa"
echo debris >"$tmp/data/spool/01aaaaaaaaaaaaaaaaaaaaaaaa/1"
start
check "spools of no job are swept at start" [ "$(spool_files)" = "$spool" ]
check "the metric counts none taken up" is "$(http "$url/metrics" | sed -n 's/^shearwater_tiles_resumed_total //p')" 0
http -X DELETE "$url/v1/jobs/$id" >/dev/null
check "a cancelled job leaves none" eventually 5 spool_is_empty

live=$(submit "${plain/\"filter\"/\"live\": true, \"filter\"}")
eventually 30 shows "$live" '.progress.fraction > 0.2'
check "a live job keeps none" spool_is_empty
tap_done
