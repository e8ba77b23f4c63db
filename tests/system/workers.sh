#!/usr/bin/env bash
# Workers that misbehave beside one that does not: the picture's bytes stay what they are. Those of
# another build, protocol or instruction set are refused with words that say what to do.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/workers.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
jq -n --arg scene "$PWD/tests/scenes/cornell-box/cornell-box.glb" \
    '{scene: {file: $scene}, image: {width: 320, height: 320}, sampling: {spp: 16, seed: 3}}' >"$tmp/job.json"
check "the undisturbed frame" "$build/shearwater" render "$tmp/job.json" --quiet -o "$tmp/alone.exr"

data=$tmp/data
check "a coordinator starts" serve_start "$data" --workers 0
# Each under a name of its own: what one did is not held against the next.
fake() { "$build/tests/fake/fake_worker" --connect "unix:$data/worker.sock" --script "$1" --name "$1-$RANDOM"; }

refused() { timeout 20 bash -c "$(declare -f fake); build='$build' data='$data'; fake $1" >"$tmp/$1.log" 2>&1
            grep -q '"REFUSED"' "$tmp/$1.log" && grep -qi "$2" "$tmp/$1.log"; }
check "another build is refused, and told what to do" refused wrong-build 'install the same build'
check "another protocol is refused" refused wrong-protocol 'version'
check "another instruction set is refused, and told what to do" refused wrong-isa 'SHEARWATER_ISA'

# Sets are named in small letters; a name that is none must not mean the best one.
unknown_isa() {
    ! SHEARWATER_ISA=AVX2 timeout 20 "$@" >"$tmp/isa.log" 2>&1 || return 1
    grep -q '"AVX2" is no instruction set: sse4.2, avx2 or avx512' "$tmp/isa.log" || { cat "$tmp/isa.log"; return 1; }
}
check "a coordinator refuses an instruction set that is none" \
    unknown_isa "$build/shearwater" render "$tmp/job.json" --quiet -o "$tmp/never.exr"
check "a worker refuses it, too" \
    unknown_isa "$build/shearwater-worker" --connect "unix:$data/worker.sock" --cache "$data/cache"

is_there() { roster | grep -q "$1"; }
# The fake has the frame to itself until it has done its worst; then a real worker joins.
disturbed() {
    local script=$1 id real
    timeout 60 bash -c "$(declare -f fake); build='$build' data='$data'; fake $script" >"$tmp/$script.log" 2>&1 &
    track $!
    eventually 10 is_there "$script-"
    id=$("$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet) || return 1
    "$build/shearwater-worker" --connect "unix:$data/worker.sock" --threads 1 --cache "$data/cache" \
        >>"$tmp/real.log" 2>&1 &
    real=$!
    track $real
    await_state "$id" finished 60 || { cat "$tmp/$script.log"; return 1; }
    curl -sSf --noproxy '*' -o "$tmp/$script.exr" "$url/v1/jobs/$id/frames/1/image.exr" || return 1
    kill $real; wait $real
    tail -n 3 "$tmp/$script.log"; grep -q WELCOME "$tmp/$script.log" || return 1 # it was there
    cmp "$tmp/alone.exr" "$tmp/$script.exr"
}
for script in garbage flip lie nan disconnect-mid-result; do
    check "a worker with the script $script changes no byte" disturbed $script
done
# With nobody else there, what they send fails the job alone: it is not the end of the service.
given_up() {
    local id
    timeout 60 bash -c "$(declare -f fake); build='$build' data='$data'; fake nan" >"$tmp/given-up.log" 2>&1 &
    local fake=$!
    track $fake
    eventually 10 is_there nan-
    id=$("$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet) || return 1
    ! await_state "$id" finished 30 || return 1
    [ "$(job_state "$id")" = failed ] || return 1
    curl -sSf --noproxy '*' "$url/v1/workers" | tee /dev/stderr |
        jq -e '[.workers[].state] | length > 0 and all(. != "draining")' || return 1
    kill $fake; wait $fake
    true
}
check "a job that none can do fails, and its workers are asked again" given_up
check "the coordinator counted what it refused" bash -c "
    curl -sS --noproxy '*' '$url/metrics' | awk '/results_total.*corrupt/ {n = \$2} END {exit !(n > 0)}'"
check "it is alive and stops in order" serve_stop
tap_done
