#!/usr/bin/env bash
# The server's log as a program reads it: every line is an object, and a request, the job that it
# submitted and what became of that are found by one id, which the caller may have given.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/logs.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
header() { sed -n "s/^$1: //Ip" "$tmp/head" | tr -d '\r'; }
lines() { jq -c "$@" "$log"; }
a_line() { [ -n "$(lines "select($1)")" ] || { echo "no line with $1"; tail -n 5 "$log"; return 1; }; }
has() { eventually 5 a_line "$1"; } # has FILTER: some line of the log, soon

serve_start "$tmp/data" --workers 1 --log-format json || { echo "Bail out! the server did not start"; exit 1; }
log=$tmp/data/stderr
check "the start is told, with its figures" has '.message == "serving" and .pid == '$server_pid' and .workers == 1'

trace=4bf92f3577b34da6a3ce929d0e0e4736 span=00f067aa0ba902b7
asset=$(sha256sum <"$scene" | cut -c1-64)
http -T "$scene" -o "$tmp/body" "$url/v1/assets/$asset"
http -D "$tmp/head" -o "$tmp/body" -H 'Content-Type: application/json' -H "traceparent: 00-$trace-$span-01" \
    -d "{\"scene\": {\"asset\": \"$asset\"}, \"image\": {\"width\": 64, \"height\": 64}, \"sampling\": {\"spp\": 1}}" "$url/v1/jobs"
id=$(jq -r .id "$tmp/body") request=$(header X-Request-Id)
check "the answer has the request's id" grep -qxE '[0-9a-f]{16}' <<<"$request"
check "... and goes on with the caller's trace" is "$(header traceparent)" "00-$trace-$request-01"
check "the job finishes" await_state "$id" finished 60
same=".request == \"$request\" and .trace == \"$trace\" and .parent == \"$span\" and .job == \"$id\""
check "the request's line has the trace and the job" has \
    "$same and .message == \"request\" and .method == \"POST\" and .route == \"/v1/jobs\" and .status == 202 and .duration_seconds > 0"
check "so has the job's first line" has "$same and .message == \"job\" and .detail == \"accepted\""
check "so has its last" has "$same and .kind == \"state\" and (.detail | startswith(\"finished\"))"

check "the worker's lines are there, in the same form" has '.message == "connected" and .worker == "local-1" and .level == "info"'
check "... with the job and the request that submitted it" has "$same and .message == \"work for a job\" and .worker == \"local-1\" and .frame_id > 0"

# Whatever comes as a traceparent.
fresh() { # fresh CURL-ARGUMENTS: a request that is served, and begins a trace of its own
    : >"$tmp/head"
    local status; status=$(http -D "$tmp/head" -o "$tmp/body" -w '%{http_code}' "$@" "$url/v1/jobs")
    is "$status" 200 && grep -qxE '00-[0-9a-f]{32}-[0-9a-f]{16}-00' <<<"$(header traceparent)" &&
        ! grep -q "$trace" "$tmp/head" && has ".request == \"$(header X-Request-Id)\" and (has(\"parent\") | not)"
}
check "without a traceparent a trace begins" fresh
check "one that is cut short is none" fresh -H "traceparent: 00-$trace-$span-0"
check "one with capital letters is none" fresh -H "traceparent: 00-${trace^^}-$span-01"
check "two are none" fresh -H "traceparent: 00-$trace-$span-01" -H "traceparent: 00-$trace-$span-01"
check "bytes that are no text are none" fresh -H "traceparent: "$'00-\xff\xfe"\x1b[2J{'"$trace"
check "a long one is none" fresh -H "traceparent: 00-$trace-$span-01$(head -c 6000 /dev/zero | tr '\0' a)"
check "refused requests have ids, too" bash -c "
    curl -sS --noproxy '*' -D - -o /dev/null '$url/v1/nothing%22%0a' | grep -qi '^X-Request-Id: [0-9a-f]\{16\}'"
check "... and a line" has '.status == 404 or .status == 400'
http -o "$tmp/body" "$url/livez"; http -o "$tmp/body" "$url/metrics"
check "a job that fails is told of, and is no error of the server's" bash -c '
    head -c 4000 /dev/urandom >"'"$tmp"'/noise"; asset=$(sha256sum <"'"$tmp"'/noise" | cut -c1-64)
    curl -sS --noproxy "*" -T "'"$tmp"'/noise" -o /dev/null "'"$url"'/v1/assets/$asset"
    curl -sS --noproxy "*" -H "Content-Type: application/json" -d "{\"scene\": {\"asset\": \"$asset\"}}" "'"$url"'/v1/jobs" | jq -r .id >"'"$tmp"'/failing"
    [ -s "'"$tmp"'/failing" ]'
check "... as a warning with its reason" has ".job == \"$(cat "$tmp/failing")\" and .kind == \"error\" and .level == \"warning\" and (.request | length) == 16"
serve_stop
check "the end is told" has '.message == "stopped"'
all_objects() {
    is "$(jq -R 'try (fromjson | has("time") and has("level") and has("message")) catch false' "$log" | sort | uniq -c | tr -s ' ')" \
        " $(wc -l <"$log") true"
}
check "every line is an object" all_objects
check "probes and metrics have no lines" bash -c "! grep -E '\"route\":\"/(livez|metrics)\"' '$log'"
check "nothing was an error" bash -c "! grep '\"level\":\"error\"' '$log'"

# The request that submitted a job is known after a restart, and far away.
submit() { # submit SEED: sets $id and $same
    http -D "$tmp/head" -o "$tmp/body" -H 'Content-Type: application/json' -H "traceparent: 00-$trace-$span-01" \
        -d "{\"scene\": {\"asset\": \"$asset\"}, \"image\": {\"width\": 64, \"height\": 64}, \"sampling\": {\"spp\": 1, \"seed\": $1}}" "$url/v1/jobs"
    id=$(jq -r .id "$tmp/body")
    same=".request == \"$(header X-Request-Id)\" and .trace == \"$trace\" and .parent == \"$span\" and .job == \"$id\""
}
serve_start "$tmp/data" --workers 0 --log-format json || echo "Bail out! the server did not start again"
submit 2
serve_stop -KILL
: >"$log"
serve_start "$tmp/data" --workers 1 --log-format json || echo "Bail out! the server did not start after a kill"
check "a job goes on after a kill" await_state "$id" finished 60
check "... its lines with the request of before" has "$same and .kind == \"state\" and (.detail | startswith(\"finished\"))"
check "... and its worker's" has "$same and .message == \"work for a job\""
serve_stop

# A worker elsewhere that can keep no file: it says which lease it could not serve.
: >"$log"
serve_start "$tmp/data" --workers 0 --worker-listen 127.0.0.1:0 --log-format json || echo "Bail out! the server did not start again"
submit 3
port=$(worker_port "$tmp/data")
(trap '' XFSZ; ulimit -f 0; exec "$build/shearwater-worker" --connect "127.0.0.1:$port" --threads 1 --name far --cache "$tmp/cache" --log-format json) \
    2> >(exec cat >"$tmp/far") &
far=$!
track $far
log=$tmp/far
check "a far worker tells that it is connected" has ".message == \"connected\" and .worker == \"far\" and .coordinator == \"127.0.0.1:$port\""
check "... and which lease it cannot serve, of which job" has "$same and .message == \"tile cannot be traced\" and .level == \"warning\"
    and .frame_id > 0 and .tile >= 0 and .generation >= 1 and (.detail | length) > 0"
kill $far; wait $far 2>/dev/null
check "... and that it leaves" has '.message == "leaving"'
check "each of its lines is an object" all_objects
serve_stop
log=$tmp/data/stderr

serve_start "$tmp/data" --workers 0 --quiet || echo "Bail out! the server did not start again"
: >"$log"
http -o "$tmp/body" "$url/v1/jobs"
serve_stop
check "--quiet says nothing of what went well" [ ! -s "$log" ]
check "a format that is none is refused" bash -c "'$build/shearwater' serve --log-format xml 2>&1 | grep -q 'text or json'"

# A disk on which the log's writes hang: tests/fake/preload_faults.c.
hang_log() { # hang_log CALLS: so many from now on; 0: not any more
    node -e 'const fs = require("fs"), [path, count] = process.argv.slice(1), file = fs.openSync(path, "r+");
        const calls = Buffer.alloc(8);
        fs.readSync(file, calls, 0, 8, 200);
        const first = count === "0" ? 0n : calls.readBigInt64LE() + 1n;
        fs.writeSync(file, Buffer.from(new BigInt64Array([first, BigInt(count), 0n]).buffer), 0, 24, 208);' "$tmp/control" "$1"
}
faulty_start() { # faulty_start PROGRAM ARGS...
    local program=$1; shift
    head -c 232 /dev/zero >"$tmp/control"
    LD_PRELOAD=$(realpath "$build/tests/fake/preload_faults.so") FAULTS_FOR=$program FAULTS_CONTROL=$tmp/control \
        serve_start "$tmp/data" --log-format json "$@" || echo "Bail out! the server did not start again"
}
answers() { # answers COUNT: so many requests, each with a line
    is "$(timeout 60 curl -sS --noproxy '*' -o /dev/null -w '%{http_code}\n' "$url/v1/jobs?limit=1&text=[1-$1]" | sort | uniq -c | tr -s ' ')" " $1 200"
}
lost() { curl -sS --noproxy '*' --max-time 20 "$url/metrics" | sed -n 's/^shearwater_log_lines_dropped_total //p'; }
all_or_told() { # of N requests each has a line, or is among those that are said to be lost
    local told; told=$(lines 'select(.message == "lines of the log were lost").lines' | awk '{ sum += $1 } END { printf "%.0f\n", sum }')
    is "$(($(lines 'select(.message == "request")' | wc -l) + ${told:-0}))" "$1"
}
in_order() { is "$(lines -r 'select(.message == "request").time' | sort -c 2>&1)" ""; }
if is_sanitized; then
    skip "a log that hangs" "a sanitizer's allocator cannot be preloaded before"
else
    : >"$log"
    faulty_start shearwater --workers 0
    check "with a log that is read all is answered" answers 100
    hang_log 1000000000
    check "a log that hangs keeps nobody waiting" answers 4000
    dropped=$(lost)
    check "... and lines are lost and counted" [ "${dropped:-0}" -gt 1000 ]
    hang_log 0
    sleep 0.5 # a line that is written meanwhile finds room again
    check "afterwards all is answered" answers 10
    check "... and it is said how many were lost" has ".message == \"lines of the log were lost\" and .lines > 0" # all of them: below
    serve_stop
    check "every request has a line or is among them" all_or_told 4110
    check "... in order" in_order
    check "the end is told after that" has '.message == "stopped"'
    faulty_start shearwater --workers 0
    hang_log 1000000000
    start=$SECONDS
    answers 10 >/dev/null
    serve_stop
    check "a log that hangs lets the server end" [ $((SECONDS - start)) -le $((8 * slower)) ]
    faulty_start shearwater-worker --workers 1
    hang_log 1000000000
    submit 4
    check "a worker whose log hangs works on" await_state "$id" finished 30
    hang_log 0
    serve_stop
fi
tap_done
