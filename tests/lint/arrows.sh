#!/usr/bin/env bash
# The include arrows between the rooms. TAP; one test a rule.
set -uo pipefail
cd "$(dirname "$0")/../.."
n=0 status=0

# rule TEXT FILES... -- PATTERN : no file may include what the pattern names
rule() {
    local text=$1; shift
    local files=()
    while [ "$1" != -- ]; do files+=("$1"); shift; done
    n=$((n + 1))
    local found
    found=$(grep -nE "^[[:space:]]*#[[:space:]]*include[[:space:]]*[\"<]($2)" /dev/null "${files[@]}" 2>/dev/null)
    if [ -z "$found" ]; then echo "ok $n - $text"
    else echo "not ok $n - $text"; sed 's/^/# /' <<<"$found"; status=1; fi
}
# order TEXT ROOMS... : a room may include those before it only
order() {
    local text=$1; shift
    while [ $# -gt 0 ]; do
        local room=$1; shift
        [ $# -gt 0 ] || break
        local files later
        mapfile -t files < <(sources "$room")
        later=$(IFS='|'; echo "$*")
        rule "$text: $room" "${files[@]}" -- "($later)/"
    done
}
sources() { find "$1" \( -name '*.[ch]' -o -name '*.def' \) "${@:2}"; }

mapfile -t proto < <(sources proto)
mapfile -t film < <(sources server/film)
mapfile -t ground < <(sources server/reconstruct/patch; sources server/reconstruct/simd)
mapfile -t fields < <(for d in shadow indirect lens; do sources server/reconstruct/$d; done)
mapfile -t formats < <(sources server/image)
mapfile -t proto_alone < <(sources proto -not -path 'proto/runtime/*' -not -name log_writer.c)
mapfile -t worker < <(sources worker)
mapfile -t server < <(sources server)
mapfile -t planes < <(for d in server/reconstruct server/image server/film; do sources $d; done)
mapfile -t below_http < <(sources server -not -path 'server/http/*' -not -path 'server/cli/*')
mapfile -t no_embree < <(find proto server worker -name '*.[ch]' -not -path 'worker/trace/*' -not -path 'worker/scene/*')
mapfile -t no_mhd < <(find proto server worker -name '*.[ch]' -not -path 'server/http/*' -not -path 'server/stream/*')
mapfile -t no_sqlite < <(find proto server worker -name '*.[ch]' -not -path 'server/store/*')
mapfile -t no_assimp < <(find proto server worker -name '*.[ch]' -not -path 'server/import/*')

rule "proto includes neither worker nor server" "${proto[@]}" -- '(worker|server)/'
rule "worker does not include server" "${worker[@]}" -- 'server/'
rule "server does not include worker" "${server[@]}" -- 'worker/'
rule "proto has no sockets, loop or threads, but its runtime's and the log's" "${proto_alone[@]}" -- '(uv\.h|sys/socket\.h|pthread\.h|microhttpd\.h)'
rule "reconstruct, image and film know no sockets, jobs or JSON" "${planes[@]}" -- \
     '(uv\.h|sys/socket\.h|jansson\.h|microhttpd\.h|proto/(job/|link/|json\.h)|server/(job|http|fleet|stream|store|cli)/)'
rule "film knows patches, and no filter" "${film[@]}" -- \
     'server/reconstruct/([a-z_]+\.h|(simd|shadow|indirect|glossy|lens|lighting|compose)/)'
rule "patches and vectors know no filter" "${ground[@]}" -- \
     'server/(film|image)/|server/reconstruct/([a-z_]+\.h|(shadow|indirect|glossy|lens|lighting|compose)/)'
rule "filters of shadows, indirect light and lenses know no composition" "${fields[@]}" -- \
     'server/(film|image)/|server/reconstruct/([a-z_]+\.h|(lighting|compose)/)'
rule "readers and writers of pictures do not judge them" "${formats[@]}" -- 'server/compare/'
rule "nothing but the command line calls into http" "${below_http[@]}" -- 'server/http/'
rule "Embree is included by worker/trace and worker/scene only" "${no_embree[@]}" -- 'embree'
rule "libmicrohttpd is included by http and stream only" "${no_mhd[@]}" -- 'microhttpd'
order "proto's rooms stand on its runtime" proto/runtime proto/log proto/scene proto/job proto/link
order "in a worker, arrows go from shading up to the session" \
      worker/shade worker/scene worker/trace worker/tile worker/session worker/replay
order "tracing goes from hits to fields" \
      worker/trace/hit worker/trace/light worker/trace/path worker/trace/field
rule "SQLite is included by store only" "${no_sqlite[@]}" -- 'sqlite'
rule "assimp is included by import only" "${no_assimp[@]}" -- 'assimp'

# Every include from one folder to another, sorted by what needs what; tsort names the folders of a circle.
n=$((n + 1))
circles=$(grep -rHoE '^[[:space:]]*#[[:space:]]*include "(proto|server|worker)/[^"]+' proto server worker --include='*.[ch]' --include='*.def' |
    sed -E 's|/[^/]*:[^"]*"| |; s|/[^/]*$||' | awk '$1 != $2' | sort -u | tsort 2>&1 >/dev/null)
if [ -z "$circles" ]; then echo "ok $n - no folders include each other in a circle"
else echo "not ok $n - no folders include each other in a circle"; sed 's/^/# /' <<<"$circles"; status=1; fi

n=$((n + 1))
crowded=$(git ls-files 2>/dev/null | grep -vE '^(proto|tests)/' | sed -n 's|/[^/]*$||p' | sort | uniq -c | awk '$1 > 45')
if [ -z "$crowded" ]; then echo "ok $n - no folder holds more than 45 files"
else echo "not ok $n - no folder holds more than 45 files"; sed 's/^/# /' <<<"$crowded"; status=1; fi

n=$((n + 1))
drawers=$(git ls-files 2>/dev/null | grep -E '(^|/)(common|utils?|misc|helpers?)(/|\.)' || true)
if [ -z "$drawers" ]; then echo "ok $n - no drawers without a noun"
else echo "not ok $n - no drawers without a noun: $drawers"; status=1; fi
echo "1..$n"
exit $status
