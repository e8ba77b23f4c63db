#!/usr/bin/env bash
# Environment maps from the job file to the picture: uploaded, imported, fetched by workers, the
# same light as an environment of one radiance; what cannot be one is refused where it stands.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/environment.sh BUILD_DIR}
. tests/tap.bash
box=$PWD/tests/scenes/cornell-box/cornell-box.glb

# map TEXELS...: an .hdr two texels high and as wide as half of them, RGBE in hexadecimal.
map() {
    printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X %d\n' $(($# / 2))
    for texel in "$@"; do printf "$(sed 's/../\\x&/g' <<<"$texel")"; done
}
one=80808081 black=00000000
mkdir "$tmp/maps"
map $one $one $one $one $one $one $one $one >"$tmp/maps/one.hdr"
map $black $black $black $one $black $black $black $black >"$tmp/maps/left.hdr"

# job ENVIRONMENT: the box in the dark but for it. (Its lamp lights nothing and is seen all the same.)
job() {
    echo "{\"scene\": {\"file\": \"$box\", \"lights\": false}, \"environment\": $1,
        \"image\": {\"width\": 64, \"height\": 64}, \"effects\": {\"indirect_bounces\": 2},
        \"sampling\": {\"spp\": 64}, \"layers\": [\"beauty\", \"direct\"]}"
}
render() { "$build/shearwater" render "$1" --quiet -o "$2" "${@:3}"; }

job '{"file": "maps/one.hdr"}' >"$tmp/map.json"
job '{"radiance": [1, 1, 1]}' >"$tmp/constant.json"
check "a map beside the job file is rendered" render "$tmp/map.json" "$tmp/map.exr" --workers 1 --stats "$tmp/stats.json"
check "... by paths" jq -e '.rays.paths >= 64 * 64 * 64 and .rays.paths <= 64 * 64 * 128' "$tmp/stats.json"
check "two workers give the same bytes" render "$tmp/map.json" "$tmp/two.exr" --workers 2 --tile 16
check "... all of them" cmp "$tmp/map.exr" "$tmp/two.exr"
check "an environment of one radiance is rendered" render "$tmp/constant.json" "$tmp/constant.exr"
alike() { # FILE FILE: their means within 1 %
    "$build/shearwater" compare "$1" "$2" | tee /dev/stderr | jq -e '[.ratio[] | (. > 0.99 and . < 1.01)] | all'
}
check "a map of one radiance lights as that radiance does" alike "$tmp/constant.exr" "$tmp/map.exr"

job '{"asset": "'"$(printf '%064d' 7)"'", "intensity": 1}' >"$tmp/override.json"
check "--environment stands in for the job's" render "$tmp/override.json" "$tmp/override.exr" -e "$tmp/maps/one.hdr"
check "... with the same bytes" cmp "$tmp/map.exr" "$tmp/override.exr"
check "--bounces 0 and --spp 16 change the picture's plan" render "$tmp/map.json" "$tmp/few.exr" \
    --bounces 0 --spp 16 --stats "$tmp/stats.json"
check "... to 16 paths that end after their first scattering" \
    jq -e '.rays.paths >= 64 * 64 * 16 and .rays.paths <= 64 * 64 * 32' "$tmp/stats.json"

# The map turns: what shone along one direction then shines along another.
job '{"file": "maps/left.hdr"}' >"$tmp/left.json"
job '{"file": "maps/left.hdr", "rotation_deg": -90}' >"$tmp/turned.json"
job '{"file": "maps/left.hdr", "intensity": 2}' >"$tmp/bright.json"
for name in left turned bright; do
    check "the map $name is rendered" render "$tmp/$name.json" "$tmp/$name.exr"
done
differ() { cmp -s "$1" "$2"; [ $? -eq 1 ]; } # 2: one is not there
check "a turned map is another picture" differ "$tmp/left.exr" "$tmp/turned.exr"
doubled() {
    "$build/shearwater" compare --layer direct "$tmp/left.exr" "$tmp/bright.exr" | tee /dev/stderr |
        jq -e '[.ratio[] | (. - 2 | fabs) < 1e-4] | all'
}
check "intensity 2 is twice the light" doubled

refused() { # JOB POINTER WORDS
    render "$1" "$tmp/refused.exr" 2>"$tmp/refused.log" && return 1
    cat "$tmp/refused.log"
    grep -q "$2: .*$3" "$tmp/refused.log" && [ ! -e "$tmp/refused.exr" ]
}
job '{"file": "maps/none.hdr"}' >"$tmp/none.json"
check "a map that is not there is named" refused "$tmp/none.json" /environment/file none.hdr
job "{\"file\": \"$box\"}" >"$tmp/box.json"
check "a scene is no map" refused "$tmp/box.json" /environment/asset "no environment map"
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\nfew' >"$tmp/maps/cut.hdr"
job '{"file": "maps/cut.hdr"}' >"$tmp/cut.json"
check "a map that is cut off is refused" refused "$tmp/cut.json" /environment/asset ""
echo "{\"scene\": {\"file\": \"maps/one.hdr\"}}" >"$tmp/scene.json"
check "a map is no scene" refused "$tmp/scene.json" /scene/asset "no scene"
job '{"file": "maps/one.hdr", "asset": "x"}' >"$tmp/both.json"
check "a file and an asset are one too many" refused "$tmp/both.json" /environment "not both"

# A coordinator whose workers share no folder with it: the map comes over the link.
check "a coordinator starts" serve_start "$tmp/data" --workers 0
"$build/shearwater-worker" --connect "unix:$tmp/data/worker.sock" --threads 1 --cache "$tmp/cache" >"$tmp/worker.log" 2>&1 &
track $!
id=$("$build/shearwater" submit "$tmp/map.json" --server "$url" --quiet)
check "a job with a map finishes far away" await_state "$id" finished 60
curl -sSf --noproxy '*' -o "$tmp/far.exr" "$url/v1/jobs/$id/frames/1/image.exr"
check "... with the same bytes" cmp "$tmp/map.exr" "$tmp/far.exr"
check "... and its document names the asset" bash -c "curl -sS --noproxy '*' '$url/v1/jobs/$id' |
    jq -e --arg map '$(sha256sum <"$tmp/maps/one.hdr" | cut -c1-64)' '.document.environment.asset == \$map
        and .plan.environment.type == \"map\"'"
tap_done
