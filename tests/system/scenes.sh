#!/usr/bin/env bash
# Real scenes through the whole service: each renders, is finite, and is as bright as it should be.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/scenes.sh BUILD_DIR}
. tests/tap.bash
scenes=$(realpath -m "${SHEARWATER_SCENES:-../shared/scenes}")

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
    if [ ! -e "$scenes/$2" ]; then skip "$1" "no shared scenes here"; return; fi
    check "$1 renders" render "$1" "{\"scene\": {\"file\": \"$scenes/$2\"${5:-}}, \"image\": {\"width\": 160, \"height\": 120}${6:-}}"
    check "$1 is finite and neither black nor burnt out" mean_between "$1" "$3" "$4"
}
key='"lights": [{"type": "rectangle", "center": [1, 1.5, 2], "half_u": [0.5, 0, 0], "half_v": [0, -0.4, 0.3], "radiance": [12, 12, 12]},
     {"type": "directional", "direction": [1, -1, -1], "irradiance": [1, 1, 1.2]}]'

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
tap_done
