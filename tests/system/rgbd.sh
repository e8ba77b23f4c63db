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
cp tests/scenes/photograph/*.obj tests/scenes/photograph/*.mtl "$tmp/"
side=72
focal=$(jq -n "$side / 2 / 0.249328")

# -- what a sensor sees of a made room, twice as large as in metres, from five places side by side --
# room NAME SCENE EYE_X MEMBERS
room() {
    echo "{\"scene\": {\"file\": \"$2\", \"camera\": {\"eye\": [$3, 1, 5], \"target\": [$3, 1, 0], \"yfov_deg\": 28}},
        \"image\": {\"width\": $side, \"height\": $side}, \"effects\": {\"indirect_bounces\": 4}, $4}" >"$tmp/$1.json"
    render "$1" "$1"
}
reference() { echo "\"sampling\": {\"spp\": $1}, \"filter\": {\"method\": \"none\"}, \"layers\": [\"beauty\", \"depth\"]"; }
sees() {
    local k=0 x spp
    for x in -0.2 -0.1 0 0.1 0.2; do
        spp=4
        [ $x != 0 ] || spp=1024
        room "room_$k" room.obj $x "$(reference $spp)" &&
            "$build/tests/bench/exr_depth" "$tmp/room_$k.exr" "$tmp/depth_$k.pgm" 28 2 1 $k || return 1
        k=$((k + 1))
    done
}
check "a sensor moves past a room" sees
check "the middle of its frames is path-traced with a box" room truth room-and-box.obj 0 "$(reference 1024)"
# x is right and y down in the sequence, whose first camera is to the left.
for k in 0 1 2 3 4; do jq -nr "\"\($k / 30) \(-0.1 + 0.05 * $k) 0 0 0 0 0 1\""; done >"$tmp/poses.txt"
jq -n --argjson f "$focal" --argjson c "$(jq -n "$side / 2 - 0.5")" '{camera: {fx: $f, fy: $f, cx: $c, cy: $c},
    poses: {file: "poses.txt", format: "tum"}, frames: [range(5) | {color: "room_\(.).exr", depth: "depth_\(.).pgm"}],
    to_scene: [2,0,0,0, 0,-2,0,1, 0,0,-2,5, 0,0,0,1]}' >"$tmp/sequence.json"
# job NAME FILTER: the box in the middle frame, under a lamp where the room's is.
job() {
    jq -n --argjson side $side '{scene: {file: "box.obj"}, rgbd: {file: "sequence.json"},
        image: {width: $side, height: $side}, frames: {first: 3, last: 3}, sampling: {spp: 16}, effects: {indirect_bounces: 4},
        lights: [{type: "rectangle", center: [0, 1.93, 0], half_u: [0.25, 0, 0], half_v: [0, 0, 0.25], radiance: [17, 12, 4]}]}
        | '"$2" >"$tmp/$1.json"
}
put() { job "$1" "$2" && render "$1" "$1" "${@:3}"; }
near() { composed truth room_2 "$1" | jq -e ".rms < $2 and .plate_rms > 0.1"; }
for spp in 4 16 64; do
    check "a box stands in it, by $spp samples a pixel" put at_$spp ".sampling.spp = $spp"
    composed truth room_2 at_$spp 2>/dev/null | sed "s/^/# $spp: /"
done
check "at 16 samples a pixel the composite is within 2 % of the truth" near at_16 0.02
check "at 4 within 2.5 %" near at_4 0.025
check "frames beside a frame make it better" eval 'put alone . && jq ".fuse = 0" "$tmp/sequence.json" >"$tmp/alone_sequence.json" &&
    jq ".rgbd.file = \"alone_sequence.json\"" "$tmp/alone.json" >"$tmp/alone_2.json" && render alone_2 alone &&
    jq -en "$(composed truth room_2 at_16 | jq .rms) < $(composed truth room_2 alone | jq .rms)"'
check "the lamp keeps its bits" eval 'composed room_2 room_2 at_16 34,7,4,1 | jq -e ".same == 1"'

# Without the lamp of the job, the light is what the frames tell of it.
lit() { put "$1" "del(.lights) | $2" "${@:3}"; }
for spp in 4 16 64; do
    check "the light is estimated, at $spp samples a pixel" lit lit_$spp ".sampling.spp = $spp"
    check "... or a studio's" lit studio_$spp ".sampling.spp = $spp | .rgbd.light = \"studio\""
    for light in at lit studio; do composed truth room_2 ${light}_$spp 2>/dev/null | sed "s/^/# $light, $spp: /"; done
    check "... which is eight times as far from the truth, at least" eval \
        'jq -en "8 * $(composed truth room_2 lit_$spp | jq .rms) < $(composed truth room_2 studio_$spp | jq .rms)"'
done
check "the estimate is within 4 % of the truth" near lit_16 0.04
check "it throws the box's shadow to where it is" eval 'composed truth room_2 lit_16 51,64,8,6 | jq -e ".plate_rms > 0.2 and .rms < 0.3 * .plate_rms"'
check "... which the studio does not" eval 'composed truth room_2 studio_16 51,64,8,6 | jq -e ".rms > 0.6 * .plate_rms"'
check "... and the lamp keeps its bits" eval 'composed room_2 room_2 lit_16 34,7,4,1 | jq -e ".same == 1"'
check "two workers and other tiles give the same bytes of it" eval 'lit lit_two . --workers 2 --tile 16 && cmp "$tmp/lit_16.exr" "$tmp/lit_two.exr"'
check "it is the same light around one model" eval 'lit lit_fused ".rgbd.surfaces = \"fused\"" && near lit_fused 0.04'

# A sensor that looks lower sees neither the lamp nor the ceiling: how the walls are lit tells of them.
lower() {
    local k
    for k in 0 1 2 3 4; do
        jq '.scene.camera.eye[1] = 0.4 | .scene.camera.target[1] = 0.4' "$tmp/room_$k.json" >"$tmp/low_$k.json" && render low_$k low_$k &&
            "$build/tests/bench/exr_depth" "$tmp/low_$k.exr" "$tmp/low_$k.pgm" 28 2 1 $k || return 1
    done
    jq '.scene.camera.eye[1] = 0.4 | .scene.camera.target[1] = 0.4' "$tmp/truth.json" >"$tmp/low_truth.json" && render low_truth low_truth &&
        jq '.to_scene[7] = 0.4 | .frames = [range(5) | {color: "low_\(.).exr", depth: "low_\(.).pgm"}]' "$tmp/sequence.json" >"$tmp/low.json"
}
check "a sensor sees the room without its lamp" lower
check "the light is estimated by how the room is lit" lit low_lit '.rgbd.file = "low.json"'
check "... or a studio's" lit low_studio '.rgbd.file = "low.json" | .rgbd.light = "studio"'
for light in lit studio; do composed low_truth low_2 low_$light 2>/dev/null | sed "s/^/# $light, without the lamp, 16: /"; done
check "... which is four times as far from the truth" eval \
    'jq -en "4 * $(composed low_truth low_2 low_lit | jq .rms) < $(composed low_truth low_2 low_studio | jq .rms)"'

# One model of all frames in place of what each saw.
check "a box stands in a model of all frames" put fused '.rgbd.surfaces = "fused"'
composed truth room_2 fused 2>/dev/null | sed "s/^/# fused, 16: /"
check "... within 2.5 % of the truth" near fused 0.025
check "... which is not what the frame saw" eval '! cmp -s "$tmp/fused.exr" "$tmp/at_16.exr"'
check "... and the lamp keeps its bits there, too" eval 'composed room_2 room_2 fused 34,7,4,1 | jq -e ".same == 1"'
model() { job model '.rgbd.surfaces = "fused" | .frames = "2,4" | .sampling.spp = 4' && "$build/shearwater" render "$tmp/model.json" -o "$tmp/$1.#.exr" --quiet "${@:2}"; }
check "a sequence shows it from each camera" eval 'model model && ! cmp -s "$tmp/model.2.exr" "$tmp/model.4.exr"'
for k in 2 4; do check "... frame $k before its own photograph" eval "composed room_$((k - 1)) room_$((k - 1)) model.$k 0,6,8,60 | jq -e '.rms < 0.2'"; done
check "... with the same bytes by two workers and other tiles" eval 'model model2 --workers 2 --tile 16 && cmp "$tmp/model.2.exr" "$tmp/model2.2.exr" && cmp "$tmp/model.4.exr" "$tmp/model2.4.exr"'
some() { job some ".rgbd.surfaces = \"fused\" | .frames = \"$1\" | .sampling.spp = 4 | .filter.temporal = \"none\"" && "$build/shearwater" render "$tmp/some.json" -o "$tmp/some_$2.#.exr" --quiet; }
check "... and the same picture by itself" eval 'some 2,4 both && some 4 one && "$build/shearwater" compare "$tmp/some_both.4.exr" "$tmp/some_one.4.exr" --layer composite | jq -e ".rmse == 0"'

# What frames on each side lend a frame makes it better.
window() {
    job window ".frames.first = 2 | .frames.last = 4 | .sampling.spp = 4 | .filter.temporal = \"$1\"" &&
        "$build/shearwater" render "$tmp/window.json" -o "$tmp/window_$1.#.exr" --quiet
}
check "three frames are composed one by one, and together" eval 'window none && window auto'
check "... which is nearer to the truth" eval \
    'jq -en "$(composed truth room_2 window_auto.3 | jq .rms) < 0.95 * $(composed truth room_2 window_none.3 | jq .rms)"'

# Frames follow the camera, each with its own photograph.
sequence() { job list '.frames = "2,4" | .sampling.spp = 4' && "$build/shearwater" render "$tmp/list.json" -o "$tmp/$1.#.exr" --quiet "${@:2}"; }
check "frames are composed with their own photographs" sequence list
for k in 2 4; do check "... frame $k" eval "composed room_$((k - 1)) room_$((k - 1)) list.$k 0,6,8,60 | jq -e '.rms < 0.2'"; done
check "... and stand where their cameras were" eval '! cmp -s "$tmp/list.2.exr" "$tmp/list.4.exr"'
check "two workers and other tiles give the same bytes" eval 'sequence again --workers 2 --tile 16 && cmp "$tmp/list.2.exr" "$tmp/again.2.exr" && cmp "$tmp/list.4.exr" "$tmp/again.4.exr"'

# What stands before the box hides it: half of it is behind a wall that the sensor sees.
cat >"$tmp/screen.obj" <<OBJ
mtllib materials.mtl
v 0.2 0 0.8
v 1 0 0.8
v 1 0.9 0.8
v 0.2 0.9 0.8
usemtl green
f 1 2 3 4
OBJ
{ cat "$tmp/room.obj"; sed -n '/^v/p' "$tmp/screen.obj"; printf 'usemtl green\nf -4 -3 -2 -1\n'; } >"$tmp/hidden_room.obj"
hides() {
    room room_2 hidden_room.obj 0 "$(reference 64)" &&
        "$build/tests/bench/exr_depth" "$tmp/room_2.exr" "$tmp/depth_2.pgm" 28 2 1 3 &&
        jq '.fuse = 0' "$tmp/sequence.json" >"$tmp/hidden_sequence.json" &&
        job hidden '.rgbd.file = "hidden_sequence.json"' && render hidden hidden
}
check "a screen comes before the box" hides
alpha() { "$build/tests/bench/exr_pixel" "$tmp/hidden.exr" "$1" "$2" | jq -e "$3"; }
check "... which is seen beside it" alpha 37 50 '.A == 1'
check "... and hidden by it" alpha 45 50 '.A == 0'

# -- what is refused --
# refused PLACE TEXT FILE FILTER: the job, changed by $with, and with a file of the sequence changed by jq, or by sed where it is a text.
refused() {
    local said=0
    job bad "${with:-.}" && cp "$tmp/$3" "$tmp/kept"
    case $3 in *.json) jq "$4" "$tmp/kept" >"$tmp/$3" ;; *) sed "$4" "$tmp/kept" >"$tmp/$3" ;; esac
    "$build/shearwater" render "$tmp/bad.json" -o "$tmp/bad.exr" --quiet >"$tmp/said" 2>&1 && said=1
    cp "$tmp/kept" "$tmp/$3"
    cat "$tmp/said"
    [ $said = 0 ] && grep -qF -- "$1" "$tmp/said" && grep -q -- "$2" "$tmp/said"
}
"$build/shearwater" render "$tmp/box.obj" -o "$tmp/small.exr" --size 24x24 --spp 1 --quiet
check "poses that end early" refused /rgbd/poses/file 'ends after 4 poses of 5 frames' poses.txt '$d'
check "a pose that is no rotation" refused /rgbd/poses/file 'line 2: its quaternion has the length 3' poses.txt '2s/1$/3/'
check "depth that is all zero" refused /rgbd/frames/2/depth 'no pixel has a depth' sequence.json '.depth.scale = 1e9'
check "images of two sizes" refused /rgbd/frames/2/color 'the colour image has 24 x 24 px' sequence.json '.frames[2].color = "small.exr"'
check "a file that is not there" refused '' 'nowhere.pgm' sequence.json '.frames[2].depth = "nowhere.pgm"'
check "a camera without a focal length" refused /rgbd/camera/fx 'fx' sequence.json 'del(.camera.fx)'
check "an estimate beside an environment" refused /rgbd/light 'is the light from around already' bad.json '.rgbd.light = "estimate" | .environment = {radiance: [1, 1, 1]}'
check "surfaces of another kind" refused /rgbd/surfaces 'solid' bad.json '.rgbd.surfaces = "solid"'
with='.rgbd.surfaces = "fused"' check "poses too far apart for one model" refused /rgbd/poses/file 'too far from the others' poses.txt '2s/ 0 0 0 0 0 1$/ 1e13 0 0 0 0 1/'
check "a picture of another size" refused /rgbd 'the photograph has 72 x 72 px, the picture 48 x 72' bad.json '.image.width = 48'
tap_done
