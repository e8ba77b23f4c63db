#!/usr/bin/env bash
# Objects in sequences of colour and depth: a room path-traced with a box against the box put into what a
# noisy sensor saw of the room; cameras follow the poses; what is wrong with a sequence is refused where
# it stands.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/rgbd.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
composed() { "$build/tests/bench/exr_composite" "$tmp/$1.exr" "$tmp/$2.exr" "$tmp/$3.exr" "${@:4}" | tee /dev/stderr; }
side=${SIDE:-96} f=$(jq -n "${SIDE:-96} / 2 / 0.24932800")
cp tests/scenes/photograph/*.obj tests/scenes/photograph/*.mtl "$tmp/"

# -- what a sensor sees of a made room, twice as large as in metres, from five places side by side --
# room NAME SCENE EYE_X MEMBERS
room() {
    echo "{\"scene\": {\"file\": \"$2\", \"camera\": {\"eye\": [$3, 1, 5], \"target\": [$3, 1, 0], \"yfov_deg\": 28}},
        \"image\": {\"width\": $side, \"height\": $side}, \"effects\": {\"indirect_bounces\": 4}, $4}" >"$tmp/$1.json"
    render "$1" "$1"
}
reference() { echo "\"sampling\": {\"spp\": $1, \"seed\": $2}, \"filter\": {\"method\": \"none\"}, \"layers\": [\"beauty\", \"depth\"]"; }
sees() {
    local k=0 x spp
    for x in -0.2 -0.1 0 0.1 0.2; do
        spp=4; [ $x != 0 ] && [ $x != 0.1 ] || spp=1024
        room "room_$k" room.obj $x "$(reference $spp 1)" &&
            "$build/tests/bench/exr_depth" "$tmp/room_$k.exr" "$tmp/depth_$k.pgm" 28 2 ${NOISE:-1} $k || return 1
        k=$((k + 1))
    done
}
check "a sensor moves past a room" sees
for k in 2 3; do check "frame $k is path-traced with a box" room "truth_$k" room-and-box.obj 0$([ $k = 3 ] && echo .1) "$(reference 1024 1)"; done
# x is right and y down in the sequence, whose first camera is to the left.
for k in 0 1 2 3 4; do jq -nr "\"\($k / 30) \(-0.1 + 0.05 * $k) 0 0 0 0 0 1\""; done >"$tmp/poses.txt"
jq -n --argjson f $f --argjson c "$(jq -n "$side / 2 - 0.5")" '{camera: {fx: $f, fy: $f, cx: $c, cy: $c}, poses: {file: "poses.txt", format: "tum"},
    frames: [range(5) | {color: "room_\(.).exr", depth: "depth_\(.).pgm"}], to_scene: [2,0,0,0, 0,-2,0,1, 0,0,-2,5, 0,0,0,1]}' >"$tmp/sequence.json"
# job NAME SPP SEQUENCE FILTER: the box in frames 3 and 4, under the room's lamp.
job() {
    jq -n --argjson spp $2 --argjson side $side --arg sequence "$3" '{scene: {file: "box.obj", lights: true}, rgbd: {file: $sequence},
        image: {width: $side, height: $side}, frames: {first: 3, last: 4}, sampling: {spp: $spp}, effects: {indirect_bounces: 4},
        lights: [{type: "rectangle", center: [0, 1.93, 0], half_u: [0.25, 0, 0], half_v: [0, 0, 0.25], radiance: [17, 12, 4]}]}
        | '"${4:-.}" >"$tmp/$1.json"
    "$build/shearwater" render "$tmp/$1.json" --quiet -o "$tmp/$1.####.exr" --png "$tmp/$1.####.png" --stats "$tmp/$1.stats"
}
for spp in 4 16 64; do
    check "a box stands in it, by $spp samples a pixel" job "at_$spp" $spp sequence.json
    composed truth_2 room_2 at_$spp.0003 2>/dev/null | sed "s/^/# $spp: /"
done
