#!/usr/bin/env bash
# tests/fuzz/smoke.sh BUILD_DIR: every fuzz target over its corpus and the neighbours of each input,
# without a fuzzer. One TAP line a target. For real fuzzing: make fuzz seconds=60.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/fuzz/smoke.sh BUILD_DIR}
out=$build/fuzz/replay
mkdir -p "$out"
targets=(tests/fuzz/fuzz_*.c)
echo "1..${#targets[@]}"
n=0 status=0
for source in "${targets[@]}"; do
    n=$((n + 1))
    name=${source##*/fuzz_} name=${name%.c}
    log=$out/$name.log
    mapfile -t inputs < <(find "tests/fuzz/corpus/$name" -type f 2>/dev/null | LC_ALL=C sort)
    sources=$(sed -n 's|^// sources: ||p' "$source")
    archives=$(sed -n "s|^// archives: |$build/|p" "$source")
    libs=$(sed -n 's|^// libs: ||p' "$source")
    # shellcheck disable=SC2086 # they are several words, sources with patterns among them
    if ! ${CC:-gcc} -std=c17 -D_GNU_SOURCE -O1 -g -march=x86-64-v2 -ffp-contract=off -I. -I"$build" \
        "$source" tests/fuzz/replay.c $sources $archives "$build/libproto.a" -o "$out/$name" \
        $libs -lblosc -lgnutls -lnettle -ljansson -lisal -lm -lpthread >"$log" 2>&1; then
        echo "not ok $n - fuzz $name does not build"
    elif [ ${#inputs[@]} -eq 0 ]; then
        echo "not ok $n - fuzz $name has no corpus in tests/fuzz/corpus/$name"
    elif "$out/$name" "${inputs[@]}" >"$log" 2>&1; then
        echo "ok $n - fuzz $name: ${#inputs[@]} inputs and their neighbours"
        continue
    else
        echo "not ok $n - fuzz $name fails after $(grep -c '^ok' "$log") inputs, log $log"
    fi
    tail -5 "$log" | sed 's/^/# /'
    status=1
done
exit $status
