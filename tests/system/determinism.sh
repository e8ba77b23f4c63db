#!/usr/bin/env bash
# The bytes of a picture do not depend on who traced which part of it, when, how often, and in which
# pieces: a covering of all pairs of job, workers, threads, tile size, order of completion and block
# size. `make determinism` runs every combination.
#   tests/system/determinism.sh BUILD_DIR [all]
cd "$(dirname "$0")/../.." && exec node tests/system/determinism.mjs "${@:?usage: tests/system/determinism.sh BUILD_DIR [all]}"
