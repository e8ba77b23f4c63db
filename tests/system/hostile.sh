#!/usr/bin/env bash
# Hostile HTTP while healthy clients ask: right answers, p99 of healthy requests, memory. Figures are
# printed; tests/system/hostile.mjs has the attacks. Deadlines are shorter than usual, to be seen.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/hostile.sh BUILD_DIR}
. tests/tap.bash
command -v node >/dev/null || { skip "hostile clients" "needs node"; tap_done; }
ulimit -n 16384 2>/dev/null || ulimit -n "$(ulimit -Hn)"
if [ "$(ulimit -n)" -lt 8192 ]; then skip "hostile clients" "needs 8192 descriptors"; tap_done; fi
export SHEARWATER_REQUEST_MS=2000 SHEARWATER_UPLOAD_MS=5000
crashes_expected # of an importer, in a library
serve_start "$tmp/data" --workers 1 --worker-threads 1 || { echo "Bail out! the server did not start"; exit 1; }
node tests/system/hostile.mjs "$url" "$server_pid" "$SHEARWATER_REQUEST_MS" >"$tmp/hostile.tap" 2>&1
status=$?
grep -E '^#|Error' "$tmp/hostile.tap" | sed 's/^#* */# /'
while IFS='|' read -r verdict text; do
    passed() { [ "$verdict" = ok ]; }
    check "$text" passed
done < <(grep -E '^(not )?ok ' "$tmp/hostile.tap" | sed -E 's/^((not )?ok) [0-9]+ - /\1|/')
ran() { [ $status = 0 ] && grep -qE '^1\.\.[0-9]+$' "$tmp/hostile.tap"; }
check "all of it was tried, and the server stands" ran
check "... and ends in order" serve_stop
tap_done
