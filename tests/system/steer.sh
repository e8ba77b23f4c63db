#!/usr/bin/env bash
# Steering jobs: pause and resume, also over a restart, priority, a region and a point that go first,
# If-Match; and that none of it changes a byte of what comes of a job.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/steer.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
steer() { "$build/shearwater" steer "$1" --server "$url" "${@:2}"; }
patch() { # patch ID DOCUMENT CURL-ARGUMENTS...: prints the status; the body goes to $tmp/body
    http -o "$tmp/body" -w '%{http_code}' -X PATCH -H 'Content-Type: application/json' -d "$2" "${@:3}" "$url/v1/jobs/$1"
}
# Tiles in several passes.
of() { echo '"image": {"width": '"$1"', "height": '"$1"'}, "sampling": {"spp": '"$2"', "tile_px": 32}, "filter": {"method": "none"}'; }
medium=$(of 288 32) part=$(of 256 16)
# Some seconds' worth: events, ten a second, tell of the first 40 tiles by themselves.
long=$(of 384 $((slower == 1 ? 56 : 36)))
short='"image": {"width": 128, "height": 128}, "sampling": {"spp": 16, "tile_px": 32}'

start
undisturbed=$(submit "$medium")
check "the undisturbed job finishes" await_state "$undisturbed" finished 180
exr "$undisturbed" "$tmp/undisturbed.exr"

# Pause.
job=$(submit "$medium")
check "a job has begun" eventually 60 has_landed "$job" 11
check "shearwater steer pauses it, and says so" is "$(steer "$job" --pause)" "$job: running, paused, priority 0"
check "tiles under way land" eventually 30 workers_empty
at_rest=$(get "$job" | jq -c '[.state, .paused, .progress]')
sleep 1.5
check "then nothing goes on" is "$(get "$job" | jq -c '[.state, .paused, .progress]')" "$at_rest"
check "it shows no time left" shows "$job" '.progress | .eta_s == null and .eta_range_s == null'
other=$(submit "$short")
check "its workers are another's" await_state "$other" finished 60
check "... and it has stayed where it was" is "$(get "$job" | jq -c '[.state, .paused, .progress]')" "$at_rest"

# If-Match: a paused job keeps its tag.
http -D "$tmp/head" -o /dev/null "$url/v1/jobs/$job"
tag=$(sed -n 's/^ETag: //Ip' "$tmp/head" | tr -d '\r')
check "a job at rest keeps its tag" is "$(http -o /dev/null -w '%{http_code}' -H "If-None-Match: $tag" "$url/v1/jobs/$job")" 304
check "the right tag lets through" is "$(patch "$job" '{"priority": 5}' -H "If-Match: $tag")" 200
check "... and the answer shows it" jq -e '.priority == 5 and .paused and .document.priority == 0' "$tmp/body"
check "the tag of before is stale" is "$(patch "$job" '{"priority": 6}' -H "If-Match: $tag")" 412
check "... with a problem" jq -e '.type | endswith("precondition-failed")' "$tmp/body"
check "... and nothing was changed" shows "$job" '.priority == 5'
check "a weak tag matches nothing" is "$(patch "$job" '{"priority": 6}' -H "If-Match: W/$tag")" 412
# Of many that saw the same, one gets through.
http -D "$tmp/head" -o /dev/null "$url/v1/jobs/$job"
tag=$(sed -n 's/^ETag: //Ip' "$tmp/head" | tr -d '\r')
racers=()
for i in 1 2 3 4 5 6 7 8; do racers+=(--next -sS --noproxy '*' --max-time 30 -o /dev/null -w '%{http_code}\n' -X PATCH -H 'Content-Type: application/json' -H "If-Match: $tag" -d "{\"priority\": 1$i}" "$url/v1/jobs/$job"); done
curl --parallel --parallel-immediate "${racers[@]:1}" >"$tmp/statuses"
check "of eight changes at once with one tag one is made" is "$(sort "$tmp/statuses" | uniq -c | xargs)" "1 200 7 412"
check "any tag is the job's" is "$(patch "$job" '{"priority": 6}' -H 'If-Match: *')" 200

# A restart while it is paused.
serve_stop KILL
start
check "after a crash it is still paused" shows "$job" '.paused and .priority == 6'
other=$(submit "$short")
check "others are served" await_state "$other" finished 60
check "... it is not" shows "$job" '.paused and .state != "finished" and .progress.fraction == 0'
check "steer resumes it" steer "$job" --resume
check "it finishes" await_state "$job" finished 180
exr "$job" "$tmp/paused.exr"
check "byte by byte as if undisturbed" cmp "$tmp/undisturbed.exr" "$tmp/paused.exr"
check "an ended job is steered no more" is "$(patch "$job" '{"paused": true}')" 409
check "... nor paused" shows "$job" '.paused | not'

# Frames that are finished stay so over a restart in a pause.
frames=$(submit "$part, \"frames\": \"1-7x2\"")
check "a job of four frames has finished one" eventually 120 shows "$frames" '.progress.frames_done >= 1'
steer "$frames" --pause >/dev/null
eventually 30 workers_empty
settled number "$frames" '[.frames[].state]'
done_before=$(get "$frames" | jq '[.frames[] | select(.state == "finished")] | length')
exr "$frames" "$tmp/first.exr" 1
serve_stop
start
check "its finished frames are there while it is paused" is "$(get "$frames" | jq '[.frames[] | select(.state == "finished")] | length')" "$done_before"
check "... and are what its progress tells" shows "$frames" ".paused and .progress.frames_done == $done_before and .progress.frames_total == 4 and .progress.fraction == $done_before / 4"
steer "$frames" --resume >/dev/null
check "it goes on with the others" await_state "$frames" finished 180
check "... of which each is traced once" shows "$frames" ".statistics.tiles.done == .progress.tiles_total and .progress.frames_done == 4"
exr "$frames" "$tmp/first-again.exr" 1
check "... and the first is the file of before" cmp "$tmp/first.exr" "$tmp/first-again.exr"

# Many paused jobs leave room for others. Twelve keep their tiles; one more begins anew when it goes on.
parked=()
for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13; do
    one=$(submit "$medium, \"priority\": 20")
    pause_at "$one" 5
    parked+=("$one")
done
other=$(submit "$short")
check "thirteen paused jobs stop nobody" await_state "$other" finished 60
check "the first keep their tiles" shows "${parked[11]}" '.progress.tiles_done > 4'
check "the last has given its memory back" shows "${parked[12]}" '.paused and .progress.tiles_done == 0'
check "a paused job can be cancelled" "$build/shearwater" cancel "${parked[0]}" --server "$url"
check "... and is" await_state "${parked[0]}" cancelled 30
check "... for good" is "$(patch "${parked[0]}" '{"paused": false}')" 409
steer "${parked[12]}" --resume >/dev/null
check "the last finishes when it goes on" await_state "${parked[12]}" finished 180
exr "${parked[12]}" "$tmp/parked.exr"
check "... byte by byte as if undisturbed" cmp "$tmp/undisturbed.exr" "$tmp/parked.exr"
for one in "${parked[@]:1}"; do http -o /dev/null -X DELETE "$url/v1/jobs/$one?purge=1"; done

# Priority: who is raised overtakes who runs, who is lowered waits.
first=$(submit "$medium")
check "the first runs" eventually 60 has_landed "$first" 21
second=$(submit "$part")
steer "$second" --priority 10 >/dev/null
check "a job that is raised overtakes" await_state "$second" finished 120
check "... the other goes on after it" shows "$first" '.state == "running"'
steer "$first" --priority -5 >/dev/null
second=$(submit "$part")
check "a job that is lowered is overtaken" await_state "$second" finished 120
check "... and its place is on disk" shows "$first" '.priority == -5 and .state == "running"'

# Viewers are told at once.
timeout 30 curl -sSN --noproxy '*' "$url/v1/jobs/$first/events" >"$tmp/events" &
listener=$!
eventually 5 grep -q "^event:" "$tmp/events"
steer "$first" --pause --priority 3 >/dev/null
told() { awk '/^event: /{e = $2} /^data: / && e == "state" {print substr($0, 7)}' "$tmp/events" | jq -e 'select(.paused and .priority == 3)'; }
check "a state event tells of it" eventually 10 told # before the feed says that it still lives
kill $listener 2>/dev/null
http -o /dev/null -X DELETE "$url/v1/jobs/$first?purge=1"

# A region goes first: a job is paused before its first tile, told what to begin with, and let go.
hold=$(submit "$long, \"priority\": 50")
eventually 60 has_landed "$hold" 11
region=$(submit "$long")
eventually 60 shows "$region" '.state == "running"'
steer "$region" --pause --region 192,200,128x120 >/dev/null
http -o /dev/null -X DELETE "$url/v1/jobs/$hold?purge=1"
check "a region is shown" shows "$region" '.region == {"x": 192, "y": 200, "width": 128, "height": 120} and .progress.tiles_done == 0'
timeout 90 curl -sSN --noproxy '*' "$url/v1/jobs/$region/events" >"$tmp/events" &
listener=$!
eventually 5 grep -q "^event:" "$tmp/events"
steer "$region" --resume >/dev/null
# Tile events are a sample of those that landed, each with the count of them behind it. The region's
# 16 tiles, several passes each, come first: none from elsewhere lands among the first 40, as many as there would be if a
# worker slept on all that it was given.
told() { awk '/^event: /{e = $2} /^data: / && (e == "tile" || e == "progress") {print substr($0, 7)}' "$tmp/events" | jq -se "$1"; }
elsewhere='(.x < 192 or .y < 192 or .x >= 320 or .y >= 320)'
check "others come, too" eventually 90 told "any(.[] | select(.x); $elsewhere)"
kill $listener 2>/dev/null
counted='[.[:-1], .[1:]] | transpose | map(select(.[0].x and .[1].tiles_done <= 40) | .[0])'
check "... after the region's" told "$counted | length > 0 and (any(.[]; $elsewhere) | not)"
steer "$region" --pause >/dev/null
eventually 30 workers_empty

# Steered at random to its end: the bytes of the undisturbed.
RANDOM=20
steer "$region" --resume >/dev/null
steps=0
end=$((SECONDS + 40 * slower))
while [ $SECONDS -lt $end ] && [ "$(job_state "$region")" = running ]; do
    case $((RANDOM % 6)) in
    0) steer "$region" --pause; sleep 0.2; steer "$region" --resume ;;
    1) steer "$region" --priority $((RANDOM % 201 - 100)) ;;
    2) steer "$region" --region $((RANDOM % 192)),$((RANDOM % 192)),$((RANDOM % 192 + 1))x$((RANDOM % 192 + 1)) ;;
    3) steer "$region" --region none --near none ;;
    *) steer "$region" --near $((RANDOM % 384)),$((RANDOM % 384)) ;;
    esac >/dev/null 2>&1
    steps=$((steps + 1))
done
steer "$region" --resume >/dev/null 2>&1
check "a job steered at random finishes" await_state "$region" finished 180
check "... after many turns" test "$steps" -gt 15
exr "$region" "$tmp/steered.exr"
undisturbed=$(submit "$long")
check "... as one does that is not" await_state "$undisturbed" finished 180
exr "$undisturbed" "$tmp/undisturbed.exr"
check "... byte by byte" cmp "$tmp/undisturbed.exr" "$tmp/steered.exr"

# What the command line refuses.
refuses() { ! steer "$@" 2>"$tmp/refusal" && grep -q "$words" "$tmp/refusal"; }
words='give at least one change' check "nothing to change" refuses "$region"
words='exclude each other' check "both pause and resume" refuses "$region" --pause --resume
words='X,Y,WIDTHxHEIGHT' check "half a region" refuses "$region" --region 5,5
words='ended already' check "a job that has ended" refuses "$region" --pause
words='no such job' check "a job that is none" refuses 00000000000000000000000000 --pause
serve_stop
tap_done
