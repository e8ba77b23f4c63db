#!/usr/bin/env bash
# The coordinator's bookkeeping keeps its pace: a small run of tests/load/tile_rate.mjs, with a quarter of its
# bound: others may use the machine's memory bus meanwhile, and on virtual machines where a page fault costs
# several times as much the same program comes to half of what it does elsewhere. Sanitizers take their share.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/tile_rate.sh BUILD_DIR}
. tests/tap.bash
least=$((1250 / ${TEST_SLOWER:-1}))
check "$least tiles of 64x64 a second of the coordinator's CPU time" node tests/load/tile_rate.mjs "$build" side=4096 runs=3 "least=$least"
check "a rate that nobody reaches is missed" bash -c "! node tests/load/tile_rate.mjs '$build' side=4096 runs=1 least=1e9"
tap_done
