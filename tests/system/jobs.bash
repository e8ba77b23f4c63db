# What system tests do with jobs. Source it after tests/tap.bash.
#   is A B                         whether two words are the same
#   eventually SECONDS COMMAND...  waits until the command succeeds
#   settled COMMAND...             waits until the command prints the same twice
#   ended PID SECONDS              waits for the end of a process
#   http CURL-ARGUMENTS...
#   render JOB OUT ARGUMENTS...    $tmp/JOB.json to $tmp/OUT.exr, with its statistics in $tmp/OUT.stats
#   counts OUT FILTER              asks jq about those
#   check_counts OUT {TEXT FILTER}...  tests of them, by one jq for all
#   figure A B ARGUMENTS...        compares two pictures, by beauty
#   compared A B LAYER ARGUMENTS...
# On the coordinator that runs, with its data in $tmp/data:
#   start ARGUMENTS...             it, with two workers
#   submit MEMBERS                 a job of the box; prints its id
#   get, shows, number ID FILTER; has_landed ID TILES; pause_at ID TILES; exr ID OUT [FRAME]; workers_empty; workers_are NAMES
is() { [ "$1" = "$2" ] || { echo "$1, not $2"; return 1; }; }
eventually() {
    local end=$((SECONDS + $1 * slower)); shift
    until "$@" >/dev/null 2>&1; do [ $SECONDS -lt $end ] || { "$@"; return 1; }; nap 0.05; done
}
settled() {
    local before= now _
    for _ in $(tries 50); do
        now=$("$@")
        [ "$now" != "$before" ] || return 0
        before=$now
        nap 0.2
    done
    return 1
}
is_gone() { ! kill -0 "$1" 2>/dev/null; }
ended() { eventually "$2" is_gone "$1"; }
http() { curl -sS --noproxy '*' --max-time 30 "$@"; }
render() {
    "$build/shearwater" render "$tmp/$1.json" --quiet -o "$tmp/$2.exr" --stats "$tmp/$2.stats" "${@:3}"
}
counts() { jq -e "$2" "$tmp/$1.stats"; }
check_counts() {
    local out=$1 texts=() filters=() answers k
    for ((k = 2; k < $#; k += 2)); do texts+=("${@:k:1}") filters+=("(${@:k+1:1})"); done
    mapfile -t answers < <(jq "$(IFS=,; echo "${filters[*]}")" "$tmp/$out.stats" 2>&1)
    for k in "${!texts[@]}"; do check "${texts[k]}" is "${filters[k]} ${answers[k]:-}" "${filters[k]} true"; done
}
figure() { "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$2.exr" --layer beauty "${@:3}"; }
compared() { "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$2.exr" --layer "$3" "${@:4}" | tee /dev/stderr; }

start() { serve_start "$tmp/data" --workers 2 --worker-threads 1 "$@" || { echo "Bail out! the server did not start"; exit 1; }; }
submit() {
    printf '{"scene": {"file": "%s/tests/scenes/cornell-box/cornell-box.glb"}, %s}' "$PWD" "$1" >"$tmp/job.json"
    "$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet
}
get() { read_url "/v1/jobs/$1" cat; }
shows() { read_url "/v1/jobs/$1" jq -e "$2"; }
number() { read_url "/v1/jobs/$1" jq "$2"; }
has_landed() { local value; read_member "/v1/jobs/$1" tiles_done && [ "$value" -ge "$2" ]; }
both_workers() { workers=$(read_url /v1/workers jq '.workers[].pid') && is "$(wc -w <<<"$workers")" 2; }
# The workers stand still meanwhile: on a busy machine a job ends before a command has begun.
pause_at() {
    local workers status
    eventually 10 both_workers && eventually 60 has_landed "$1" "$2" || return 1
    kill -STOP $workers
    "$build/shearwater" steer "$1" --server "$url" --pause >/dev/null
    status=$?
    kill -CONT $workers
    return $status
}
exr() { http -f -o "$2" "$url/v1/jobs/$1/frames/${3:-1}/image.exr"; }
workers_empty() { read_url /v1/workers jq -e 'all(.workers[]; .tiles_in_hand == 0)'; }
roster() { read_url /v1/workers jq -r '[.workers[].name] | sort | join(" ")'; }
workers_are() { is "$(roster)" "$1"; }

# A worker that dies over the second set of $tmp/large.json changes no byte of $tmp/large.exr.
survives_second_set() {
    local id pid
    second_worker() {
        "$build/shearwater-worker" --connect "unix:$tmp/data/worker.sock" --threads 1 --cache "$tmp/data/cache" >>"$tmp/worker.log" 2>&1 &
        pid=$!
        track $pid
    }
    second_worker
    id=$("$build/shearwater" submit "$tmp/large.json" --server "$url" --quiet) || return 1
    eventually 12 shows "$id" '.progress.tiles_total > 256' # the second set is out
    number "$id" .progress
    [ "$(job_state "$id")" = running ] || return 1
    kill_holding "$pid" || return 1
    second_worker
    await_state "$id" finished 60 || return 1
    exr "$id" "$tmp/survived.exr" || return 1
    shows "$id" '.statistics.tiles.reissued > 0' || return 1
    cmp "$tmp/large.exr" "$tmp/survived.exr"
}
