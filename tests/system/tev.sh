#!/usr/bin/env bash
# shearwater watch --tev, against a scripted tev.
cd "$(dirname "$0")/../.."
command -v node >/dev/null || { echo "ok 1 - pictures go to tev # SKIP node is not installed"; echo "1..1"; exit 0; }
exec node tests/system/tev.mjs "${1:?usage: tests/system/tev.sh BUILD_DIR}"
