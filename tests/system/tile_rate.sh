#!/usr/bin/env bash
# The coordinator's bookkeeping keeps its pace: a small run of tests/load/tile_rate.mjs, with its bound.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/tile_rate.sh BUILD_DIR}
. tests/tap.bash
most=$((6 * ${TEST_SLOWER:-1}))
check "a tile costs the coordinator at most $most times what it costs the workers" node tests/load/tile_rate.mjs "$build" "most=$most"
check "a ratio that nobody reaches is missed" bash -c "! node tests/load/tile_rate.mjs '$build' runs=1 most=0.01"
tap_done
