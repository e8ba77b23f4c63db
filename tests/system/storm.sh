#!/usr/bin/env bash
# Fifty kills of random processes, and every accepted job is finished as if there had been none. Unless a seed is
# given, kinds of kills and jobs come in the same order every time; `make storm kills=1000` is for more.
#   tests/system/storm.sh BUILD_DIR [kills=N] [seed=N]
cd "$(dirname "$0")/../.." || exit 1
build=${1:?usage: tests/system/storm.sh BUILD_DIR}
shift
exec node tests/load/storm.mjs "$build" seed=5 pause_ms=200 "$@"
