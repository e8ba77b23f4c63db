#!/usr/bin/env bash
# Workers that are slow or hang do not hold a frame up: what they are late with is given to others,
# too. On real workers, and on simulated farms.
#   tests/system/schedule.sh BUILD_DIR
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/schedule.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash

for farm in one_slow even uneven uneven_hanging; do
    check "simulated farm $farm: near the ideal schedule" "$build/tests/load/simulate_farm" runs=4 farm=$farm
done
check "an unknown word is refused" bash -c "! '$build/tests/load/simulate_farm' walk=5"

jq -n --arg scene "$PWD/tests/scenes/cornell-box/cornell-box.glb" \
    '{scene: {file: $scene}, image: {width: 256, height: 256}, sampling: {spp: 24, seed: 3},
      filter: {method: "none"}, effects: {indirect_bounces: 4}}' >"$tmp/job.json"
check "the undisturbed frame" "$build/shearwater" render "$tmp/job.json" --quiet --workers 1 -o "$tmp/alone.exr"

data=$tmp/data
check "a coordinator starts" serve_start "$data" --workers 0
# worker NAME: one thread, in the background; its process in $NAME.
worker() {
    "$build/shearwater-worker" --connect "unix:$data/worker.sock" --threads 1 --cache "$data/cache" >>"$tmp/$1.log" 2>&1 &
    printf -v "$1" %s $!
    track $!
}
copied() { curl -sS --noproxy '*' "$url/v1/jobs/$1" | jq .statistics.tiles.copied; }
same_bytes() { curl -sSf --noproxy '*' -o "$tmp/got.exr" "$url/v1/jobs/$1/frames/1/image.exr" && cmp "$tmp/alone.exr" "$tmp/got.exr"; }

holds_tiles() { http "$url/v1/workers" | jq -e 'any(.workers[]; .tiles_in_hand > 0)'; }
# One takes tiles and answers none; its tiles would come back after 30 s.
beside_one_that_hangs() {
    local id
    "$build/tests/fake/fake_worker" --connect "unix:$data/worker.sock" --script hang --seconds $((60 * slower)) >"$tmp/hang.log" 2>&1 &
    hang=$!
    track $hang
    eventually 10 workers_are fake-hang
    id=$("$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet) || return 1
    eventually 10 holds_tiles
    worker good
    await_state "$id" finished 25 && [ "$(copied "$id")" -gt 0 ] && same_bytes "$id"
    local status=$?
    kill $hang $good; wait $hang $good
    return $status
}
check "a worker that hangs with tiles holds nobody up" beside_one_that_hangs

# One runs a tenth of the time. Whether its last tile is late depends on who else uses the machine: a
# few frames may pass before one of its tiles is copied.
beside_a_slow_one() {
    local id frame status=1
    worker slow; worker first; worker second
    (while kill -STOP $slow; do sleep 0.45; kill -CONT $slow; sleep 0.05; done) 2>/dev/null &
    local brake=$!
    track $brake
    for frame in 1 2 3 4 5; do
        id=$("$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet) &&
            await_state "$id" finished 60 && same_bytes "$id" || break
        echo "# frame $frame: $(copied "$id") copies"
        [ "$(copied "$id")" -eq 0 ] || { status=0; break; }
    done
    kill $brake; wait $brake
    kill -CONT $slow
    kill $slow $first $second; wait $slow $first $second
    return $status
}
check "beside a worker at a tenth of its speed: the same bytes" beside_a_slow_one
check "the service stops in order" serve_stop
tap_done
