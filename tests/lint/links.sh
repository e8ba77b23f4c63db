#!/usr/bin/env bash
# The links between the pages. TAP; one test a Markdown file of the repository.
#
# A relative link must lead to a file or a folder of the repository, spelt as it is there. A #fragment
# of a Markdown file must be one of its headings, by the name that GitHub and GitLab give it, or an
# anchor (<a id="...">). Code, fenced or between backticks, has no links.
set -uo pipefail
cd "$(dirname "$0")/../.."
export LC_ALL=C
n=0 status=0

# prose FILE: its lines without code. A line that stands in a fence comes out empty.
prose() {
    awk '
    /^ ? ? ?(```|~~~)/ { mark = substr($0, match($0, /[`~]/), 3)
                         if (fence == "") fence = mark; else if (fence == mark) fence = ""
                         print ""; next }
    fence != "" { print ""; next }
    { gsub(/`[^`]*`/, ""); print }' "$1"
}

# targets FILE: "LINE TARGET" of each of its links: [text](target), ![text](target), [name]: target, src= and href=.
targets() {
    prose "$1" | awk '{
        line = $0
        while (match(line, /\]\([^()]*(\([^()]*\)[^()]*)*\)/)) {
            target = substr(line, RSTART + 2, RLENGTH - 3)
            line = substr(line, RSTART + RLENGTH)
            sub(/^[ \t]*</, "", target); sub(/>[ \t]*$/, "", target)
            sub(/[ \t]+["\047(].*$/, "", target)
            print NR, target
        }
        if (match($0, /^ ? ? ?\[[^]]+\]:[ \t]*/)) {
            target = substr($0, RSTART + RLENGTH)
            sub(/[ \t].*$/, "", target); gsub(/^<|>$/, "", target)
            print NR, target
        }
        for (line = $0; match(line, /(src|href)="[^"]*"/); line = substr(line, RSTART + RLENGTH)) {
            target = substr(line, RSTART, RLENGTH); gsub(/^[^"]*"|"$/, "", target)
            print NR, target
        }
    }'
}

# anchors FILE: what its #fragments may be. Headings keep what stands between their backticks.
anchors() {
    awk '
    /^ ? ? ?(```|~~~)/ { mark = substr($0, match($0, /[`~]/), 3)
                         if (fence == "") fence = mark; else if (fence == mark) fence = ""
                         next }
    fence != "" { next }
    { for (line = $0; match(line, /<a (id|name)="[^"]+"/); line = substr(line, RSTART + RLENGTH)) {
          tag = substr(line, RSTART, RLENGTH); sub(/^[^"]*"/, "", tag); sub(/"$/, "", tag); print tag } }
    /^ ? ? ?#+[ \t]/ {
        text = tolower($0)
        sub(/^ *#+[ \t]+/, "", text); sub(/[ \t]+#*[ \t]*$/, "", text)
        while (match(text, /\]\([^)]*\)/)) text = substr(text, 1, RSTART) substr(text, RSTART + RLENGTH)
        gsub(/[^a-z0-9_ \200-\377-]/, "", text) # letters of other scripts stay
        gsub(/\303\227|\342\200[\223\224\246\230\231\234\235]|\342\206\222|\342\211[\244\245]/, "", text)
        gsub(/ /, "-", text)
        print text (seen[text]++ ? "-" (seen[text] - 1) : "") }' "$1"
}

# files [PATTERN]: of the repository; of an unpacked archive, all but what builds and installs leave in it.
files() {
    git ls-files -co --exclude-standard "$@" 2>/dev/null ||
        find . -type d \( -name node_modules -o -path ./build \) -prune -o -type f -name "${1:-*}" -print | sed 's|^\./||'
}

# is_there PATH: a file or a folder of the repository, every letter as it is.
declare -A known=([.]=1)
while IFS= read -r file; do
    known[$file]=1
    while [[ $file == */* ]]; do file=${file%/*}; known[$file]=1; done
done < <(files)
is_there() { [ -n "${known[$1]:-}" ] && [ -e "$1" ]; }

# resolve FOLDER TARGET: the path from the root; fails where it leads out of the repository.
resolve() {
    local part parts out=()
    IFS=/ read -ra parts <<<"$1/$2"
    for part in "${parts[@]}"; do
        case $part in
        '' | .) ;;
        ..) [ ${#out[@]} -gt 0 ] || return 1; unset 'out[-1]' ;;
        *) out+=("$part") ;;
        esac
    done
    local IFS=/
    path=${out[*]:-.}
}

declare -A headings=()
# has_anchor FILE FRAGMENT
has_anchor() {
    [ -n "${headings[$1]+known}" ] || headings[$1]=$'\n'$(anchors "$1")$'\n'
    [[ ${headings[$1]} == *$'\n'"$2"$'\n'* ]]
}

# find_fault FILE TARGET: sets $fault to what is wrong with a link; to nothing where it leads somewhere.
find_fault() {
    local target=$2 fragment='' folder=. path
    fault=
    [[ $1 != */* ]] || folder=${1%/*}
    case $target in [a-zA-Z]*:* | //*) return ;; esac
    [[ $target != *'#'* ]] || fragment=${target#*#} target=${target%%#*}
    target=${target//%20/ }
    if [ -z "$target" ]; then path=$1
    elif [[ $target == /* ]]; then fault="is an absolute path"; return
    elif ! resolve "$folder" "$target"; then fault="leads out of the repository"; return
    elif ! is_there "$path"; then fault="there is no $path"; return
    fi
    [[ -z $fragment || $path != *.md ]] || has_anchor "$path" "$fragment" || fault="$path has no heading #$fragment"
}

while IFS= read -r page; do
    n=$((n + 1))
    faults=() count=0
    while read -r line target; do
        count=$((count + 1))
        find_fault "$page" "$target"
        [ -z "$fault" ] || faults+=("$page:$line: $target: $fault")
    done < <(targets "$page")
    if [ ${#faults[@]} -eq 0 ]; then echo "ok $n - $page: its links lead somewhere ($count)"
    else
        echo "not ok $n - $page: ${#faults[@]} of $count links lead nowhere"
        printf '# %s\n' "${faults[@]}"
        status=1
    fi
done < <(files '*.md' | sort)
echo "1..$n"
exit $status
