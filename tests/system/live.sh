#!/usr/bin/env bash
# Live jobs on the real server with two workers: their camera is moved, over the feed nothing of an
# older view is heard, the picture at rest is an ordinary job's, and a restart goes on with the newest
# camera. Prints the time from a move to its first block.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/live.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash

serve_start "$tmp/data" --workers 2 || { echo "Bail out! the server did not start"; exit 1; }
moves() { node tests/system/live.mjs "$url" "$build" "$tmp" >"$tmp/moves" 2>&1; }
moves
moved=$?
# Its lines are this program's own.
grep -E '^(not )?ok |^#' "$tmp/moves"
tap_n=$(grep -cE '^(not )?ok ' "$tmp/moves")
tap_failed=$(grep -cE '^not ok ' "$tmp/moves")
check "all moves were tried" test "$moved" -eq 0
id=$(cat "$tmp/live-id" 2>/dev/null)

# A restart: the newest camera, at a view with a larger number.
camera='{"eye":[1.5,1.25,3],"target":[0,1,0],"up":[0,1,0],"yfov_deg":50.0}'
move() { http -X PATCH -H 'Content-Type: application/json' -d "{\"camera\": $1}" "$url/v1/jobs/$id" >"$tmp/moved"; }
before() { jq .view.number "$tmp/moved"; }
same_camera() { http "$url/v1/jobs/$id" | jq -e --argjson c "$camera" '.document.scene.camera == $c'; }
larger_view() { http "$url/v1/jobs/$id" | jq -e --argjson n "$(before)" '.view.number > $n'; }
check "the camera is moved once more" move "$camera"
check "the job rests" await_state "$id" resting 60
http -o "$tmp/before.exr" "$url/v1/jobs/$id/frames/1/image.exr"
serve_stop KILL
SHEARWATER_LIVE_IDLE_MS=3000 serve_start "$tmp/data" --workers 2
check "after a kill the job comes to rest again" await_state "$id" resting 60
check "... with the newest camera" same_camera
check "... at a larger view" larger_view
http -o "$tmp/after.exr" "$url/v1/jobs/$id/frames/1/image.exr"
check "... and the same picture" cmp "$tmp/before.exr" "$tmp/after.exr"

# Nobody moves it any more.
check "a live job that is not moved any more ends" await_state "$id" finished 30
http -o "$tmp/finished.exr" "$url/v1/jobs/$id/frames/1/image.exr"
check "... with its files, which are the picture that it showed" cmp "$tmp/after.exr" "$tmp/finished.exr"
is_over() { [ "$(http -o "$tmp/body" -w '%{http_code}' -X PATCH -H 'Content-Type: application/json' -d "{\"camera\": $camera}" "$url/v1/jobs/$id")" = 409 ]; }
check "... and cannot be moved" is_over
serve_stop
check "the server ends without a complaint" test $? -eq 0
tap_done
