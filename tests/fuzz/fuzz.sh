#!/usr/bin/env bash
# tests/fuzz/fuzz.sh BUILD_DIR SECONDS: every target under libFuzzer for so long, a TAP line each; see
# tests/fuzz/run. What CI does; `make test` alone replays the corpora (smoke.sh), which needs no clang.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/fuzz/fuzz.sh BUILD_DIR SECONDS}
seconds=${2:?usage: tests/fuzz/fuzz.sh BUILD_DIR SECONDS}
targets=(tests/fuzz/fuzz_*.c)
echo "1..${#targets[@]}"
env -u ASAN_OPTIONS -u UBSAN_OPTIONS tests/fuzz/run "$build" "$seconds" | while IFS= read -r line; do
    case $line in
    *": passed, "*) echo "ok - fuzz $line" ;;
    *": FAILED "* | *": NOT BUILT"*) echo "not ok - fuzz $line" ;;
    *) echo "# $line" ;;
    esac
done
