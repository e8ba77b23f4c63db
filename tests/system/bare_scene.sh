#!/usr/bin/env bash
# A scene in place of a job: no lights, no camera, nothing to read first.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/bare_scene.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
cat >"$tmp/a box.obj" <<'O'
v 0 0 0
v 2 0 0
v 2 1 0
v 0 1 0
v 0 0 1
v 2 0 1
v 2 1 1
v 0 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 3 4 8 7
f 1 5 8 4
f 2 3 7 6
O
render() { "$build/shearwater" render "$tmp/a box.obj" --spp 4 "$@" 2>"$tmp/err"; }
check "a bare OBJ renders" render -o "$tmp/a.exr" --png "$tmp/a.png" --size 96x64
check "a warning says what lights it" grep -q "neutral studio light" "$tmp/err"
lit() { "$build/shearwater" compare "$1" "$1" | jq -e ".mean_reference | min $2"; }
check "it is lit" lit "$tmp/a.exr" "> 0.15"
check "without that light it is black" render -o "$tmp/b.exr" --size 96x64 --no-default-light
check "... as the warning says" grep -q "the picture will be black" "$tmp/err"
check "... all of it" lit "$tmp/b.exr" "== 0"
plan() { # the same document over HTTP has the same defaults
    "$build/shearwater" submit "$tmp/a box.obj" --server "$url" --dry-run "$@" >"$tmp/plan.json"
}
serve_start "$tmp/data" --workers 0
check "submit takes it, too" plan --size 200x100
check "the plan names light and camera" jq -e \
    '(.plan // .) | .environment.type == "studio" and .camera.made_by_importer' "$tmp/plan.json"
eye() { jq -c '(.plan // .).camera.eye' "$tmp/plan.json"; }
wide=$(eye)
check "a tall picture" plan --size 100x200
check "... is seen from further away" test "$wide" != "$(eye)"
refused() { ! plan "$@" 2>/dev/null; }
check "a camera that is not there is refused" refused --camera none
serve_stop
nobody() { ! "$build/shearwater" submit "$tmp/a box.obj" --server "$1" 2>"$tmp/err" && grep -q "^shearwater submit: no server answers at $1" "$tmp/err"; }
check "a server that is not there is named" nobody http://127.0.0.1:1
gone() { ! "$build/shearwater" render "$tmp/gone.glb" 2>"$tmp/err" && grep -q "gone.glb" "$tmp/err"; }
check "a scene that is not there is named" gone

# OBJ files come without their libraries: grey, with a warning. An image that is missing is told with its material.
printf 'mtllib my box.mtl\nusemtl red\n' | cat - "$tmp/a box.obj" >"$tmp/with.obj"
with() { "$build/shearwater" render "$tmp/with.obj" --spp 1 --size 32x32 -o "$tmp/with.exr" 2>"$tmp/err"; }
check "an OBJ without its library renders" with
check "... and a warning names the library" grep -q 'the file "my box.mtl" is missing: its materials are grey' "$tmp/err"
printf 'newmtl red\nmap_Kd my gone.png\n' >"$tmp/my box.mtl"
map_gone() { ! with && grep -q 'map_Kd of the material "red": .*/my gone.png: No such file' "$tmp/err"; }
check "an image that is missing is told with its material" map_gone
# Folders are those of the machine that wrote it.
cp docs/images/demo.png "$tmp/my map.png"
printf '\xef\xbb\xbfnewmtl red\nmap_Kd C:\\Users\\me\\my map.png\n' >"$tmp/my box.mtl"
check "an image is taken from beside the scene" with
check "... and a warning says so" grep -q 'is taken from beside the scene, as "my map.png"' "$tmp/err"
tap_done
