#!/usr/bin/env bash
# Nodes of a live job are moved, in a photograph: at rest the picture is an ordinary job's with the nodes
# there, what rests is not built again, and the newest of many moves wins. A group of an OBJ moves, too.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/moves.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash

serve_start "$tmp/data" --workers 2 || { echo "Bail out! the server did not start"; exit 1; }
moves() { node tests/system/moves.mjs "$url" "$build" "$tmp" >"$tmp/moves" 2>&1; }
moves
moved=$?
# Its lines are this program's own.
cat "$tmp/moves" | grep -E '^(not )?ok |^#'
tap_n=$(grep -cE '^(not )?ok ' "$tmp/moves")
tap_failed=$(grep -cE '^not ok ' "$tmp/moves")
check "all moves were tried" test "$moved" -eq 0
serve_stop
check "the server ends without a complaint" test $? -eq 0

cp tests/scenes/photograph/*.obj tests/scenes/photograph/*.mtl "$tmp/"
obj() {
    echo "{\"scene\": {\"file\": \"room-and-box.obj\", \"camera\": {\"eye\": [0, 1, 5], \"target\": [0, 1, 0], \"yfov_deg\": 28}, \"moves\": $2},
        \"image\": {\"width\": 32, \"height\": 32}, \"sampling\": {\"spp\": 4}, \"layers\": [\"beauty\", \"depth\"]}" >"$tmp/$1.json"
    render "$1" "$1"
}
check "a group of an OBJ is moved" obj there '[{"node": "box", "translation": [0, 5, 0]}]'
check "... out of the picture" eval 'obj here "[]" && ! cmp -s "$tmp/here.exr" "$tmp/there.exr"'
check "... all the way round it is where it was" eval 'obj round "[{\"node\": \"box\", \"rotation_deg\": 360}]" && [ "$(figure here round | jq ".rmse < 0.01")" = true ]'
check "a group that is not there is refused" eval '! obj nobody "[{\"node\": \"nobody\"}]" 2>"$tmp/said"; cat "$tmp/said"; grep -q "/scene/moves/0/node" "$tmp/said"'
tap_done
