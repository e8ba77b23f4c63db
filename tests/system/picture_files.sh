#!/usr/bin/env bash
# What a job says of its files: compressions of the EXR, its attributes, and PNG files by views, with 16 bits and alpha.
#   tests/system/picture_files.sh BUILD_DIR
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/picture_files.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
jq -n --arg scene "$PWD/tests/scenes/cornell-box/cornell-box.glb" '{scene: {file: $scene,
    camera: {eye: [0.3, 1.2, 6], target: [0, 1, 0], yfov_deg: 30}}, image: {width: 96, height: 80}, sampling: {spp: 4},
    layers: ["beauty", "normal", "depth"]}' >"$tmp/box.json"

# The EXR: other workers, tiles and blocks change no byte of any compression.
for codec in none zips zip piz dwaa; do
    check "$codec: it renders" render box "$codec" --exr-compression "$codec" --png "$tmp/$codec.png"
    check "$codec: the same bytes from other tiles" env SHEARWATER_BLOCK_PX=32 "$build/shearwater" render "$tmp/box.json" \
        --quiet --workers 2 --tile 16 --exr-compression "$codec" -o "$tmp/again.exr"
    check "$codec: ..." cmp "$tmp/$codec.exr" "$tmp/again.exr"
    check "$codec: PNG files do not depend on it" cmp "$tmp/$codec.png" "$tmp/none.png"
done
header() { exrheader "$tmp/$1.exr" | tr -s ' \n' ' ' | grep -q "$2"; }
check "the header says none" header none '(type compression): none'
check "... zips" header zips '(type compression): zip, individual scanlines'
check "... piz" header piz '(type compression): piz'
check "... dwaa" header dwaa '(type compression): dwa, small scanline blocks'
for codec in zips zip piz; do check "$codec loses nothing" bash -c "'$build/shearwater' compare '$tmp/none.exr' '$tmp/$codec.exr' | jq -e '.max == 0'"; done
near() { figure none dwaa --ssim | jq -e '.max > 0 and .rmse < 0.02 and .ssim > 0.99'; }
check "dwaa loses little of light" near
check "... and nothing of depths" bash -c "'$build/shearwater' compare '$tmp/none.exr' '$tmp/dwaa.exr' --layer depth | jq -e '.max == 0'"
check "it names its primaries" header zip 'chromaticities.*red (0.64 0.33).*white (0.3127 0.329)'
check "... the program" header zip 'software (type string): "Shearwater 0'
check "... and where the camera stood" header zip 'worldToCamera (type m44f).*worldToNDC (type m44f)'
check "the screen's window is that of the field of view" header zip 'screenWindowWidth (type float): 0.643'
unsaid() { ! header zip framesPerSecond; }
check "a still has no rate" unsaid
check "a sequence renders" render box seq --frames 1-2 --fps 29.97
check "... and has one" bash -c "exrheader '$tmp/seq.0002.exr' | grep -q 'framesPerSecond.*30000/1001'"

# Ids for compositors: each figure's half of a pixel is for unit tests to tell.
check "ids come beside the picture" render box crypto --cryptomatte --png "$tmp/crypto.png"
check "... and do not change it" cmp "$tmp/crypto.png" "$tmp/zip.png"
check "... nor its other layers" bash -c "'$build/shearwater' compare '$tmp/zip.exr' '$tmp/crypto.exr' --layer depth | jq -e '.max == 0'"
check "they have ranks" header crypto 'CryptoMaterial02.A, 32-bit floating-point'
check "... and a manifest of names" header crypto 'cryptomatte/3ae39a5/manifest (type string): "{"BackWall":"055c4fd6",'
check "they stay floats among halves, in other tiles" bash -c "jq '.image.pixel_type = \"half\"' '$tmp/box.json' >'$tmp/half.json'"
check "..." render half half --cryptomatte --workers 2 --tile 16
check "..." header half 'CryptoObject00.R, 32-bit'
check "... with the same numbers" bash -c "'$build/shearwater' compare '$tmp/crypto.exr' '$tmp/half.exr' --layer CryptoObject00 | jq -e '.max == 0'"

# PNG files: what a header says at its 25th and 26th byte is bits and kind.
kind() { is "$(od -An -tu1 -j24 -N2 "$1" | xargs)" "$2"; }
same_exr() { render box "$1" "${@:2}" --png "$tmp/$1.png" && cmp "$tmp/zip.exr" "$tmp/$1.exr"; }
check "a view changes no byte of the EXR" same_exr filmic --view filmic
check "... nor does exposure" same_exr bright --exposure 2.5
check "... nor do bits and alpha" same_exr deep --png-bits 16 --png-alpha
check "by itself a PNG has 8 bits and no alpha" kind "$tmp/zip.png" "8 2"
check "16 bits and alpha, where asked" kind "$tmp/deep.png" "16 6"
check "agx is the default" same_exr agx --view agx
check "... as the bytes say" cmp "$tmp/agx.png" "$tmp/zip.png"
unlike() { ! cmp -s "$1" "$2"; }
check "linear is another" bash -c "! cmp -s '$tmp/filmic.png' '$tmp/zip.png'"
says() { ! "$build/shearwater" render "$tmp/box.json" -q "${@:2}" 2>"$tmp/err" && grep -q -- "$1" "$tmp/err" || { cat "$tmp/err"; return 1; }; }
check "a view that is none is refused by its place" says /image/view --view aces
check "an exposure beyond all bounds, too" says /image/exposure --exposure 40
check "... and one that is no number" says 'is no number' --exposure nan
check "bits between the two" says /image/png_bits --png-bits 12
check "ids and numbers that a codec changes" says /image/exr_compression --cryptomatte --exr-compression dwaa
check "a compression that is none" says /image/exr_compression --exr-compression b44

# The service: the job's look unless the query says otherwise, also from a file that lost something.
start
id=$(submit '"image": {"width": 64, "height": 64, "view": "filmic", "exposure": 1, "exr_compression": "dwaa"}, "layers": ["beauty", "albedo"]')
check "a job of another look ends" await_state "$id" finished 120
png() { http -f -o "$tmp/$1.png" "$url/v1/jobs/$id/frames/1/image.png$2"; }
check "its PNG" png own ""
check "... is that of its look, asked for by name" png named "?view=filmic&exposure=1&bits=8&alpha=0"
check "..." cmp "$tmp/own.png" "$tmp/named.png"
check "another view" png other "?view=linear"
check "... is another picture" unlike "$tmp/own.png" "$tmp/other.png"
check "16 bits with alpha" png deep "?bits=16&alpha=1"
check "... are that" kind "$tmp/deep.png" "16 6"
check "albedo" png albedo "?layer=albedo"
check "... through a view" png viewed "?layer=albedo&view=agx"
check "... is albedo" cmp "$tmp/albedo.png" "$tmp/viewed.png"
serve_stop
tap_done
