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
sources() { find "$1" \( -name '*.[ch]' -o -name '*.def' \) "${@:2}"; }

mapfile -t proto < <(sources proto)
mapfile -t proto_alone < <(sources proto -not -name log_writer.c)
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
rule "proto has no sockets, loop or threads, but the log's" "${proto_alone[@]}" -- '(uv\.h|sys/socket\.h|pthread\.h|microhttpd\.h)'
rule "reconstruct, image and film know no sockets, jobs or JSON" "${planes[@]}" -- \
     '(uv\.h|sys/socket\.h|jansson\.h|microhttpd\.h|proto/(job|json|message|frame)\.h|server/(job|http|fleet|stream|store|cli)/)'
rule "nothing but the command line calls into http" "${below_http[@]}" -- 'server/http/'
rule "Embree is included by worker/trace and worker/scene only" "${no_embree[@]}" -- 'embree'
rule "libmicrohttpd is included by http and stream only" "${no_mhd[@]}" -- 'microhttpd'
rule "SQLite is included by store only" "${no_sqlite[@]}" -- 'sqlite'
rule "assimp is included by import only" "${no_assimp[@]}" -- 'assimp'

n=$((n + 1))
drawers=$(git ls-files 2>/dev/null | grep -E '(^|/)(common|utils?|misc|helpers?)(/|\.)' || true)
if [ -z "$drawers" ]; then echo "ok $n - no drawers without a noun"
else echo "not ok $n - no drawers without a noun: $drawers"; status=1; fi
echo "1..$n"
exit $status
