#!/usr/bin/env bash
# Fifty kills of random processes, and every accepted job is finished as if there had been none.
# `make storm kills=1000` is for more.
#   tests/system/storm.sh BUILD_DIR [kills=N] [seed=N]
cd "$(dirname "$0")/../.." && exec node tests/load/storm.mjs "${@:?usage: tests/system/storm.sh BUILD_DIR}"
