#!/usr/bin/env bash
# A pixel's samples, replayed one by one, are those that its picture is made of: their sum over their
# number is the EXR's value to the last bit. What is printed holds together, and what is not there is
# refused.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/replay.sh BUILD_DIR}
. tests/tap.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb

cat >"$tmp/job.json" <<J
{"scene": {"file": "$scene"}, "image": {"width": 5, "height": 3}, "sampling": {"spp": 16, "seed": 11},
 "filter": {"method": "none"}, "effects": {"indirect_bounces": 5}, "environment": {"radiance": [0.1, 0.2, 0.3]},
 "lens": {"aperture_radius": 0.1, "focus_distance": 6}, "frames": {"first": 4}, "layers": ["beauty", "direct", "indirect", "emission"]}
J
check "the picture" "$build/shearwater" render "$tmp/job.json" --quiet --workers 1 --worker-threads 1 -o "$tmp/job.exr"

# The plan as workers get it, of a running coordinator.
serve_start "$tmp/data" --workers 0 || { echo "Bail out! the server did not start"; exit 1; }
http() { curl -sSf --noproxy '*' "$@"; }
asset=$(sha256sum "$scene" | cut -d' ' -f1)
check "the scene is there" http -T "$scene" "$url/v1/assets/$asset"
jq --arg asset "$asset" '.scene = {asset: $asset}' "$tmp/job.json" >"$tmp/document.json"
plan() { # MORE-ARGUMENTS...
    http -X POST -H 'Content-Type: application/json' --data-binary "@$tmp/document.json" "$@" "$url/v1/jobs?dry_run=1"
}
check "a dry run gives the plan as workers get it" plan -H 'Accept: application/octet-stream' -o "$tmp/plan"
check "... to who asks for it alone" bash -c "$(declare -f http plan); tmp='$tmp' url='$url'; plan -H 'Accept: application/json, application/octet-stream' | jq -e .plan.integrator"
replay() { "$build/shearwater-worker" --replay "$tmp/plan" --blobs "$tmp/data/objects" "$@"; }
pixel() { # X,Y: its samples, one JSON document a line, into $tmp/pixel.jsonl
    local k
    for k in $(seq 0 15); do replay "$1" "$k" --json | jq -c . || return 1; done >"$tmp/pixel.jsonl"
}

cat >"$tmp/sums.mjs" <<'J'
// The samples' sums, added up as floats in their order, against the EXR's pixel; and each sample's
// radiance against what its vertices tell.
import { readFileSync } from "node:fs";
const [lines, exr] = process.argv.slice(2).map((path) => readFileSync(path, "utf8"));
const samples = lines.trim().split("\n").map((line) => JSON.parse(line)), pixel = JSON.parse(exr);
const f = Math.fround, layers = { radiance: "", direct: "direct.", indirect: "indirect.", emission: "emission." };
let failed = samples.length !== 16, steps = 0;
const same = (what, a, b) => { if (a !== b) { console.log(`${what}: ${a} is not ${b}`); failed = true; } };
for (const [name, layer] of Object.entries(layers))
    ["R", "G", "B"].forEach((channel, c) => {
        let sum = 0;
        for (const s of samples) sum = f(sum + f(s[name][c]));
        same(`${layer}${channel}`, f(sum / 16), f(pixel[layer + channel]));
    });
for (const s of samples)
    for (let c = 0; c < 3; c++) {
        const sums = [0, 0, 0]; // emission, direct, indirect
        s.path.forEach((v, depth) => {
            for (const met of v.meets) sums[Math.min(depth, 2)] = f(sums[Math.min(depth, 2)] + f(met.adds[c]));
            const light = Math.min(depth + 1, 2);
            for (const sample of v.light_samples) sums[light] = f(sums[light] + f(sample.adds[c]));
            steps++;
        });
        same(`sample ${s.sample}'s steps`, f(f(sums[0] + sums[1]) + sums[2]), f(s.radiance[c]));
    }
console.log(`${steps / 3} vertices`);
process.exit(failed || steps === 0 ? 1 : 0);
J
for at in "0,0" "2,1" "4,2" "2,2"; do
    check "all samples of pixel $at" pixel "$at"
    "$build/tests/bench/exr_pixel" "$tmp/job.exr" "${at%,*}" "${at#*,}" >"$tmp/pixel.json"
    check "... add up to the picture's, to the last bit" node "$tmp/sums.mjs" "$tmp/pixel.jsonl" "$tmp/pixel.json"
done

# For people, of a job document.
check "shearwater replay does the same" bash -c "'$build/shearwater' replay '$tmp/job.json' 2,1 7 --json >'$tmp/one.json'"
check "... byte by byte" bash -c "'$build/shearwater-worker' --replay '$tmp/plan' --blobs '$tmp/data/objects' 2,1 7 --json | cmp - '$tmp/one.json'"
check "another frame is another sample" bash -c "'$build/shearwater' replay '$tmp/job.json' 2,1 7 --json --frame 5 | jq -e --slurpfile one '$tmp/one.json' '.frame == 5 and \$one[0].frame == 4 and .image_point != \$one[0].image_point'"
check "its text names what was hit" bash -c "
    '$build/shearwater-worker' --replay '$tmp/plan' --blobs '$tmp/data/objects' 2,1 7 >'$tmp/text' &&
    grep -q 'hits instance [0-9]* \".*material' '$tmp/text' && grep -q '^radiance (' '$tmp/text' && grep -q '^ends: ' '$tmp/text'"

# What is not there.
refused() { # WORDS ARGUMENTS...
    local words=$1; shift
    ! replay "$@" 2>"$tmp/said" && grep -q -- "$words" "$tmp/said" || { cat "$tmp/said"; return 1; }
}
check "a pixel outside" refused "5,0 is outside the image of 5x3" 5,0 0
check "a sample too many" refused "samples 0 to 15" 0,0 16
check "no pixel" refused "is not X,Y" 1 0
check "no number" refused "is not a number" 1,1 0x
check "a missing sample" refused "a pixel X,Y and a sample's number must follow" 1,1
check "blobs elsewhere" bash -c "! '$build/shearwater-worker' --replay '$tmp/plan' --blobs '$tmp' --cache '$tmp/none' 0,0 0 2>'$tmp/said' && grep -q 'is neither in' '$tmp/said'"
head -c 200 "$tmp/plan" >"$tmp/cut"
check "half a plan" bash -c "! '$build/shearwater-worker' --replay '$tmp/cut' 0,0 0 2>'$tmp/said' && grep -q 'no plan of this version' '$tmp/said'"
jq 'del(.lens, .environment) | .filter.method = "auto" | .effects.indirect_bounces = 1' "$tmp/job.json" >"$tmp/field.json"
check "light fields alone have no paths, and say what to ask instead" bash -c "
    ! '$build/shearwater' replay '$tmp/field.json' 0,0 0 2>'$tmp/said' && grep -q 'the plan has no paths' '$tmp/said' &&
    grep -q 'filter.method \"none\" asks for paths' '$tmp/said'"
jq 'del(.environment) | .filter.method = "auto" | .effects.indirect_bounces = 1 | .sampling.spp = 9 | .sampling.lens_extra = 9 | .layers = ["beauty"]' "$tmp/job.json" >"$tmp/lens.json"
check "a lens's light field has samples" bash -c "'$build/shearwater' replay '$tmp/lens.json' 2,1 8 --json | jq -e '.kind == \"lens sample\" and .lens_point and (.path | length) > 0'"
check "... and those of second sets" bash -c "'$build/shearwater' replay '$tmp/lens.json' 2,1 256 --json | jq -e '.kind == \"lens sample of a second set\" and .samples == [256, 291]'"
# A worker that a signal ends says nothing by itself.
mkdir "$tmp/bin"
ln -s "$PWD/web" "$tmp/web"
cp "$build/shearwater" "$tmp/bin/"
ln -s "$(realpath "$build")/shearwater-import" "$tmp/bin/"
printf '#!/bin/sh\nkill -SEGV $$\n' >"$tmp/bin/shearwater-worker"
chmod +x "$tmp/bin/shearwater-worker"
check "a worker that crashes is told of" bash -c "! '$tmp/bin/shearwater' replay '$tmp/job.json' 0,0 0 2>'$tmp/said' && grep -q 'ended by signal 11' '$tmp/said'"
serve_stop
tap_done
