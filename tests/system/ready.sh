#!/usr/bin/env bash
# A coordinator that was killed serves again within 2 s with 10,000 jobs queued.
#   tests/system/ready.sh BUILD_DIR
cd "$(dirname "$0")/../.." && exec node tests/load/ready.mjs "${1:?usage: tests/system/ready.sh BUILD_DIR}"
