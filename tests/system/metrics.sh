#!/usr/bin/env bash
# /metrics: the format and the conventions to the letter, series that no client can make more of, and figures
# that say what happened.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/metrics.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
read_metrics() { node tests/system/metrics.mjs "$@"; }
scrape() { http -f -D "$tmp/head" -o "$tmp/$1" "$url/metrics"; }
value() { read_metrics value "$tmp/$1" "$2"; }
submit() { http -H 'Content-Type: application/json' -d "{\"scene\": {\"asset\": \"$asset\"}, $1}" "$url/v1/jobs" | jq -r .id; }

serve_start "$tmp/data" --workers 0 || { echo "Bail out! the server did not start"; exit 1; }
scrape fresh
check "a fresh server's figures are in order" read_metrics check "$tmp/fresh"
check "... and have their type" grep -qi '^content-type: text/plain; version=0.0.4; charset=utf-8' "$tmp/head"
asset=$(sha256sum <"$scene" | cut -c1-64)
http -T "$scene" -o "$tmp/body" "$url/v1/assets/$asset"
small='"image": {"width": 64, "height": 64}, "sampling": {"spp": 1, "tile_px": 32}, "filter": {"method": "none"}'
ids=()
for _ in 1 2 3; do ids+=("$(submit "$small")"); done
waits() { is "$(($(value waiting 'shearwater_jobs{state="queued"}') + $(value waiting 'shearwater_jobs{state="importing"}') + $(value waiting 'shearwater_jobs{state="running"}')))" 3; }
all_wait() { scrape waiting && waits; }
check "jobs that wait are counted by state" eventually 10 all_wait
stats() { is "$(http "$url/v1/stats" | jq "$1")" "$2"; }
wanted() { stats .threads_wanted "$1" && scrape "$2" && is "$(value "$2" shearwater_threads_wanted)" "$1"; }
for id in "${ids[@]}"; do http -o "$tmp/body" -X PATCH -H 'Content-Type: application/json' -d '{"paused": true}' "$url/v1/jobs/$id"; done
check "paused jobs want no thread" eventually 10 wanted 0 paused
for id in "${ids[@]}"; do http -o "$tmp/body" -X PATCH -H 'Content-Type: application/json' -d '{"paused": false}' "$url/v1/jobs/$id"; done
all_tiles_wait() { [ "$(http "$url/v1/stats" | jq '.tiles_waiting + .jobs_waiting')" -ge 4 ] && stats '.threads_wanted == .tiles_waiting + .jobs_waiting' true; }
check "tiles and jobs that wait want threads" eventually 10 all_tiles_wait
check "... as there is no worker" stats '[.workers, .threads, .tiles_leased] | add' 0
check "submissions are timed by route" is "$(value waiting 'shearwater_http_request_duration_seconds_count{method="POST",route="/v1/jobs"}')" 3
check "... and counted by status" is "$(value waiting 'shearwater_http_requests_total{method="POST",route="/v1/jobs",status="202"}')" 3
check "commits are timed" [ "$(value waiting shearwater_store_commit_duration_seconds_count)" -ge 1 ]
check "no commit failed" is "$(value waiting shearwater_store_commit_failures_total)" 0
watched() { scrape waiting && [ "$(value waiting shearwater_loop_delay_seconds_count)" -ge 1 ]; }
check "the loop is watched" eventually 10 watched
free() { local real; real=$(($(stat -f -c '%a * %S' "$tmp/data"))); local told; told=$(value waiting shearwater_data_free_bytes)
    [ $((told > real ? told - real : real - told)) -lt $((real / 4 + 100000000)) ]; }
check "the disk's room is that of the disk" free
check "the process is that of the server" is "$(value waiting process_max_fds)" "$(awk '/Max open files/ {print $4}' /proc/$server_pid/limits)"
check "it started when it did" bash -c "n=\$(($(date +%s) - $(value waiting process_start_time_seconds))); [ \$n -ge 0 ] && [ \$n -lt 120 ]"

# A second round of all that a client can make up finds its series there.
nonsense() {
    for i in $1-a $1-b $1-c; do
        http -o /dev/null "$url/v1/$i" "$url/$i.html" "$url/v1/jobs/$i" "$url/v1/jobs?state=$i" "$url/v1/assets/$i"
        http -o /dev/null -X "BREW${i//-/}" "$url/livez"
        http -o /dev/null -H "traceparent: $i" -H "X-Request-Id: $i" -H "User-Agent: $i" "$url/livez"
        http -o /dev/null -H "Host: $i" "$url/livez"
        http -o /dev/null "$url/v1/jobs/$(printf '%026d' "0x$(printf %s "$i" | sha256sum | cut -c1-6)")"
        http -o /dev/null -X DELETE "$url/v1/jobs/$(submit '"image": {"width": 32, "height": 32}, "sampling": {"spp": 1}')"
    done
}
nonsense first >"$tmp/answers"
scrape first; scrape first
nonsense second >"$tmp/answers"
scrape second
check "after nonsense the figures are in order" read_metrics check "$tmp/second"
check "nothing that clients send makes a series" read_metrics same "$tmp/first" "$tmp/second"
check "what met no route is counted" [ "$(value second 'shearwater_http_request_duration_seconds_count{method="none",route="none"}')" -gt "$(value first 'shearwater_http_request_duration_seconds_count{method="none",route="none"}')" ]

"$build/shearwater-worker" --connect "unix:$tmp/data/worker.sock" --threads 1 --cache "$tmp/data/cache" 2>"$tmp/worker.log" &
track $!
for id in "${ids[@]}"; do check "job $id finishes" await_state "$id" finished 60; done
check "when all is done no thread is wanted" eventually 10 wanted 0 done
check "... and the worker's is there" stats '[.workers, .threads] == [1, 1]' true
check "... in the figures, too" is "$(value done shearwater_worker_threads)" 1
all_done() { scrape done && is "$(value done shearwater_tiles_done_total)" 12; }
eventually 10 all_done
check "with work done the figures are in order" read_metrics check "$tmp/done"
check "no counter went back" read_metrics grows "$tmp/second" "$tmp/done"
check "all tiles are counted" is "$(value done shearwater_tiles_done_total)" 12
check "finished jobs are counted" is "$(value done 'shearwater_jobs_ended_total{state="finished"}')" 3
check "and none waits" is "$(value done 'shearwater_jobs{state="queued"}')" 0
check "the worker is counted" is "$(value done shearwater_workers)" 1
check "the loop's delays are a timer's: 4 a second" bash -c "
    n=$(value done shearwater_loop_delay_seconds_count) s=\$(($(date +%s) - $(value done process_start_time_seconds) + 1)); [ \$n -le \$((4 * s)) ] && [ \$n -ge \$s ]"

# The rules themselves: each figure spoilt is found.
spoilt() { sed "$1" "$tmp/done" >"$tmp/spoilt" && ! cmp -s "$tmp/done" "$tmp/spoilt" && ! read_metrics check "$tmp/spoilt"; }
check "the reader finds: no HELP" spoilt '/^# HELP shearwater_jobs /d'
check "... no TYPE" spoilt '/^# TYPE shearwater_jobs /d'
check "... a counter without its end" spoilt 's/shearwater_tiles_done_total/shearwater_tiles_done/'
check "... a scaled unit" spoilt 's/shearwater_spool_size_bytes/shearwater_spool_size_kb/'
check "... a label without bound" spoilt 's/{state="queued"}/{job="abc"}/'
check "... a series twice" spoilt 's/{state="importing"}/{state="queued"}/'
check "... buckets that do not add up" spoilt 's/\(shearwater_loop_delay_seconds_bucket{le="30"}\) .*/\1 0/'
check "... a count that is none of its buckets" spoilt 's/^shearwater_loop_delay_seconds_count .*/shearwater_loop_delay_seconds_count 1000000/'
check "... a family in two parts" spoilt '$a # HELP shearwater_jobs x y\n# TYPE shearwater_jobs gauge'
serve_stop
tap_done
