#!/usr/bin/env bash
# The importer as a process: real scenes come out right, hostile ones end in a clean line.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/import.sh BUILD_DIR}
. tests/tap.bash
blob=$tmp/scene.blob line=$tmp/line.json

# Imports FILE with its own folder as the root.
import() {
    [ ! -e "$blob" ] || rm "$blob"
    timeout 60 "$build/shearwater-import" --root "${1%/*}" --in "${1##*/}" --out "$blob" >"$line"
}
# Imports FILE and asks jq about the line and the blob: $l and the input.
import_is() { # FILE FILTER
    import "$1" || { cat "$line"; return 1; }
    "$build/tests/fake/scene_print" "$blob" |
        jq -e --argjson l "$(cat "$line")" "def near(a; b): [a, b] | transpose
            | all((.[0] - .[1]) | fabs < 1e-4); $2"
}
# FILE ends with exit status 0 and a blob, or with 1, a fault that names a code, and no blob.
ends_cleanly() { each_ends <<<"$1" && told_cleanly; }
each_ends() { # reads names; what their lines say is told_cleanly's to judge, all at once
    local name status said failed=0
    : >"$tmp/told"
    while read -r name; do
        import "$name"
        status=$?
        mapfile -t said <"$line"
        case $status in
        0) [ -s "$blob" ] ;;
        1) [ ! -e "$blob" ] ;;
        *) false ;;
        esac && [ ${#said[@]} -eq 1 ] || { echo "$name: exit status $status: ${said[*]}"; failed=1; }
        printf '{"status": %d, "said": %s}\n' $status "${said[0]:-null}" >>"$tmp/told"
    done
    return $failed
}
told_cleanly() {
    jq -es 'map(select(if .status == 0 then .said | .ok == true and (.triangles > 0 or .width_px > 0)
        else .said | .ok == false and (.code | length > 0) and (.detail | length > 0) end | not)) | ., length == 0' "$tmp/told" | tail -n 20 |
        tee /dev/stderr | tail -n 1 | grep -qx true
}
all_end_cleanly() { each_ends && told_cleanly; }
refuses() { # FILE CODE POINTER
    import "$1" && return 1
    jq -e --arg code "$2" --arg pointer "$3" '.code == $code and .pointer == $pointer' "$line"
}
with_scene() { # FILE TEXT FILTER
    has_scene "$1" "$2" && check "$2" import_is "$scenes/$1" "$3"
}
placed() { with_scene "$1" "$1 has $2 triangles" ".placed_triangles == $2 and \$l.placed_triangles == $2"; }

# --- the shipped scene, and the program's manners
box=tests/scenes/cornell-box/cornell-box.glb
check "--help answers" "$build/shearwater-import" --help
check "the shipped Cornell box has its light, camera and 36 triangles" import_is "$box" \
    '.placed_triangles == 36 and .light_count == 1 and .lights[0].type == "rectangle"
     and near(.lights[0].color; [17, 12, 4]) and near(.lights[0].position; [-0.005, 1.98, -0.03])
     and near(.lights[0].direction; [0, -1, 0]) and .lights[0].has_instance
     and near([.cameras[0].yfov_rad]; [0.340339]) and (.cameras[0].is_default | not)
     and near(.bounds_min; [-1, 0, -1]) and near(.bounds_max; [1, 2, 1])
     and ([.instances[] | select(.is_light)] | length) == 1'
without_options() { ! "$build/shearwater-import" --root / >"$line" && jq -e '.code == "MISSING"' "$line"; }
check "missing options are a clean error" without_options
report_is_written() {
    "$build/shearwater-import" --root "$(dirname $box)" --in cornell-box.glb --out "$blob" \
        --report "$tmp/report.json" >"$line" && cmp "$line" "$tmp/report.json"
}
check "--report repeats the line" report_is_written
deterministic() {
    import "$1" && cp "$blob" "$tmp/first.blob" && import "$1" && cmp "$blob" "$tmp/first.blob"
}
check "the same file gives the same bytes" deterministic "$box"

# --- hostile input
cp $box "$tmp/whole.glb"
truncated() {
    local size at
    size=$(stat -c %s "$tmp/whole.glb")
    rm -rf "$tmp/cut" && mkdir "$tmp/cut"
    for ((at = 0; at < size; at += $1)); do head -c $at "$tmp/whole.glb" >"$tmp/cut/$at.glb"; done
    all_end_cleanly < <(ls "$tmp"/cut/*) && jq -es 'all(.[]; .status == 1)' "$tmp/told"
}
check "a GLB cut at every 293rd byte is refused cleanly" truncated 293
garbled() {
    local size at
    size=$(stat -c %s "$tmp/whole.glb")
    rm -rf "$tmp/cut" && mkdir "$tmp/cut"
    for ((at = 12; at < size; at += 311)); do
        cp "$tmp/whole.glb" "$tmp/cut/$at.glb"
        printf '\xff' | dd of="$tmp/cut/$at.glb" bs=1 seek=$at conv=notrunc status=none
    done
    all_end_cleanly < <(ls "$tmp"/cut/*)
}
check "a GLB with a wrong byte ends cleanly wherever it is" garbled
room=$tmp/room; mkdir -p "$room/inner"; echo "secret" >"$room/secret.bin"
asset='"asset": {"version": "2.0"}, "bufferViews": [{"buffer": 0, "byteLength": 6}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 1, "type": "VEC3"}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]'
steals() { # URI CODE
    echo "{$asset, \"buffers\": [{\"uri\": \"$1\", \"byteLength\": 6}]}" >"$room/inner/a.gltf"
    refuses "$room/inner/a.gltf" "$2" 'buffers[0].uri'
}
ln -s ../secret.bin "$room/inner/link.bin"
check "a name with .. is refused" steals ../secret.bin RANGE
check "an escaped .. is refused" steals %2e%2e/secret.bin RANGE
check "an absolute name is refused" steals "$room/secret.bin" RANGE
check "a symbolic link is not followed" steals link.bin IO
check "a missing file is named" steals gone.bin NOT_FOUND
deep() { printf '%s' '{"a":'; for _ in $(seq 5000); do printf '['; done; }
deep >"$room/deep.gltf"
check "deep nesting is refused" refuses "$room/deep.gltf" LIMIT ""
lots='{"asset": {"version": "2.0"}, "accessors": [{"componentType": 5126, "count": 199999999,
  "type": "VEC3"}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]}'
echo "$lots" >"$room/lots.gltf"
check "a small file cannot ask for gigabytes" refuses "$room/lots.gltf" LIMIT "accessors[0]"
awk 'BEGIN { for (y = 0; y <= 400; y++) for (x = 0; x <= 400; x++) print "v", x, y, (x * y) % 7
    for (y = 0; y < 400; y++) for (x = 1; x <= 400; x++)
        print "f", y * 401 + x, y * 401 + x + 1, y * 401 + x + 402, y * 401 + x + 401 }' >"$room/large.obj"
short_of() { # LIMIT FILE CODE
    # Sanitizers cannot run in little memory.
    grep -q -e __asan_init -e __tsan_init "$build/shearwater-import" && return 0
    rm -f "$blob"
    (ulimit $1; timeout 20 "$build/shearwater-import" --root "$(dirname "$2")" \
        --in "$(basename "$2")" --out "$blob" >"$line")
    [ $? -eq 1 ] && jq -e --arg code "$3" '.code == $code' "$line" && [ ! -e "$blob" ]
}
check "a large OBJ imports" ends_cleanly "$room/large.obj"
check "memory that runs out inside assimp is a clean error" short_of "-v 100000" "$room/large.obj" MEMORY
cut_short() {
    local after status
    for after in 0.15 0.3 0.6 1.2 2.4; do # on a busy machine it may not listen yet
        rm -f "$blob"
        timeout --preserve-status -s ALRM $after "$build/shearwater-import" --root "$room" --in large.obj --out "$blob" >"$line"
        status=$?
        [ $status -eq $((128 + 14)) ] || break
    done
    [ $status -eq 1 ] && jq -e '.code == "TIMEOUT"' "$line" && [ "$(wc -l <"$line")" -eq 1 ]
}
check "time that runs out is a clean error" cut_short
printf 'mtllib ../secret.bin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >"$room/inner/a.obj"
greys() { import "$1" && grep -q 'secret.bin.* is missing: its materials are grey' "$line"; }
check "an OBJ's library outside its folder is not read" greys "$room/inner/a.obj"
head -c 100000 /dev/urandom >"$room/noise"
cp "$room/noise" "$room/noise.obj"; cp "$room/noise" "$room/noise.glb"
check "noise ends cleanly" all_end_cleanly < <(ls "$room"/noise*)
text="all malformed files end cleanly"
has_scene malformed-gltf-validator "$text" && check "$text" all_end_cleanly < <(
    find "$scenes/malformed-gltf-validator" -name '*.gltf' -o -name '*.glb')

# --- environment maps
sky=$room/sky
{ printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n'
    for _ in $(seq 16); do printf '\2\2\0\40\240\200\240\100\240\40\240\201'; done; } >"$sky"
map_is() { # FILE WIDTH HEIGHT WARNINGS
    import "$1" || { cat "$line"; return 1; }
    jq -e --argjson is "[$2, $3, $4]" \
        '.ok and [.width_px, .height_px, (.warnings | length)] == $is and (has("triangles") | not)' "$line" &&
        [ "$(head -c 7 "$blob")" = SWENVIR ] && [ "$(stat -c %s "$blob")" -eq $((64 + 12 * $2 * $3)) ]
}
no_scene() {
    import "$1" || return 1
    ! "$build/tests/fake/scene_print" "$blob" 2>&1 | tee "$tmp/print" | jq -e . >/dev/null &&
        grep "environment map, not a scene" "$tmp/print"
}
check "a Radiance picture without a name's ending becomes an environment map" map_is "$sky" 32 16 0
check "an environment map is no scene" no_scene "$sky"
check "the same picture gives the same bytes" deterministic "$sky"
cp "$sky" "$tmp/whole.glb"
check "a picture cut at every 97th byte is refused cleanly" truncated 97
cp "$sky" "$tmp/sky.obj"
check "first bytes count for more than a name" map_is "$tmp/sky.obj" 32 16 0
printf '#?RADIANCE\n\n-Y 16384 +X 16384\n' >"$room/vast.hdr"
check "a vast picture is refused" refuses "$room/vast.hdr" LIMIT vast.hdr
{ printf 'v/1\1\2\0\0\0'; head -c 5000 /dev/urandom; } >"$room/noise.exr"
check "noise behind the mark of OpenEXR ends cleanly" ends_cleanly "$room/noise.exr"
for map in hdr/park.hdr:1024:512 hdr/venice.hdr:1024:512 hdr/studio.hdr:1024:512 \
           'living-room/textures/Sky 19.exr:2048:1024'; do
    IFS=: read -r name width height <<<"$map"
    text="$name is a map of $width x $height"
    has_scene "$name" "$text" && check "$text" map_is "$scenes/$name" "$width" "$height" 0
done

# --- real scenes
placed glb/cornell-box-bitterli/cornell-box-bitterli.glb 36
placed glb/living-room/living-room.glb 142973
placed glb/veach-mis/veach-mis.glb 11956
placed glb/gazebo/gazebo.glb 734
placed glb/fence/fence.glb 15170
placed glb/dof-luxcore/dof-luxcore.glb 6722
placed dof-bevy/DepthOfFieldExample.glb 10610
placed gltf/FlightHelmet/FlightHelmet.gltf 94722
placed gltf/MetalRoughSpheresNoTextures/glTF/MetalRoughSpheresNoTextures.gltf 1040409
placed gltf/AlphaBlendModeTest/glTF/AlphaBlendModeTest.gltf 61
placed gltf/TextureTransformTest/glTF/TextureTransformTest.gltf 24
placed gltf/TextureSettingsTest/glTF/TextureSettingsTest.gltf 72
placed gltf/MultiUVTest/glTF/MultiUVTest.gltf 12
placed gltf/OrientationTest/glTF/OrientationTest.gltf 524
placed gltf/Box/glTF/Box.gltf 12
placed gltf/BoxTextured/glTF/BoxTextured.gltf 12
placed gltf/BoxTexturedNonPowerOfTwo/glTF/BoxTexturedNonPowerOfTwo.gltf 12
placed gltf/BoxInterleaved/glTF/BoxInterleaved.gltf 12
placed gltf/Triangle/glTF/Triangle.gltf 1
placed gltf/TriangleWithoutIndices/glTF/TriangleWithoutIndices.gltf 1
placed gltf/SimpleMeshes/glTF/SimpleMeshes.gltf 2
placed gltf/SimpleSparseAccessor/glTF/SimpleSparseAccessor.gltf 12
placed gltf/Cameras/glTF/Cameras.gltf 2
placed gltf/Duck/glTF/Duck.gltf 4212
placed gltf/bevy-CornellBox/CornellBox.glb 36
placed gltf/playcanvas/AnisotropyDiscTest.glb 2788
placed gltf/playcanvas/AnisotropyStrengthTest.glb 97240
placed gltf/playcanvas/ClearCoatTest.glb 37116
placed gltf/playcanvas/AttenuationTest.glb 292
placed gltf/playcanvas/Lights.glb 12
placed gltf/playcanvas/geometry-camera-light.glb 14
placed cornell-box-mcguire/CornellBox-Original.obj 36
placed cornell-box-mcguire/CornellBox-Mirror.obj 36
placed cornell-box-mcguire/CornellBox-Glossy.obj 1112
placed cornell-box-mcguire/CornellBox-Glossy-Floor.obj 1112
placed cornell-box-mcguire/CornellBox-Sphere.obj 2188
placed cornell-box-mcguire/CornellBox-Water.obj 7088
placed cornell-box-mcguire/water.obj 4900
placed cornell-box-mcguire/CornellBox-Empty-CO.obj 12
placed cornell-box-mcguire/CornellBox-Empty-RG.obj 12
placed cornell-box-mcguire/CornellBox-Empty-White.obj 12
placed cornell-box-mcguire/CornellBox-Empty-Squashed.obj 12
with_scene gltf/FlightHelmet/FlightHelmet.gltf "FlightHelmet keeps its 15 images and tangents" \
    '(.images | length) == 15 and ([.images[] | select(.srgb)] | length) == 5
     and all(.images[0:14][]; .width == 512) and all(.instances[]; .has_tangents)
     and all(.images[]; .srgb == (.name | contains("BaseColor")))'
with_scene gltf/playcanvas/Lights.glb "Lights.glb has a point, two spots and a sun" \
    '[.lights[].type] == ["point", "spot", "spot", "directional"]
     and near(.lights[0].color; [5, 0, 0]) and near(.lights[1].color; [0, 10, 0])
     and near(.lights[0].position; [2.598804, 3.568508, -1.005454])
     and near(.lights[1].direction; [0, -1, 0])
     and near([.lights[1].cos_inner, .lights[1].cos_outer]; [0.944806, 0.923880])'
with_scene gltf/bevy-CornellBox/CornellBox.glb "emissive strength multiplies, both sides emit" \
    'near(.materials[0].emission; [100, 100, 100]) and .light_count == 2
     and near(.lights[0].direction; [0, -1, 0]) and near(.lights[1].direction; [0, 1, 0])
     and .cameras[0].is_default'
with_scene gltf/Cameras/glTF/Cameras.gltf "Cameras has a perspective and an orthographic one" \
    '[.cameras[].type] == ["perspective", "orthographic"] and near([.cameras[0].yfov_rad]; [0.7])
     and .cameras[1].half_width == 1 and .cameras[1].half_height == 1'
with_scene cornell-box-mcguire/CornellBox-Original.obj "the OBJ box has its light facing down" \
    '.light_count == 1 and near(.lights[0].color; [17, 12, 4])
     and near(.lights[0].direction; [0, -1, 0]) and (.materials | length) == 8'
with_scene cornell-box-mcguire/CornellBox-Mirror.obj "MTL's illum 5 is a mirror" \
    '[.materials[] | select(.model == "mirror")] | length == 1 and .[0].name == "tallBox"
     and near(.[0].model_specular; [0.95, 0.95, 0.95])'
with_scene cornell-box-mcguire/CornellBox-Glossy.obj "MTL's illum 2 is Blinn-Phong, scaled to conserve" \
    '([.materials[] | select(.model == "blinn_phong") | .name] | sort) == ["shortBox", "sphere"]
     and all(.materials[]; (.base_color[0:3] + .model_specular) as $c
             | all([$c[0] + $c[3], $c[1] + $c[4], $c[2] + $c[5]][]; . < 1.00001))
     and ($l.warnings | length) == 2'
with_scene cornell-box-mcguire/CornellBox-Water.obj "MTL's illum 7 is solid glass" \
    '[.materials[] | select(.transmission == 1 and .thickness > 0) | .ior] | sort == [1.5, 2.5]'
with_scene glb/living-room/living-room.glb "volumes and matt surfaces are read" \
    '(.materials[] | select(.name == "Glass") | .transmission == 1 and .thickness > 0)
     and ([.materials[] | select(.specular == 0)] | length) == 12 and $l.warnings == []'
with_scene gltf/playcanvas/AttenuationTest.glb "attenuation is read" \
    '[.materials[] | select(.attenuation_distance > 0)] | length > 0'
with_scene gltf/playcanvas/AnisotropyStrengthTest.glb "anisotropic surfaces have tangents" \
    '[.materials[].anisotropy] as $a | ($a | max) > 0
     and all(.instances[]; .has_tangents or $a[.material] == 0)'
with_scene gltf/playcanvas/ClearCoatTest.glb "normal maps of coats are read" \
    '([.materials[].clearcoat_normal_texture | select(. != null)] | length) == 2
     and ($l.warnings | any(contains("Normal")) | not)'
with_scene gltf/MetalRoughSpheresNoTextures/glTF/MetalRoughSpheresNoTextures.gltf \
    "instancing stores shared geometry once" '.triangles < 15000 and .vertices < 10000'
with_scene gltf/TextureTransformTest/glTF/TextureTransformTest.gltf "texture transforms are read" \
    'near(.materials[3].base_color_texture.transform;
          [0.92388, 0.382683, 0, -0.382683, 0.92388, 0])
     and near(.materials[2].base_color_texture.transform; [1, 0, 0.5, 0, 1, 0.5])'
with_scene gltf/AlphaBlendModeTest/glTF/AlphaBlendModeTest.gltf "alpha modes and cutoffs are read" \
    '[.materials[].alpha_mode] | contains([0, 1, 2])'
with_scene gltf/MultiUVTest/glTF/MultiUVTest.gltf "the second UV set is read" \
    '[.materials[0] | .base_color_texture, .emission_texture | .uv_set] | sort == [0, 1]'
with_scene gltf/BoxInterleaved/glTF/BoxInterleaved.gltf "strides are honoured" \
    'near(.bounds_min; [-0.5, -0.5, -0.5]) and near(.bounds_max; [0.5, 0.5, 0.5])'
for name in glb/living-room/living-room.glb gltf/playcanvas/ClearCoatTest.glb \
            cornell-box-mcguire/CornellBox-Water.obj; do
    has_scene "$name" "$name gives the same bytes twice" &&
        check "$name gives the same bytes twice" deterministic "$scenes/$name"
done
tap_done
