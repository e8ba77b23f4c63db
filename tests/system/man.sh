#!/usr/bin/env bash
# Man pages and completion are made from the programs' own options: nothing is missing, groff has no complaint, and what
# make install-man brings make uninstall takes away.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/man.sh BUILD_DIR}
. tests/tap.bash
root=$tmp/root pages=$tmp/root/usr/share/man/man1 completion=$tmp/root/usr/share/bash-completion/completions
programs=(shearwater shearwater-worker shearwater-import)
mapfile -t commands < <("$build/shearwater" --dump-options | awk -F '\t' '$1 == "command" {print $2}')

check "pages and completion are installed" make -s install-man B="$build" DESTDIR="$root" PREFIX=/usr
check "shearwater tells its commands" test "${#commands[@]}" -ge 10
each_page() { for p in "${programs[@]}" "${commands[@]/#/shearwater-}"; do [ -s "$pages/$p.1" ] || { echo "no $p.1"; return 1; }; done; }
check "each program and each command has a page" each_page

# lists PAGE PROGRAM [COMMAND]: the page has each option of --help, and no other.
lists() {
    diff <("$build/$2" ${3:+"$3"} --help | grep -oE '^ +(-.,)? +--[a-z-]+|^  -.,  *--[a-z-]+' | grep -oE -- '--[a-z-]+' | sort) \
         <(sed -n '/^\.SH OPTIONS/,$p' "$pages/$1.1" | sed 's/\\-/-/g; s/\\f.//g' | grep -oE '^(-., )?--[a-z-]+' | grep -oE -- '--[a-z-]+' | sort)
}
for program in shearwater-worker shearwater-import; do check "$program: the page has all options" lists "$program" "$program"; done
for command in "${commands[@]}"; do check "$command: the page has all options" lists "shearwater-$command" shearwater "$command"; done
hidden() { ! { "$build/shearwater" --help; "$build/shearwater" serve --help; "$build/shearwater-worker" --help; } | grep -q dump; }
check "--dump-options is no option for people" hidden

if command -v groff >/dev/null; then
    set_in_type() { local said; said=$(for p in "$pages"/*.1; do groff -man -ww -Tutf8 "$p" 2>&1 >/dev/null; done); [ -z "$said" ] || { echo "$said"; return 1; }; }
    check "groff has no warning" set_in_type
    reads() { groff -man -Tascii -P-cbuo "$pages/shearwater-render.1" | grep -q -- '-o, --output OUT.exr'; }
    check "a page reads as it should" reads
elif command -v mandoc >/dev/null; then
    check "mandoc has no warning" mandoc -T lint -W warning "$pages"/*.1
else
    skip "groff has no warning" "groff is not installed"
fi

# completes EXPECTED WORD...: what bash offers for the last word.
completes() {
    local expected=$1; shift
    bash -c '. "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _shearwater; echo "${COMPREPLY[*]}"' "$completion/shearwater" "$@" >"$tmp/offered"
    [ "$(cat "$tmp/offered")" = "$expected" ] || { cat "$tmp/offered"; return 1; }
}
check "bash completes a command" completes serve shearwater se
check "bash completes an option" completes --listen shearwater serve --li
check "bash completes an option's word" completes sheared shearwater render --method she
check "bash completes a file" completes tests/system/man.sh shearwater render tests/system/man
check "bash completes the worker's options" completes "--cache --cache-bytes" shearwater-worker --ca
check "bash offers nothing where anything may stand" completes "" shearwater serve --listen ""
check "the worker's completion is there, too" test -r "$completion/shearwater-worker"
if command -v zsh >/dev/null; then check "zsh can read its completion" zsh -n "$root/usr/share/zsh/site-functions/_shearwater"
else skip "zsh can read its completion" "zsh is not installed"; fi

check "uninstalled" make -s uninstall B="$build" DESTDIR="$root" PREFIX=/usr
check "nothing is left" bash -c "! find '$root' -type f -o -type l | grep ."
tap_done
