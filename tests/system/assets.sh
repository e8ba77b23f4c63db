#!/usr/bin/env bash
# Assets that are given up: whose they are, who keeps them, what goes with them, and that nothing is
# lost where jobs, uploads and crashes come between.
#   tests/system/assets.sh BUILD_DIR
cd "$(dirname "$0")/../.." || exit 1
build=${1:?usage: tests/system/assets.sh BUILD_DIR}
if ! command -v node >/dev/null; then
    echo "ok 1 - assets that are given up # SKIP needs node"
    echo "1..1"
    exit
fi
exec node tests/system/assets.mjs "$@"
