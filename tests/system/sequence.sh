#!/usr/bin/env bash
# Sequences of animated scenes: each frame is the scene at its time, whatever other frames there are,
# however many workers, and with the coordinator killed between.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/sequence.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash

# A triangle goes right by a unit a second, from 1 s to 3 s; another stands.
base64_of() { perl -e 'print pack("f<*", @ARGV)' -- "$@" | base64 -w0; }
data=$(base64_of -.5 -.5 0 .5 -.5 0 0 .5 0  1 3  0 0 0  2 0 0  1 0 0 1 0 0 1 0 0  0 2)
animation='"animations": [{"name": "go", "samplers": [{"input": 1, "output": 2}],
    "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]'
# The same by a morph target that is animated.
morph='"animations": [{"samplers": [{"input": 1, "output": 4}],
    "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}]}]'
scene() { # scene NAME MEMBERS [TARGETS]
    cat >"$tmp/$1.gltf" <<J
{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1, 2]}],
 "nodes": [{"mesh": 0}, {"mesh": 1, "translation": [0, 0, -1]}, {"camera": 0, "translation": [0, 0, 4]}],
 "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}${3:-}}]}, {"primitives": [{"attributes": {"POSITION": 0}}]}],
 "buffers": [{"byteLength": 112, "uri": "data:application/octet-stream;base64,$data"}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
                 {"buffer": 0, "byteOffset": 44, "byteLength": 24}, {"buffer": 0, "byteOffset": 68, "byteLength": 36},
                 {"buffer": 0, "byteOffset": 104, "byteLength": 8}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
               {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR"},
               {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"},
               {"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC3"},
               {"bufferView": 4, "componentType": 5126, "count": 2, "type": "SCALAR"}]$2}
J
}
scene moving ", $animation"
scene bending ", $morph" ', "targets": [{"POSITION": 3}]'
scene still ""
job() { # job NAME SCENE MEMBERS
    printf '{"scene": {"file": "%s.gltf"%s}, "image": {"width": 96, "height": 64}, "sampling": {"spp": 4}, "layers": ["beauty", "depth"]%s}' \
        "$2" "${4:-}" "$3" >"$tmp/$1.json"
}
job list moving ', "frames": "1-9x4,25,49", "fps": 12'
job alone moving ', "frames": {"first": 25}, "fps": 12'
job start moving ', "frames": {"first": 1}, "start_time_s": 2'
job held moving ', "frames": "1-2"' ', "time_s": 2'
job still still ', "frames": "1-2"'
job unknown moving '' ', "animation": "fly"'

differ() { "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$2.exr" --layer depth | jq -e '.rmse > 0.01'; }
alike() { "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$2.exr" --layer "${3:-beauty}" | jq -e '.rmse == 0'; }

check "a list of frames is rendered, with their numbers in place of #" render list l.#### --workers 1
check "... and nothing else" is "$(cd "$tmp" && echo l.*.exr)" "l.0001.exr l.0005.exr l.0009.exr l.0025.exr l.0049.exr"
check "... again on three workers" render list m.#### --workers 3
check "the bytes are the same" bash -c "for f in 0001 0005 0009 0025 0049; do cmp $tmp/l.\$f.exr $tmp/m.\$f.exr || exit 1; done"
# What stands is built once, and fetched once by a worker that is elsewhere.
check "trees of what stands are built once" counts l.#### '.skipped.rebuilt_triangles >= 4'
elsewhere() {
    local id
    serve_start "$tmp/far" --workers 0 || return 1
    "$build/shearwater-worker" --connect "unix:$tmp/far/worker.sock" --threads 1 --cache "$tmp/far-cache" >"$tmp/far.log" 2>&1 &
    track $!
    id=$("$build/shearwater" submit "$tmp/list.json" --server "$url" --quiet) || return 1
    await_state "$id" finished 60 || return 1
    for frame in 1 5 9 25 49; do exr "$id" "$tmp/r.$frame.exr" $frame || return 1; done
    "$build/shearwater" watch "$id" --server "$url" --quiet -o "$tmp/w.####.exr" -p "$tmp/w.png" || return 1
    serve_stop
    for frame in 0001 0005 0009 0025 0049; do cmp "$tmp/w.$frame.exr" "$tmp/l.$frame.exr" && [ -s "$tmp/w.$frame.png" ] || return 1; done
    for frame in 1 5 9 25 49; do cmp "$tmp/r.$frame.exr" "$tmp/l.$(printf %04d $frame).exr" || return 1; done
}
check "a worker with files of its own makes the same" elsewhere

check "before the first key nothing moves" alike l.0001 l.0009 depth
check "between keys it does" differ l.0009 l.0025
check "behind the last it has moved" differ l.0025 l.0049
check "a frame alone is rendered" render alone alone
check "... as among others" alike alone l.0025
check "a start time is that of frame 1" render start start
check "... which shows what frame 25 shows" alike start l.0025 depth
check "scene.time_s holds all frames" render held held.# --frames 1-2
check "... at its time" alike held.1 l.0025 depth
check "... which the option --time changes" render held early --time 0 --frames 1
check "... to another" alike early l.0001 depth
check "a scene without animations stands" render still still.#
check "... in all frames" alike still.1 still.2 depth
# A unit a second at distance 4, 12 frames a second, in a picture of 96 pixels across 4 * 3 tan(1/2).
job motion moving ', "frames": "1,25", "fps": 12'
jq '.layers = ["motion.forward", "vector"]' "$tmp/motion.json" >"$tmp/twice.json"
jq '.layers = ["beauty", "vector"]' "$tmp/motion.json" >"$tmp/vector.json"
check "layers of motion are rendered" render vector v.##
moves() { # moves LAYER PIXELS
    "$build/shearwater" compare "$tmp/v.01.exr" "$tmp/v.25.exr" --layer "$1" |
        jq -e --argjson by "$2" '(.max - (1 / 12) / (4 * 3 * 0.5463024898) * 96 | fabs) < 1e-4 and
            .mean_test[0] * $by > 0 and (.mean_test[1] | fabs) < 1e-5 and .mean_reference == [0, 0, 0]'
}
check "what moves does so by its pixels, forward" moves motion.forward 1
check "... and backward" moves motion.backward -1
jq '.scene.file = "bending.gltf"' "$tmp/vector.json" >"$tmp/bent.json"
check "what bends is rendered" render bent b.##
check "... where the same is that moves as a whole" alike b.25 v.25
near() { "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$2.exr" --layer "$3" | jq -e '.max < 1e-4'; }
check "... and moves alike, forward" near b.25 v.25 motion.forward
check "... and backward" near b.25 v.25 motion.backward
fails() { render "$1" none 2>"$tmp/said" && return 1; grep -F "$2" "$tmp/said"; }
check "a layer that an alias names, too, is refused" fails twice 'is named twice'
check "an animation of no such name is refused with those that there are" fails unknown 'it has "go"'

# The coordinator dies between two frames; what it had is not traced again.
finish_after_restart() {
    local id
    serve_start "$tmp/data" --workers 1 || return 1
    id=$("$build/shearwater" submit "$tmp/list.json" --size 384x256 --server "$url" --quiet) || return 1
    eventually 20 shows "$id" '.progress.frames_done > 0'
    serve_stop -KILL
    serve_start "$tmp/data" --workers 2 || return 1
    await_state "$id" finished 60 || return 1
    for frame in 1 5 9 25 49; do exr "$id" "$tmp/k.$frame.exr" $frame || return 1; done
}
check "a coordinator that is killed goes on" finish_after_restart
check "the undisturbed sequence" render list u.# --size 384x256
check "... has the same bytes" bash -c "for f in 1 5 9 25 49; do cmp $tmp/k.\$f.exr $tmp/u.\$f.exr || exit 1; done"
serve_stop
tap_done
