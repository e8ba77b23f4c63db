#!/usr/bin/env bash
# What /readyz says, and the end: it tells of a missing worker, of a disk that is full or fails, and of the
# shutdown; SIGTERM lets requests end, keeps tiles that have landed, and leaves with status 0.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/drain.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
asset=$(sha256sum <"$scene" | cut -c1-64)
says() { # says PATH STATUS [SLUG]: "ok" without a slug
    is "$(http -o "$tmp/body" -w '%{http_code}' "$url$1")" "$2" &&
        is "$(jq -r '.type // .status' "$tmp/body")" "${3:+urn:shearwater:problem:}${3:-ok}"
}
leaves() { # leaves STATUS SECONDS: the server
    ended $server_pid "$2" || return 1
    wait $server_pid; is $? "$1"
}
under_way() { [ -n "$(find "$tmp/data/tmp" -name "object-*" -size +$1k)" ]; }

# A disk that fails when it is told to: tests/fake/preload_faults.c.
preload=$build/tests/fake/preload_faults.so
fault() { # fault KIND ERRNO: from now on; 0: not any more
    node -e 'const fs = require("fs"), [path, kind, error] = process.argv.slice(1);
        const plan = Buffer.from(new BigInt64Array(error === "0" ? [0n, 0n, 0n] : [1n, 1n << 60n, BigInt(error)]).buffer);
        const file = fs.openSync(path, "r+"); fs.writeSync(file, plan, 0, 24, kind * 32 + 8);' "$tmp/control" "$1" "$2"
}
if is_sanitized; then
    skip "readyz and a failing disk" "a sanitizer's allocator cannot be preloaded before"
else
    head -c 168 /dev/zero >"$tmp/control"
    LD_PRELOAD=$(realpath "$preload") FAULTS_FOR=shearwater FAULTS_CONTROL=$tmp/control \
        serve_start "$tmp/disk" --workers 0 || echo "Bail out! the server did not start"
    check "without a worker it is not ready" says /readyz 503 no-worker
    "$build/shearwater-worker" --connect "unix:$tmp/disk/worker.sock" --threads 1 --cache "$tmp/disk/cache" 2>"$tmp/worker.log" &
    worker=$!
    track $worker
    check "with one it is" eventually 10 says /readyz 200
    for kind in 0 1 4; do
        fault $kind 28
        check "a full disk is told of (call $kind)" eventually 3 says /readyz 507 disk-full
        fault $kind 5
        check "so is a failing one (call $kind)" eventually 3 says /readyz 503 storage-failed
        check "... and it lives (call $kind)" says /livez 200
        fault $kind 0
        check "healed, it is ready (call $kind)" eventually 3 says /readyz 200
    done
    check "asking leaves nothing behind" is "$(find "$tmp/disk/tmp" -type f | wc -l)" 0
    kill $worker; wait $worker 2>/dev/null
    check "when its worker has gone it is not ready" eventually 10 says /readyz 503 no-worker
    serve_stop
fi

# The end. An upload is under way, a job is in work, somebody watches.
serve_start "$tmp/data" --workers 2 --worker-threads 1 || echo "Bail out! the server did not start"
http -T "$scene" -o "$tmp/body" "$url/v1/assets/$asset"
id=$(http -H 'Content-Type: application/json' "$url/v1/jobs" -d "{\"scene\": {\"asset\": \"$asset\"},
    \"image\": {\"width\": 320, \"height\": 320}, \"sampling\": {\"spp\": 96, \"tile_px\": 32}, \"filter\": {\"method\": \"none\"}}" | jq -r .id)
check "tiles land" eventually 60 has_landed "$id" 10
http -N "$url/v1/jobs/$id/events" >"$tmp/events" &
events=$!
track $events
head -c 300000 /dev/urandom >"$tmp/noise"
name=$(sha256sum <"$tmp/noise" | cut -c1-64)
# By hand, so that it is under way for as long as it takes here.
exec 3<>"/dev/tcp/127.0.0.1/${url##*:}"
printf 'PUT /v1/assets/%s HTTP/1.1\r\nHost: %s\r\nContent-Length: 300000\r\nConnection: close\r\n\r\n' "$name" "${url#http://}" >&3
head -c 150000 "$tmp/noise" >&3
eventually 10 under_way 100
before=$(number "$id" .progress.tiles_done)
kill -TERM $server_pid
check "it says that it ends" eventually 5 says /readyz 503 draining
check "... and lives" says /livez 200
check "nothing new is taken" is "$(http -o /dev/null -w '%{http_code}' "$url/v1/jobs")" 503
tail -c 150000 "$tmp/noise" >&3
check "the upload comes to its end, and is taken" grep -q '^HTTP/1.1 201 ' <(timeout 10 cat <&3)
exec 3>&-
check "the stream ends, too" wait $events
check "the status is 0" leaves 0 15
check "no worker is left" bash -c "! pgrep -f 'unix:$tmp/data/worker[.]sock'"
serve_start "$tmp/data" --workers 2 --worker-threads 1 || echo "Bail out! the server did not start again"
check "the upload is there" is "$(http -I -o /dev/null -w '%{http_code}' "$url/v1/assets/$name")" 200
resumed() { [ "$(number "$id" .statistics.tiles.resumed)" -ge "$before" ]; }
check "no tile that had landed is traced again" eventually 20 resumed
check "the job finishes" await_state "$id" finished 300

# A request that does not end: the second signal does.
head -c 30000000 /dev/zero >"$tmp/long"
name=$(sha256sum <"$tmp/long" | cut -c1-64)
http --limit-rate 100k -T "$tmp/long" -o /dev/null "$url/v1/assets/$name" 2>"$tmp/cut" &
track $!
eventually 10 under_way 0
kill -TERM $server_pid
eventually 5 says /readyz 503 draining
sleep 0.5 # long enough for an end
check "it waits for a request" kill -0 $server_pid
kill -TERM $server_pid
check "a second SIGTERM ends it at once" leaves 143 1
serve_start "$tmp/data" --workers 0 || echo "Bail out! the server did not start again"
http --limit-rate 100k -T "$tmp/long" -o /dev/null "$url/v1/assets/$name" 2>"$tmp/cut" &
track $!
eventually 10 under_way 0
kill -TERM $server_pid
check "one that takes too long is cut off" leaves 0 14
tap_done
