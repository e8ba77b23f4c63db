#!/usr/bin/env bash
# Workers that misbehave, are sent away, die or seem to: what was damaged never reaches the picture,
# who does it again and again is put into quarantine, and a tile that ends its workers ends its job.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/worker_health.sh BUILD_DIR [MUTATIONS]}
mutations=${2:-2000}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
jq -n --arg scene "$scene" '{scene: {file: $scene}, image: {width: 320, height: 320}, sampling: {spp: 4, seed: 3}}' >"$tmp/job.json"
# One tile of one pass, some seconds of work.
jq -n --arg scene "$scene" '{scene: {file: $scene}, image: {width: 256, height: 256}, filter: {method: "none"},
    sampling: {spp: 16, seed: 3, tile_px: 256}, effects: {indirect_bounces: 32}}' >"$tmp/heavy.json"
check "the undisturbed frames" bash -c "for name in job heavy; do
    '$build/shearwater' render '$tmp'/\$name.json --quiet -o '$tmp'/\$name.exr || exit 1; done"

data=$tmp/data
check "a coordinator starts" serve_start "$data" --workers 0
get() { curl -sSf --noproxy '*' "$url$1"; }
submit() { "$build/shearwater" submit "$tmp/$1.json" --server "$url" --quiet; }
fake() { "$build/tests/fake/fake_worker" --connect "unix:$data/worker.sock" "$@"; }
fake_behind() { # VARIABLE ARGS: in the background
    local variable=$1; shift
    "$build/tests/fake/fake_worker" --connect "unix:$data/worker.sock" "$@" >>"$tmp/behind.log" 2>&1 &
    printf -v "$variable" %s $!
    track $!
}
worker() { # VARIABLE
    "$build/shearwater-worker" --connect "unix:$data/worker.sock" --threads 1 --cache "$data/cache" >>"$tmp/real.log" 2>&1 &
    printf -v "$1" %s $!
    track $!
}
same_bytes() { get "/v1/jobs/$1/frames/1/image.exr" >"$tmp/got.exr" && cmp "$tmp/$2.exr" "$tmp/got.exr"; }
metric() { get /metrics | awk -v name="$1" '$1 == name {print $2}'; }
roster() { read_url /v1/workers jq -c ".workers[] | select(.name == \"$1\")"; }
is_listed() { roster "$1" | jq -e "$2" || { roster "$1"; return 1; }; }
await_roster() { eventually "$3" is_listed "$1" "$2"; } # NAME CONDITION SECONDS
seconds_since() { awk -v from="$1" -v to="$(date +%s.%N)" 'BEGIN {printf "%.1f\n", to - from}'; }

# ---- damage on the wire ----

damaged() { # SCRIPT TIMES
    local id real status
    id=$(submit job) || return 1
    fake --script "$1" --tiles "$2" --reconnects "$2" --seconds $(((30 + $2 / 50) * slower)) >"$tmp/$1.log" 2>&1
    tail -n 1 "$tmp/$1.log"
    [ "$(tail -n 1 "$tmp/$1.log" | jq '.answers')" = "$2" ] || return 1
    [ "$(tail -n 1 "$tmp/$1.log" | jq '.accepted')" = 0 ] || return 1
    get "/v1/jobs/$id" | jq -c '{state, problem, progress}'
    [ "$(get "/v1/jobs/$id" | jq .progress.tiles_done)" = 0 ] || return 1
    worker real
    await_state "$id" finished 60 && same_bytes "$id" job
    status=$?
    [ $status = 0 ] || tail -n 5 "$tmp/real.log"
    kill "$real"; wait "$real"
    return $status
}
check "each of the 192 bits of a header flipped: nothing counts, the same bytes" damaged header 192
check "$mutations changed bodies: nothing counts, the same bytes" damaged mutate "$mutations"

# ---- quarantine ----

quarantined() {
    local before
    submit job >"$tmp/id" || return 1
    before=$(metric shearwater_workers_quarantined_total)
    fake_behind breaker --script flip --name breaker --reconnects 5 --seconds $((60 * slower))
    await_roster breaker '.state == "quarantined" and (.quarantine.reason | test("protocol")) and .quarantine.seconds_left > 500' 20 &&
        [ "$(metric shearwater_workers_quarantined_total)" = $((before + 1)) ]
}
check "three broken messages put a worker into quarantine" quarantined
given() { sleep 1; [ "$(roster breaker | jq .tiles_in_hand)" = 0 ]; }
check "it comes back under its name and gets no tiles" given
taken_back() {
    local worker
    worker=$(roster breaker | jq .id)
    curl -sSf --noproxy '*' -X PATCH -H 'Content-Type: application/json' -d '{"drain": false}' "$url/v1/workers/$worker" >/dev/null || return 1
    # It breaks the protocol again, once, and is forgiven that far.
    await_roster breaker '.quarantine == null' 10
    local status=$?
    kill $breaker; wait $breaker
    return $status
}
check "an operator takes it back" taken_back
others() {
    local real status
    worker real
    await_state "$(cat "$tmp/id")" finished 60 && same_bytes "$(cat "$tmp/id")" job
    status=$?
    kill "$real"; wait "$real"
    return $status
}
check "others finish the frame meanwhile" others

# ---- hangs and silence ----

within() { awk -v s="$(seconds_since "$from")" -v most=$(($1 * slower)) 'BEGIN {exit !(s <= most)}'; }

stalled() {
    local from id
    from=$(date +%s.%N)
    id=$(submit job) || return 1
    fake_behind hang --script hang --name hangs --seconds $((60 * slower))
    await_roster hangs '.tiles_in_hand > 0' 5 || return 1
    from=$(date +%s.%N)
    await_roster hangs '.state == "stalled" and .tiles_in_hand == 0' 15 || return 1
    echo "# a hang is noticed after $(seconds_since "$from") s" >&3
    kill $hang; wait $hang
    curl -sSf --noproxy '*' -X DELETE "$url/v1/jobs/$id" >/dev/null
    within 11
}
exec 3>&1
check "tiles of a worker that hangs are taken back within 11 s" stalled
half_open() {
    local from id
    id=$(submit job) || return 1
    fake_behind stopped --script hang --name stopped --seconds $((60 * slower))
    await_roster stopped '.tiles_in_hand > 0' 5 || return 1
    kill -STOP $stopped
    from=$(date +%s.%N)
    until get /v1/workers | jq -e 'all(.workers[]; .name != "stopped")' >/dev/null; do # a look that failed tells nothing
        within 15 || return 1
        nap 0.1
    done
    echo "# a half-open link is noticed after $(seconds_since "$from") s" >&3
    kill -KILL $stopped; wait $stopped
    curl -sSf --noproxy '*' -X DELETE "$url/v1/jobs/$id" >/dev/null
    within 12
}
check "a half-open link is ended within 12 s" half_open

# ---- death ----

deadly() {
    local id
    id=$(submit job) || return 1
    # Each dies of whatever it gets; the first holds two tiles, so that either may be given next.
    for i in 1 2 3 4 5 6; do
        [ "$(job_state "$id")" = failed ] && break
        fake --script die --name "dies-$i" --seconds $((10 * slower)) >"$tmp/die-$i.log" 2>&1
        [ $i -ge 3 ] || [ "$(job_state "$id")" = running ] || return 1
    done
    ! await_state "$id" finished 10 && get "/v1/jobs/$id" | jq -e '.error.detail | test("ended at least 3 workers")'
}
check "a tile that ends three workers fails its job, and says so" deadly
survives() {
    local id real status
    id=$(submit job) || return 1
    fake --script die --name survivor --reconnects 8 --seconds $((20 * slower)) >"$tmp/survivor.log" 2>&1
    [ "$(grep -c '"TILE"' "$tmp/survivor.log")" -ge 1 ] && [ "$(job_state "$id")" != failed ] || return 1
    worker real
    await_state "$id" finished 60 && same_bytes "$id" job
    status=$?
    kill "$real"; wait "$real"
    return $status
}
check "a worker that loses its link eight times and comes back has not died" survives
check "the coordinator stops in order" serve_stop

crashes_expected
check "a coordinator with a worker of its own starts" serve_start "$tmp/own" --workers 1
own_pid() { read_url /v1/workers jq -r ".workers[] | select(.tiles_in_hand > 0) | .pid"; }
kill_at_work() { # SIGNAL ID TIMES
    local pid last=0
    for _ in $(seq "$3"); do
        for _ in $(tries 200); do
            pid=$(own_pid)
            [ -n "$pid" ] && [ "$pid" != "$last" ] && break
            case $(job_state "$2") in failed | finished) return 1 ;; esac
            nap 0.05
        done
        [ -n "$pid" ] && [ "$pid" != "$last" ] || return 1
        kill "-$1" "$pid"
        last=$pid
    done
}
killed_from_outside() {
    local id
    id=$(submit heavy) || return 1
    kill_at_work KILL "$id" 4 || return 1
    await_state "$id" finished 60 && same_bytes "$id" heavy
}
check "a worker killed four times at the same tile: the job is done, the same bytes" killed_from_outside
stopped_for_good() { # nobody else is there who could do its tiles
    local id
    id=$(submit heavy) || return 1
    kill_at_work STOP "$id" 1 || return 1
    await_state "$id" finished 60 && same_bytes "$id" heavy
}
check "the only worker stands still for good: it is ended and started again, the same bytes" stopped_for_good
crashed() {
    local id
    id=$(submit heavy) || return 1
    ulimit -c 0
    kill_at_work SEGV "$id" 3 || return 1
    ! await_state "$id" finished 20 && get "/v1/jobs/$id" | jq -e '.error.detail | test("ended at least 3 workers")'
}
check "one that crashes three times at the same tile: the job fails" crashed
check "the coordinator is alive and stops in order" serve_stop
tap_done
