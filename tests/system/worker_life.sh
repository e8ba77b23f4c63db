#!/usr/bin/env bash
# How workers of a cluster come and go: names of the engine's, keys that no one else can read, an address that
# never answers, idle workers and short lives; and clocks that differ by a year. No byte changes by any of it.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/worker_life.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
umask 077
openssl rand -hex 32 >"$tmp/key"
box='"image": {"width": 256, "height": 256}, "sampling": {"spp": 80, "tile_px": 32}, "filter": {"method": "none"}'
worker() { # worker NAME ARGS...: in the background; its pid is in $worker
    "$build/shearwater-worker" --threads 1 --cache "$tmp/cache" "${@:2}" >"$tmp/$1.log" 2>&1 &
    worker=$!
    track $worker
}
leaves() { # leaves NAME PID STATUS SECONDS WORDS
    ended "$2" "$4" || { cat "$tmp/$1.log"; return 1; }
    wait "$2"; is $? "$3" && grep -q "$5" "$tmp/$1.log" || { cat "$tmp/$1.log"; return 1; }
}

serve_start "$tmp/data" --workers 0 --worker-listen 127.0.0.1:0 --worker-key "$tmp/key" || { echo "Bail out! no server"; exit 1; }
port=$(worker_port "$tmp/data")
link=(--connect "127.0.0.1:$port" --key "$tmp/key")

# Keys.
for mode in 604 620 640 644; do
    install -m $mode "$tmp/key" "$tmp/key.$mode"
    worker open.$mode --connect "127.0.0.1:$port" --key "$tmp/key.$mode"
    check "a key of mode $mode is refused" leaves open.$mode $worker 1 5 "chmod 600"
done
refused() { ! timeout 10 "$build/shearwater" serve --listen 127.0.0.1:0 --workers 0 --data "$tmp/other" --worker-listen 127.0.0.1:0 \
    --worker-key "$tmp/key.$1" 2>"$tmp/refused" && grep -q "chmod 600" "$tmp/refused"; }
check "... by the coordinator, too" refused 640

# The first connection.
node -e 'require("net").createServer(() => {}).listen(0, "127.0.0.1", function () { console.log(this.address().port); })' >"$tmp/silent" &
track $!
eventually 5 [ -s "$tmp/silent" ]
worker silent --connect "127.0.0.1:$(cat "$tmp/silent")" --key "$tmp/key" --connect-within 2
check "an address that never answers is given up" leaves silent $worker 1 8 "has not answered within 2 s"
worker closed --connect 127.0.0.1:9 --key "$tmp/key" --connect-within 1
check "one that refuses, too" leaves closed $worker 1 6 "has not answered within 1 s"

# Names.
SLURM_JOB_ID=8 SLURM_ARRAY_JOB_ID=7 SLURM_ARRAY_TASK_ID=3 worker slurm "${link[@]}"; slurm=$worker
check "a worker of Slurm has the job's name" eventually 5 workers_are "$(uname -n):slurm-7_3"
kill $slurm
eventually 5 workers_are ''
POD_NAME=$(printf '%010000d' 0) worker long "${link[@]}"; long=$worker
check "a name of 10 kB is passed over" eventually 5 workers_are "$(uname -n):$long"
kill $long
check "one that is given is refused" bash -c "! '$build/shearwater-worker' --connect unix:/x --name $(printf '%0300d' 0) 2>'$tmp/named' && grep -q '1 to 255 bytes: give a shorter one' '$tmp/named'"
check "... as one with a line end" bash -c "! '$build/shearwater-worker' --connect unix:/x --name \$'two\nlines' 2>'$tmp/named' && grep -q 'printable UTF-8' '$tmp/named'"

# The picture, by one worker that stays until it idles.
worker idle "${link[@]}" --idle-exit 2; idle=$worker
id=$(submit "$box")
check "a worker that leaves when it idles does the work first" await_state "$id" finished 60
exr "$id" "$tmp/once.exr"
check "... and then leaves in order" leaves idle $idle 0 12 "idle"
check "no thread is wanted" is "$(http "$url/v1/stats" | jq .threads_wanted)" 0

# The same by workers with a life of 2 s each, as often as it takes.
short_lives() {
    local id n=0
    id=$(submit "$box")
    while [ "$(job_state "$id")" != finished ]; do
        [ $((n++)) -lt $((60 * slower)) ] || return 1
        worker life.$n "${link[@]}" --lifetime $((2 * slower)) --nice 19
        wait $worker || { cat "$tmp/life.$n.log"; return 1; }
    done
    [ $n -ge 2 ] || { echo "one life was enough"; return 1; }
    exr "$id" "$tmp/lives.exr" && cmp "$tmp/once.exr" "$tmp/lives.exr"
}
check "workers with short lives make the same bytes" short_lives

# Clocks that are a year ahead, or behind: nothing goes by them. (tests/fake/preload_faults.c)
off_by() { # off_by YEARS NAME
    head -c 232 /dev/zero >"$tmp/control"
    node -e 'const fs = require("fs"), file = fs.openSync(process.argv[1], "r+"), b = Buffer.alloc(8);
        b.writeBigInt64LE(31536000n * BigInt(process.argv[2])); fs.writeSync(file, b, 0, 8, 192);' "$tmp/control" "$1"
    LD_PRELOAD=$(realpath "$build/tests/fake/preload_faults.so") FAULTS_FOR=shearwater-worker FAULTS_CONTROL=$tmp/control \
        worker "$2" "${link[@]}" --idle-exit 2 --lifetime 600
    local pid=$worker
    id=$(submit "$box")
    check "a worker whose clock is a year $2 does the work" await_state "$id" finished 60
    check "... under its own time" grep -q "^$(($(date +%Y) + $1))-" "$tmp/$2.log"
    exr "$id" "$tmp/$2.exr"
    check "... with the same bytes" cmp "$tmp/once.exr" "$tmp/$2.exr"
    check "... and leaves when it idles" leaves "$2" $pid 0 12 "idle"
}
if is_sanitized; then
    skip "clocks that differ by a year" "a sanitizer's allocator cannot be preloaded before"
else
    off_by 1 ahead
    off_by -1 behind
fi
tap_done
