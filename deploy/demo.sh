#!/usr/bin/env bash
# make demo: one shipped scene through a real coordinator and a real worker.
set -euo pipefail
build=${1:?usage: deploy/demo.sh BUILD_DIR}
cd "$(dirname "$0")/.."
"$build/shearwater" render tests/scenes/grey-white-room/job.json -o demo.exr --png demo.png
cat <<E

Wrote demo.exr (layers: exrheader demo.exr) and demo.png.
To watch renders in a browser:
  $build/shearwater serve                       then open http://127.0.0.1:8040/
  $build/shearwater submit tests/scenes/grey-white-room/job.json
E
