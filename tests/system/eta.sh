#!/usr/bin/env bash
# The time left of a real job: even work, several frames, and targets, each judged as a whole. Every event tells a range,
# and those of jobs without a filtered target a time. Other work on the machine changes what is right, so most of what was
# told must be, not all; unit/server/job/test_pace judges every figure.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/eta.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
command -v node >/dev/null || { skip "the time left is told" "needs node"; tap_done; exit; }

serve_start "$tmp/data" --workers 1 --worker-threads 1 || exit 1
told() { # told NAME MEMBERS TIMES, of which jq says whether there are enough
    local id
    id=$(submit "$2") || return 1
    no_proxy=127.0.0.1 node tests/system/eta.mjs "$url" "$id" >"$tmp/$1.eta" || return 1
    cat "$tmp/$1.eta"
    jq -e ".events > 4 and .ranged == .events and .within >= 0.8 * .events and .right >= 0.6 * .told and ($3)" "$tmp/$1.eta"
}
check "from the tenth per cent on a job tells its time left, mostly right within a third" \
    told even '"image": {"width": 720, "height": 720}, "sampling": {"spp": 25}' '.told == .events'
check "... and so does one of several frames" \
    told frames '"image": {"width": 360, "height": 360}, "sampling": {"spp": 16}, "frames": {"first": 1, "last": 5}' '.told == .events'
check "... and one with a target, of plain paths, whose rounds follow from their errors" \
    told plain '"image": {"width": 400, "height": 400}, "filter": {"method": "none"}, "effects": {"indirect_bounces": 4},
               "sampling": {"spp": 4, "target_error": 0.04}' '.told >= 0.7 * .events'
check "... and one of filtered paths, which tells a time once it is sure" \
    told filtered '"image": {"width": 400, "height": 400}, "effects": {"indirect_bounces": 4},
                  "sampling": {"spp": 4, "target_error": 0.01}' '.told >= 0.2 * .events'
serve_stop
tap_done
