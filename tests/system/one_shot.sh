#!/usr/bin/env bash
# What `shearwater render` waits for, besides its picture: no file of the server of its own, whose folder goes with
# it, waits for the disk, and it ends as soon as nobody is connected to it; whoever is gets an answer first.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/one_shot.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
most() { [ "$1" -le "$2" ] || { echo "$1, more than $2"; return 1; }; }
now_ms() { echo $(($(date +%s%N) / 1000000)); }
cat >"$tmp/job.json" <<J
{"scene": {"file": "$scene"}, "image": {"width": 64, "height": 48}, "sampling": {"spp": 4, "seed": 1}}
J
mkdir "$tmp/data_dirs"
render() { TMPDIR=$tmp/data_dirs "$build/shearwater" render "$tmp/job.json" --quiet --workers 1 -o "$tmp/out.exr" "$@"; }

# The disk: tests/fake/preload_faults.c counts what waits for it.
if is_sanitized; then
    skip "what waits for the disk" "a sanitizer's allocator cannot be preloaded before"
else
    preload=$(realpath -e "$build/tests/fake/preload_faults.so")
    counted() { # counted COMMAND...: $syncs, of processes named $name
        head -c 232 /dev/zero >"$tmp/control"
        LD_PRELOAD=$preload FAULTS_FOR=$name FAULTS_CONTROL=$tmp/control "$@" &&
            syncs=$(od -An -t d8 -j 32 -N 8 "$tmp/control" | tr -d ' ')
    }
    name=shearwater-import
    check "a picture is rendered" counted render
    check "its import does not wait for the disk" most "$syncs" 0
    name=shearwater
    check "it is again" counted render
    check "once its folder is made nothing of it waits for the disk" most "$syncs" 1
    check "a server that keeps its data" counted serve_start "$tmp/kept" --workers 0
    job=$(jq -c '.scene.asset = $asset | del(.scene.file)' --arg asset "$(sha256sum <"$scene" | cut -c1-64)" "$tmp/job.json")
    http -T "$scene" -o "$tmp/body" "$url/v1/assets/$(jq -r .scene.asset <<<"$job")"
    check "... takes a job" is "$(http -o "$tmp/body" -w '%{http_code}' -H 'Content-Type: application/json' "$url/v1/jobs" -d "$job")" 202
    syncs=$(od -An -t d8 -j 32 -N 8 "$tmp/control" | tr -d ' ')
    check "... and waits for the disk" most 5 "$syncs"
    serve_stop
fi

# The end. A machine that is busy may be late: the quickest of some counts.
late_ms=90
quickest() { # quickest COMMAND: the least of what it prints, in some turns
    local least=1000000 one
    for _ in 1 2 3 4 5; do one=$("$@") && [ "$one" -lt $least ] && least=$one; done
    echo $least
}
after_picture_ms() {
    local begin end
    begin=$(now_ms)
    render --stats "$tmp/stats.json" || return 1
    end=$(now_ms)
    echo $((end - begin - $(jq '.wall_s * 1000 | floor' "$tmp/stats.json")))
}
check "the command ends with its picture" most "$(quickest after_picture_ms)" $((late_ms * slower))
closed() { render "$@" >&-; }
check "it renders where standard output is closed" closed
check "it leaves no folder" is "$(ls "$tmp/data_dirs")" ""
# What cannot be written is refused before the work, with its name.
refused() { # refused WORDS COMMAND...
    local words=$1
    shift
    "$@" 2>"$tmp/said" && { echo "it was not refused"; return 1; }
    grep -qF -- "$words" "$tmp/said" || { cat "$tmp/said"; return 1; }
}
check "a picture and statistics in one file are refused" refused "two outputs are this file" render --stats "$tmp/out.exr"
check "... under another name of its folder" refused "two outputs are this file" render --png "$tmp/data_dirs/../out.exr.png" --stats "$tmp/out.exr.png"
ln -s out.exr "$tmp/linked"
check "... and by a link" refused "two outputs are this file" render --stats "$tmp/linked"
rm "$tmp/out.exr"
check "... that leads nowhere yet" refused "two outputs are this file" render --stats "$tmp/linked"
name_of() { printf "%$1s" '' | tr ' ' a; }
framed() { TMPDIR=$tmp/data_dirs "$build/shearwater" render "$tmp/frames.json" --quiet --workers 1 "$@"; }
jq '.frames = {first: 9, last: 10}' "$tmp/job.json" >"$tmp/frames.json"
check "a picture's name that has no room for what it is called meanwhile is refused" \
    refused "File name too long" render --png "$tmp/$(name_of 247).png"
check "the longest that has is written" render --png "$tmp/$(name_of 246).png"
check "... but not with a frame's number" refused "File name too long" framed --png "$tmp/$(name_of 246).png"
check "statistics have any name" render --stats "$tmp/$(name_of 250).json"
nothing_said() {
    TMPDIR=$tmp/data_dirs "$build/shearwater" render "$tmp/job.json" --workers 1 2>"$tmp/said" &&
        grep -qF 'would keep the picture' "$tmp/said"
}
check "who names no file hears of it" nothing_said

# A pipe that nobody reads is waited for, until somebody interrupts.
interrupted() {
    mkfifo "$tmp/pipe.exr" || return 1
    TMPDIR=$tmp/data_dirs "$build/shearwater" render "$tmp/job.json" -q --workers 1 -o "$tmp/pipe.exr" 2>"$tmp/said" &
    local pid=$! status
    sleep $((2 * slower))
    kill -0 $pid || { echo "it did not wait"; return 1; }
    kill -TERM $pid
    ended $pid 10
    kill -KILL $pid 2>/dev/null && { echo "it went on waiting"; return 1; }
    wait $pid
    status=$?
    is $status 143
}
check "a pipe without a reader is waited for until it is interrupted" interrupted
check "... which leaves no folder either" is "$(ls "$tmp/data_dirs")" ""
ending_ms() {
    serve_start "$tmp/idle" --workers 0 >&2 || return 1
    local begin
    begin=$(now_ms)
    kill -TERM $server_pid
    wait $server_pid >&2 || return 1
    echo $(($(now_ms) - begin))
}
check "a server that nobody is connected to ends at once" most "$(quickest ending_ms)" $((late_ms * slower))

connected() { # a request that comes when the end has begun, by a connection from before
    serve_start "$tmp/idle" --workers 0 || return 1
    exec 3<>"/dev/tcp/127.0.0.1/${url##*:}"
    printf 'GET /livez HTTP/1.1\r\nHost: %s\r\n\r\n' "${url#http://}" >&3
    sed -u '/^\r*$/q' <&3 >"$tmp/before"
    kill -TERM $server_pid
    sleep 0.02
    printf 'GET /v1/jobs HTTP/1.1\r\nHost: %s\r\nConnection: close\r\n\r\n' "${url#http://}" >&3
    timeout 10 cat <&3 >"$tmp/after"
    exec 3>&-
    wait $server_pid && grep -q 'HTTP/1.1 503 ' "$tmp/after"
}
answered() { for _ in 1 2 3 4 5; do connected && return 0; done; return 1; }
check "who is connected is answered first" answered
tap_done
