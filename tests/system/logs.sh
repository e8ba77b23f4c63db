#!/usr/bin/env bash
# The server's log as a program reads it: every line is an object, and a request, the job that it
# submitted and what became of that are found by one id, which the caller may have given.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/logs.sh BUILD_DIR}
. tests/tap.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
http() { curl -sS --noproxy '*' --max-time 20 "$@"; }
is() { [ "$1" = "$2" ] || { echo "$1, not $2"; return 1; }; }
header() { sed -n "s/^$1: //Ip" "$tmp/head" | tr -d '\r'; }
lines() { jq -c "$@" "$log"; }
has() { # has FILTER: some line of the log, soon
    local end=$((SECONDS + 5))
    until lines "select($1)" | grep -q .; do
        [ $SECONDS -lt $end ] || { echo "no line with $1"; tail -n 5 "$log"; return 1; }
        sleep 0.1
    done
}

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
port=$(lines -r 'select(.message == "serving").worker_port')
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
check "a format that is none is refused" bash -c "'$build/shearwater' serve --log-format xml 2>&1 | grep -q 'text and json'"
tap_done
