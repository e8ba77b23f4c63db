#!/usr/bin/env bash
# The program that runs a denoiser's network: networks that pass their inputs on give pictures that are known.
#   tests/system/unet.sh BUILD_DIR
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/unet.sh BUILD_DIR}
. tests/tap.bash

unet=$build/tests/bench/exr_unet
# Neither side is a multiple of 16.
job() { # LAYERS
    cat <<J
{"scene": {"file": "$PWD/tests/scenes/cornell-box/cornell-box.glb"}, "image": {"width": 50, "height": 37},
 "sampling": {"spp": 4, "seed": 1}, "effects": {"indirect_bounces": 2}, "filter": {"method": "none"}, "layers": $1}
J
}
inputs() {
    job '["beauty", "albedo", "normal"]' >"$tmp/guided.json" && job '["beauty"]' >"$tmp/plain.json" &&
        "$build/shearwater" render "$tmp/guided.json" --quiet -o "$tmp/guided.exr" &&
        "$build/shearwater" render "$tmp/plain.json" --quiet -o "$tmp/plain.exr" || return 1
    local first
    for first in 0 3 6; do node tests/system/pass_weights.mjs $first "$tmp/$first.tza" || return 1; done
}
check "pictures and weights" inputs
check "layers that guide change no light" bash -c "'$build/shearwater' compare '$tmp/plain.exr' '$tmp/guided.exr' | jq -e '.rmse == 0'"

check "a network that passes colours gives the picture back" bash -c "'$unet' '$tmp/0.tza' '$tmp/guided.exr' '$tmp/colour.exr' >'$tmp/said' &&
    jq -e '.cpu_s >= 0 and .exposure > 0' '$tmp/said' && '$build/shearwater' compare '$tmp/guided.exr' '$tmp/colour.exr' | jq -e '.width == 50 and .height == 37 and .rmse < 1e-4 * .mean_reference[0] and .mean_test[2] > 0'"
check "... by each instruction set" bash -c "for isa in sse4.2 avx2; do SHEARWATER_ISA=\$isa '$unet' '$tmp/0.tza' '$tmp/guided.exr' '$tmp/again.exr' >/dev/null &&
    '$build/shearwater' compare '$tmp/colour.exr' '$tmp/again.exr' | jq -e '.rmse == 0' || exit 1; done"
check "half floats are near" bash -c "'$unet' '$tmp/0.tza' '$tmp/guided.exr' '$tmp/half.exr' half >/dev/null &&
    '$build/shearwater' compare '$tmp/colour.exr' '$tmp/half.exr' | jq -e '.rmse > 0 and .rmse < 1e-3'"

# Guides come out through the colours' curve: 0 to 1 of a light of 65504, over the exposure.
guide() { # FIRST CHANNELS, as albedo.R,albedo.G,albedo.B
    "$unet" "$tmp/$1.tza" "$tmp/guided.exr" "$tmp/guide.exr" >"$tmp/said" || return 1
    node --input-type=module -e '
        import { execFileSync } from "node:child_process";
        import assert from "node:assert/strict";
        const [program, tmp, first, names, exposure] = process.argv.slice(1);
        const pixel = (file, x, y) => JSON.parse(execFileSync(program, [`${tmp}/${file}.exr`, String(x), String(y)], { encoding: "utf8" }));
        const most = 1.92653254e-01 * Math.log(65504 + 6.26026094e-03) + 9.98620152e-01;
        const inverse = (tone) => { const x = tone * most; return x <= 2.23151711e-03 ? x / 1.41283765e+03
            : x <= 3.70974749e-01 ? ((x + 2.94139609e-03) / 1.64593172) ** (1 / 4.31384981e-01) : Math.exp((x - 9.98620152e-01) / 1.92653254e-01) - 6.26026094e-03; };
        const told = (v) => first === "6" ? 0.5 * v + 0.5 : Math.min(Math.max(v, 0), 1);
        for (const [x, y] of [[0, 0], [5, 20], [25, 33], [44, 18], [49, 36]]) {
            const from = pixel("guided", x, y), to = pixel("guide", x, y);
            names.split(",").forEach((name, i) => {
                const want = inverse(told(from[name])) / exposure, got = to["RGB"[i]];
                assert.ok(Math.abs(got - want) <= 1e-3 * want + 1e-9, `${name} at ${x},${y}: ${got}, not ${want}`);
            });
        }' "$build/tests/bench/exr_pixel" "$tmp" "$1" "$2" "$(jq .exposure "$tmp/said")"
}
check "the network is given albedo" guide 3 albedo.R,albedo.G,albedo.B
check "the network is given normals, from 0 to 1" guide 6 normal.X,normal.Y,normal.Z

refused() { # STATUS WORDS ARGUMENTS...
    local status=$1 words=$2 got
    shift 2
    "$unet" "$@" >/dev/null 2>"$tmp/said"
    got=$?
    [ $got -eq "$status" ] && grep -q "$words" "$tmp/said" && [ ! -e "$tmp/none.exr" ]
}
head -c 20000 "$tmp/0.tza" >"$tmp/cut.tza"
check "weights that are cut off are refused" refused 1 "cut.tza: the archive ends within" "$tmp/cut.tza" "$tmp/guided.exr" "$tmp/none.exr"
check "what are no weights is refused" refused 1 "it begins with" "$tmp/guided.exr" "$tmp/guided.exr" "$tmp/none.exr"
check "a picture without guides is refused" refused 1 "lacks one of the layers" "$tmp/0.tza" "$tmp/plain.exr" "$tmp/none.exr"
check "a picture that is not there is refused" refused 1 "nowhere.exr" "$tmp/0.tza" "$tmp/nowhere.exr" "$tmp/none.exr"
check "other words are refused" refused 2 usage "$tmp/0.tza" "$tmp/guided.exr" "$tmp/none.exr" whole
tap_done
