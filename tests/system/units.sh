#!/usr/bin/env bash
# The systemd units as they are installed: systemd finds no fault with them, they are as shut off as docs/operating.md says,
# and every option that they name is one.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/units.sh BUILD_DIR}
. tests/tap.bash
prefix=$tmp/prefix units=$tmp/prefix/lib/systemd/system
mkdir -p "$prefix/bin" "$prefix/share/doc/shearwater/docs"
for program in shearwater shearwater-worker; do cp "$build/$program" "$prefix/bin/"; done
touch "$prefix/share/doc/shearwater/docs/operating.md"
check "the units are installed" make -s install-units PREFIX="$prefix" DESTDIR=
check "no place is left open in them" bash -c "! grep -n '@prefix@' '$units'/*"
options() { # options UNIT PROGRAM [COMMAND]: each is in the program's help
    local option; local help; help=$("$build/$2" ${3:+$3} --help)
    for option in $(grep '^ExecStart=' "$units/$1" | grep -o -- ' --[a-z-]*'); do
        grep -q -- "$option" <<<"$help" || { echo "$2 has no $option"; return 1; }
    done
}
check "the coordinator's options are there" options shearwater.service shearwater serve
check "the worker's options are there" options shearwater-worker@.service shearwater-worker
if ! command -v systemd-analyze >/dev/null; then
    skip "systemd finds no fault" "systemd-analyze is not installed"
    tap_done
fi
quiet() { local out; out=$(systemd-analyze "$@" 2>&1); local status=$?; [ $status = 0 ] && ! grep -F "$units" <<<"$out" || { echo "$out"; return 1; }; }
# Exposure of at most 1.2 of 10, in tenths.
# A port would be read as an alias here.
for unit in shearwater.service shearwater-worker@.service; do
    instance=${unit/@/@render-1.example}
    [ "$unit" = "$instance" ] || cp "$units/$unit" "$units/$instance"
    check "$unit: systemd finds no fault" quiet verify --man=no "$units/$instance"
    check "$unit: it is shut off" quiet security --offline=yes --threshold=12 --no-pager "$units/$instance"
    sed -i '/^SystemCallFilter/d; /^NoNewPrivileges/d; /^DynamicUser/d' "$units/$instance"
    check "$unit: less would be noticed" bash -c "! systemd-analyze security --offline=yes --threshold=12 --no-pager '$units/$instance'"
done
tap_done
