#!/usr/bin/env bash
# The coordinator's bookkeeping keeps its pace: a small run of tests/load/tile_rate.mjs, with half its
# bound, since others may use the machine's memory bus meanwhile.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/tile_rate.sh BUILD_DIR}
. tests/tap.bash
check "2,500 tiles of 64x64 a second of the coordinator's CPU time" node tests/load/tile_rate.mjs "$build" side=4096 runs=3 least=2500
check "a rate that nobody reaches is missed" bash -c "! node tests/load/tile_rate.mjs '$build' side=4096 runs=1 least=1e9"
tap_done
