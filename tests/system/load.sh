#!/usr/bin/env bash
# The load test, small and with loose bounds: that each of its parts works and measures.
#   tests/system/load.sh BUILD_DIR
cd "$(dirname "$0")/../.." && exec node tests/load/load.mjs "${1:?usage: tests/system/load.sh BUILD_DIR}" \
    fair_s=6 fair_jobs=40 fair_within=0.1
