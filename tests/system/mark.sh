#!/usr/bin/env bash
# A job's name, comment and labels are changed while it waits, works and has ended: searches find it by the new ones,
# a restart keeps them, and no byte of its picture changes.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/mark.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
mark() { "$build/shearwater" mark "$1" --server "$url" "${@:2}"; }
named() { "$build/shearwater" jobs --server "$url" --json "$@" | jq -r '[.[].id] | join(" ")'; }
patch() { http -o "$tmp/body" -w '%{http_code}' -X PATCH -H 'Content-Type: application/json' -d "$2" "${@:3}" "$url/v1/jobs/$1"; }
small='"image": {"width": 64, "height": 64}, "sampling": {"spp": 4}'
marks='[.name, .labels, .document.name, .document.comment, .document.labels]'
of() { get "$1" | jq -c "$marks"; }

start
plain=$(submit "$small")
check "a job without a name is finished" await_state "$plain" finished 60
exr "$plain" "$tmp/plain.exr"
check "it is given a name and labels" is "$(mark "$plain" --name 'Gulls, first' --label 'sc 2,a:1')" "$plain: Gulls, first [a:1] [sc 2]"
check "... which its document has" is "$(of "$plain")" '["Gulls, first",["a:1","sc 2"],"Gulls, first",null,["a:1","sc 2"]]'
check "... and by which it is found" is "$(named --name gulls --label 'sc 2')" "$plain"
check "what is not given stays" is "$(mark "$plain" --comment 'for Ana')" "$plain: Gulls, first [a:1] [sc 2]"
check "labels are replaced" is "$(mark "$plain" --label b)" "$plain: Gulls, first [b]"
check "... and those of before find nothing" is "$(named --label 'sc 2')" ''
revision() { number "$1" .revision; }
before=$(revision "$plain")
check "none takes a name away" is "$(mark "$plain" --name none)" "$plain: - [b]"
check "... under another revision" test "$(revision "$plain")" -gt "$before"
exr "$plain" "$tmp/marked.exr"
check "no byte of the picture changes" cmp "$tmp/plain.exr" "$tmp/marked.exr"
nothing() { ! mark "$plain" 2>"$tmp/nothing" && grep -q 'at least one change' "$tmp/nothing"; }
check "a change of nothing is refused" nothing
bad() { ! mark "$plain" --label 'b,,c' 2>"$tmp/bad" && grep -q '/labels/1: the label is empty' "$tmp/bad"; }
check "a label that is none is refused, with its place" bad

# Of many that saw the same, one gets through, also where the job has ended.
http -D "$tmp/head" -o /dev/null "$url/v1/jobs/$plain"
tag=$(sed -n 's/^ETag: //Ip' "$tmp/head" | tr -d '\r')
racers=()
for i in 1 2 3 4 5 6 7 8; do racers+=(--next -sS --noproxy '*' --max-time 30 -o /dev/null -w '%{http_code}\n' -X PATCH -H 'Content-Type: application/json' -H "If-Match: $tag" -d "{\"name\": \"racer $i\"}" "$url/v1/jobs/$plain"); done
curl --parallel --parallel-immediate "${racers[@]:1}" >"$tmp/statuses"
check "of eight changes at once with one tag one is made" is "$(sort "$tmp/statuses" | uniq -c | xargs)" "1 200 7 412"

# A job in work, and one whose camera moves.
long=$(submit '"image": {"width": 384, "height": 384}, "sampling": {"spp": 400, "tile_px": 32}, "filter": {"method": "none"}, "name": "Long"')
check "a job is in work" eventually 60 has_landed "$long" 3
check "it gets another name" is "$(mark "$long" --name Longer)" "$long: Longer"
live=$(submit "$small"', "live": true, "name": "Live", "labels": ["x"]')
check "a live job rests" eventually 60 await_state "$live" resting 60
moves() {
    for i in 1 2 3 4 5 6; do
        is "$(patch "$live" "{\"camera\": {\"eye\": [0.$i, 1, 6], \"target\": [0, 1, 0]}}")" 200 || return 1
        [ $i != 3 ] || mark "$live" --name Moved --comment 'in between' || return 1
    done
}
check "it is named between moves of its camera" moves
check "its document has both" shows "$live" '.name == "Moved" and .document.name == "Moved" and .document.comment == "in between" and .document.labels == ["x"] and .document.scene.camera.eye[0] == 0.6'
check "it rests again" await_state "$live" resting 60
serve_stop KILL
start
check "after a kill the marks are there" is "$(of "$live")" '["Moved",["x"],"Moved","in between",["x"]]'
check "... of the job in work, too" is "$(of "$long")" '["Longer",[],"Longer",null,[]]'
check "... and of the one that has ended" is "$(named --name racer --label b)" "$plain"
serve_stop
tap_done
