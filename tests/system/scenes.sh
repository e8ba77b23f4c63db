#!/usr/bin/env bash
# Real scenes through the whole service: each renders, is finite, and is as bright as it should be.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/scenes.sh BUILD_DIR}
. tests/tap.bash

render() { # NAME JSON
    echo "$2" >"$tmp/$1.json"
    "$build/shearwater" render "$tmp/$1.json" --quiet -o "$tmp/$1.exr" --png "$tmp/$1.png"
}
# mean of the picture within [LOW, HIGH]
mean_between() {
    "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$1.exr" |
        jq -e --argjson low "$2" --argjson high "$3" \
           '.finite and (.mean_test | add / 3) as $m | $m >= $low and $m <= $high'
}
scene() { # NAME FILE LOW HIGH REST-OF-JOB
    has_scene "$2" "$1" || return
    check "$1 renders" render "$1" "{\"scene\": {\"file\": \"$scenes/$2\"${5:-}}, \"image\": {\"width\": 160, \"height\": 120}${6:-}}"
    check "$1 is finite and neither black nor burnt out" mean_between "$1" "$3" "$4"
}
key='"lights": [{"type": "rectangle", "center": [1, 1.5, 2], "half_u": [0.5, 0, 0], "half_v": [0, -0.4, 0.3], "radiance": [12, 12, 12]},
     {"type": "directional", "direction": [1, -1, -1], "irradiance": [1, 1, 1.2]}]'

# Names as exporters write them: with "./", with backslashes, percent-encoded, with spaces.
names() {
    local dir="$tmp/sp ace" box=$PWD/tests/scenes/cornell-box/cornell-box.glb job
    mkdir -p "$dir/tex tures" || return 1
    job=", \"camera\": {\"eye\": [0, 1, 2], \"target\": [0, 0, 0]}}, \"image\": {\"width\": 32, \"height\": 32},
         \"layers\": [\"albedo\"]}"
    echo "{\"scene\": {\"file\": \"$box\"}, \"image\": {\"width\": 32, \"height\": 32}}" >"$tmp/box.json"
    "$build/shearwater" render "$tmp/box.json" --quiet --png "$dir/tex tures/a b.png" || return 1
    printf '%s\n' 'mtllib ./my.mtl' 'v -1 0 -1' 'v 1 0 -1' 'v 1 0 1' 'v -1 0 1' 'vt 0 0' 'vt 1 0' 'vt 1 1' \
        'vt 0 1' 'usemtl a' 'f 1/1 4/4 3/3 2/2' >"$dir/my scene.obj"
    printf '%s\n' 'newmtl a' 'map_Kd .\tex tures\a b.png' >"$dir/my.mtl"
    echo "{\"scene\": {\"file\": \"sp ace/my scene.obj\"$job" >"$tmp/names.json"
    "$build/shearwater" render "$tmp/names.json" --quiet -o "$tmp/obj.exr" || return 1
    printf '\0\0\200\277\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\277' >"$dir/tex tures/c d.bin"
    echo '{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "buffers": [{"byteLength": 36, "uri": "./tex%20tures/./c%20d.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [-1, 0, -1], "max": [1, 0, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]}' >"$dir/tri.gltf"
    echo "{\"scene\": {\"file\": \"sp ace/tri.gltf\"$job" >"$tmp/names.json"
    "$build/shearwater" render "$tmp/names.json" --quiet -o "$tmp/gltf.exr"
}
check "files are found under the names that exporters write" names

scene flight-helmet gltf/FlightHelmet/FlightHelmet.gltf 0.005 2 '' ", $key"
scene lights gltf/playcanvas/Lights.glb 0.005 2
scene bevy-cornell-box gltf/bevy-CornellBox/CornellBox.glb 0.005 20
scene mcguire-cornell-box cornell-box-mcguire/CornellBox-Original.obj 0.02 3
scene gazebo glb/gazebo/gazebo.glb 0.005 5
scene fence glb/fence/fence.glb 0.005 5
scene orthographic gltf/Cameras/glTF/Cameras.gltf 0.005 5 ', "camera": 1' \
    ', "lights": [{"type": "directional", "direction": [0, 0, -1], "irradiance": [3, 3, 3]}]'
scene instances gltf/MetalRoughSpheresNoTextures/glTF/MetalRoughSpheresNoTextures.gltf 0.005 5 '' \
    ', "lights": [{"type": "directional", "direction": [0, -0.5, -1], "irradiance": [3, 3, 3]}]'

# Materials that only paths know: mirrors, glass, Blinn-Phong, blends, metals, solids that absorb.
paths=', "filter": {"method": "none"}, "effects": {"indirect_bounces": 12}'
sky=', "environment": {"radiance": [0.7, 0.8, 1]}'
into_box=', "camera": {"eye": [0, 1, 3.4], "target": [0, 0.8, 0], "yfov_deg": 40}'
scene mcguire-mirror cornell-box-mcguire/CornellBox-Mirror.obj 0.05 1 "$into_box" "$paths"
scene mcguire-water cornell-box-mcguire/CornellBox-Water.obj 0.02 1 "$into_box" "$paths"
scene mcguire-glossy cornell-box-mcguire/CornellBox-Glossy.obj 0.1 0.8 "$into_box" "$paths$sky"
scene alpha-modes gltf/AlphaBlendModeTest/glTF/AlphaBlendModeTest.gltf 0.3 1 '' "$paths$sky"
scene anisotropy gltf/playcanvas/AnisotropyDiscTest.glb 0.3 1 '' "$paths$sky"
scene attenuation gltf/playcanvas/AttenuationTest.glb 0.3 1 '' "$paths$sky"
# A closed furnace of one radiance: nothing that only reflects or passes light on may outshine it.
furnace() { # NAME: of a scene rendered above, again under a white sky without other lights
    local job="$tmp/$1-white.json"
    jq '.environment = {"radiance": [1, 1, 1]} | .lights = []' "$tmp/$1.json" >"$job" &&
        "$build/shearwater" render "$job" --quiet -o "$tmp/$1-white.exr" &&
        "$build/shearwater" compare "$tmp/$1-white.exr" "$tmp/$1-white.exr" |
            jq -e '.finite and (.mean_test | max) <= 1.0005'
}
for name in mcguire-glossy alpha-modes anisotropy attenuation; do
    [ ! -e "$tmp/$name.json" ] || check "$name conserves energy" furnace "$name"
done
tap_done
