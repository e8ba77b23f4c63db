#!/usr/bin/env bash
# What holds of every scene: those of the corpus, those of 20 seeds (make property runs=N for more), and that scenes
# with numbers that are not finite are refused with their place.
#   tests/system/property.sh BUILD_DIR
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/property.sh BUILD_DIR}
. tests/tap.bash
properties=$build/tests/property/properties

# of NAME COMMAND...: one test for each of another program's.
of() {
    local name=$1 line; shift
    "$@" >"$tmp/of" 2>&1
    while read -r line; do
        case $line in
        ok*) check "$name: ${line#*- }" true ;;
        'not ok'*) check "$name: ${line#*- }" false ;;
        '#'*) echo "$line" ;;
        esac
    done <"$tmp/of"
    check "$name: ends as it says" grep -q '^1\.\.[1-9]' "$tmp/of"
}
of corpus "$properties" corpus=tests/property/cases runs=0
# The same seeds everywhere, however slow the machine is; among these each property has cases.
of seeds "$properties" runs=20 seed=14
of refused node tests/property/refused.mjs "$build" runs=12

# A case that fails is made simpler and can be run again.
cat >"$tmp/wrong.case" <<'C'
image 4 4 tile 16 block 32 layers 0
no line of a case
C
check "what is no case is refused with its line" bash -c "'$properties' case='$tmp/wrong.case' | grep -q 'line 2 is no line of a case'"
check "an unknown word is refused" bash -c "! '$properties' something=1 2>/dev/null"
tap_done
