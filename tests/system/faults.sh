#!/usr/bin/env bash
# Writes, fsyncs, renames and allocations that fail, a full disk, a clock that jumps: a sample of what
# `make faults` walks over, about the same one every time unless a seed is given. See tests/load/faults.mjs.
#   tests/system/faults.sh BUILD_DIR [seed=N]
cd "$(dirname "$0")/../.." || exit 1
build=${1:?usage: tests/system/faults.sh BUILD_DIR}
if nm "$build/shearwater" | grep -q __[at]san_init; then
    echo "ok 1 - faults of the machine below # SKIP a sanitizer's allocator cannot be preloaded before"
    echo "1..1"
    exit
fi
shift
exec node tests/load/faults.mjs "$build" seed=12 "$@"
