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
            if (v.light_sample) sums[light] = f(sums[light] + f(v.light_sample.adds[c]));
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

# Light fields of pixel centres: each sample by itself, against the pixel's planes.
jq 'del(.lens) | .filter.method = "average" | .effects.indirect_bounces = 2 | .sampling.spp = 9 | .image = {width: 40, height: 30} | .layers = ["beauty"] | del(.environment)' \
    "$tmp/document.json" >"$tmp/fields.json"
jq --arg scene "$scene" '.scene = {file: $scene}' "$tmp/fields.json" >"$tmp/fields_job.json"
check "a plan of light fields" http -X POST -H 'Content-Type: application/json' -H 'Accept: application/octet-stream' \
    --data-binary "@$tmp/fields.json" -o "$tmp/plan_fields" "$url/v1/jobs?dry_run=1"
of_field() { "$build/shearwater-worker" --replay "$tmp/plan_fields" --blobs "$tmp/data/objects" "$@"; }
fields() { # X,Y FIELD: its samples, one JSON document a line, into $tmp/pixel.jsonl
    local k
    for k in $(seq 0 8); do of_field "$1" "$k" --field "$2" --json | jq -c . || return 1; done >"$tmp/pixel.jsonl"
}
cat >"$tmp/means.mjs" <<'J'
// Strata by rows as floats to the plane's last bit; rays to a half float's; and each ray's steps.
import { readFileSync } from "node:fs";
const samples = readFileSync(process.argv[2], "utf8").trim().split("\n").map((line) => JSON.parse(line));
const f = Math.fround, light = samples[0].kind === "light stratum";
let failed = samples.length !== 9, bright = 0, blocked = 0;
const same = (what, a, b) => { if (a !== b) { console.log(`${what}: ${a} is not ${b}`); failed = true; } };
if (light) {
    let sum = 0;
    for (let row = 0; row < 3; row++)
        sum = f(sum + [0, 1, 2].reduce((s, k) => f(s + f(samples[3 * row + k].field.adds)), 0));
    same("E", f(sum * f(1 / 9)), f(samples[0].field.pixel_irradiance));
    samples.forEach((s, k) => same(`stratum ${k}`, String(s.field.stratum), String([k % 3, Math.floor(k / 3)])));
    for (const { field } of samples) {
        bright += field.adds > 0;
        blocked += field.visible === false && field.blocked_at < field.distance && field.blocked_by.material !== "";
    }
} else {
    for (let c = 0; c < 3; c++) {
        const mean = samples.reduce((s, r) => s + r.stored[c], 0) / 9, held = samples[0].field.pixel_mean[c];
        if (Math.abs(mean - held) > Math.max(1e-6, mean / 1024)) same(`mean ${c}`, mean, held);
        bright += held > 0;
    }
    for (const s of samples)
        for (let c = 0; c < 3; c++) {
            let sum = 0;
            for (const v of s.path.slice(1)) {
                for (const met of v.meets) sum = f(sum + f(met.adds[c]));
                if (v.light_sample) sum = f(sum + f(v.light_sample.adds[c]));
            }
            same(`ray ${s.sample}'s steps`, sum, f(s.stored[c]));
        }
}
console.log(`${bright} bright, ${blocked} blocked`);
process.exit(failed || bright + blocked === 0 ? 1 : 0);
J
for at in "20,20" "8,10" "31,12" "14,26"; do
    for field in light:0 light:Light_emitter_7 indirect; do
        check "all samples of $field in pixel $at" fields "$at" "$field"
        check "... add up to the pixel's" node "$tmp/means.mjs" "$tmp/pixel.jsonl"
    done
done
check "a stratum's text names light, point and blocker" bash -c "
    '$build/shearwater' replay '$tmp/fields_job.json' 14,26 0 --field light:0 >'$tmp/text'; grep -q 'light 0 \"Light_emitter_7\", a rectangle, point (' '$tmp/text' || { cat '$tmp/text'; exit 1; }
    grep -q 'stratum column 0, row 0 of 3 x 3, jitter (' '$tmp/text' && grep -q '^brings E ' '$tmp/text'"
check "a bounce ray's text tells where it goes on" bash -c "
    '$build/shearwater' replay '$tmp/fields_job.json' 20,20 4 --field indirect >'$tmp/text'
    grep -q '^bounce ray 4: stratum column 1, row 1' '$tmp/text' && grep -q '^1: from (' '$tmp/text' && grep -q \"^the pixel's mean of all: \" '$tmp/text'"

# Beside paths, of a glossy floor: lobes' rays, and those of second sets, which pixels have as many of as
# the layer of samples tells.
node tests/bench/scene_files.mjs glossy_floor 9 "$tmp" || exit 1
cp "$tmp/plan_fields" "$tmp/plan_alone"
jq --arg file "$tmp/glossy_floor.glb" '.scene = {file: $file, lights: false, camera: .scene.camera} |
    .image = {width: 40, height: 30} | .sampling = {spp: 9, seed: 7} | .effects.indirect_bounces = 2 |
    .filter = {indirect: "adaptive"} | .layers = ["beauty"]' "$tmp/glossy_floor.json" >"$tmp/glossy_job.json"
glossy=$(sha256sum "$tmp/glossy_floor.glb" | cut -d' ' -f1)
check "a glossy floor is there" http -T "$tmp/glossy_floor.glb" "$url/v1/assets/$glossy"
jq --arg asset "$glossy" '.scene.asset = $asset | del(.scene.file)' "$tmp/glossy_job.json" >"$tmp/glossy.json"
check "its plan" http -X POST -H 'Content-Type: application/json' -H 'Accept: application/octet-stream' \
    --data-binary "@$tmp/glossy.json" -o "$tmp/plan_fields" "$url/v1/jobs?dry_run=1"
first=$(of_field 20,20 0 --field indirect --json | jq '.samples[1]')
lobe() { # of the floor: every sample, and all of them against the pixel's mean
    local k
    for k in $(seq 0 "$first"); do of_field 20,24 "$k" --field glossy --json | jq -c . || return 1; done >"$tmp/pixel.jsonl"
    jq -se 'length as $n | [range(3) as $c | (map(.stored[$c]) | add / $n) - .[0].field.pixel_mean[$c] |
        fabs < 0.001] | all' "$tmp/pixel.jsonl" &&
        jq -se '(map(.stored[0]) | add > 0) and all(.kind == "glossy ray" and .field.reflectance[0] > 0)' "$tmp/pixel.jsonl"
}
check "rays of a lobe add up to the pixel's" lobe
second() { of_field 20,24 "$1" --field "$2" --pass 1 --side 3 --json; }
check "those of a second set" bash -c "$(declare -f second of_field); build='$build' tmp='$tmp'
    second 8 glossy | jq -e '.samples == [0, 8] and .field.pass == 1 and .field.side == 3 and .field.at != null' &&
    second 8 indirect | jq -e '.kind == \"bounce ray\" and .field.stratum == [2, 2]'"
check "... have numbers of their own" test "$(second 4 indirect | jq -c .field.at)" != "$(of_field 20,24 4 --field indirect --json | jq -c .field.at)"
check "shearwater replay has them, too" bash -c "'$build/shearwater' replay '$tmp/glossy_job.json' 20,24 8 --field glossy --pass 1 --side 3 --json >'$tmp/one.json'
    '$build/shearwater-worker' --replay '$tmp/plan_fields' --blobs '$tmp/data/objects' 20,24 8 --field glossy --pass 1 --side 3 --json | cmp - '$tmp/one.json'"
# Thin wires: sub-samples shaded on their own are no samples of the pixel's.
node --input-type=module -e '
import { writeFileSync } from "node:fs";
import { wires, job } from "./tests/bench/scenes/wires.mjs";
writeFileSync(`${process.argv[1]}/wires.glb`, wires());
writeFileSync(`${process.argv[1]}/wires.json`, JSON.stringify(job(`${process.argv[1]}/wires.glb`)));' "$tmp"
beside_lone() { # pixels where wires pass beside the centre, and two where none does
    local x k
    for x in 90 91 97 98; do
        for k in 0 1 2 3 4 5 6 7 8; do
            "$build/shearwater" replay "$tmp/wires.json" $x,96 $k --field indirect --json | jq -c . || return 1
        done >"$tmp/pixel.jsonl"
        jq -se '[range(3) as $c | (map(.stored[$c]) | add / 9) - .[0].field.pixel_mean[$c] | fabs < 0.001] | all' "$tmp/pixel.jsonl" ||
            { jq -c '[.stored, .field.pixel_mean]' "$tmp/pixel.jsonl"; return 1; }
    done
}
check "rays of pixels with lone sub-samples add up to the pixels' own" beside_lone
none_of() { # WORDS ARGUMENTS...
    local words=$1; shift
    ! of_field "$@" 2>"$tmp/said" && grep -q -- "$words" "$tmp/said" || { cat "$tmp/said"; return 1; }
}
check "... if the pixel's side is said" none_of "say how many rays the pixel got in it: --side L of L x L" 20,24 0 --field indirect --pass 1
check "a light whose light paths bring" none_of "paths bring that light: ask without --field. Fields there are: indirect" 20,24 0 --field light:0

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
cp "$tmp/plan_alone" "$tmp/plan_fields"
check "a stratum too many" none_of "the field has samples 0 to 8 (3 x 3)" 0,0 9 --field light:0
check "a light that is not there" none_of 'no light 1 but 1 of them; fields there are: light:0 "Light_emitter_7"' 0,0 0 --field light:1
check "a light by another name" none_of 'no light of the plan is called "Sun"' 0,0 0 --field light:Sun
check "a field that the plan has skipped" none_of "no surface has a glossy lobe.*indirect (samples 0 to 8)" 0,0 0 --field glossy
check "no field" none_of '"lens" is no field: light:N, light:NAME, indirect and glossy are' 0,0 0 --field lens
check "a later pass of a plan without" none_of "rays are all of pass 0" 0,0 0 --field indirect --pass 1 --side 2
check "a pass without a field" none_of "needs --field" 0,0 0 --pass 1
check "fields of a plan of paths" refused "paths bring that light: ask without --field" 0,0 0 --field light:0
check "blobs elsewhere" bash -c "! '$build/shearwater-worker' --replay '$tmp/plan' --blobs '$tmp' --cache '$tmp/none' 0,0 0 2>'$tmp/said' && grep -q 'is neither in' '$tmp/said'"
head -c 200 "$tmp/plan" >"$tmp/cut"
check "half a plan" bash -c "! '$build/shearwater-worker' --replay '$tmp/cut' 0,0 0 2>'$tmp/said' && grep -q 'no plan of this version' '$tmp/said'"
jq 'del(.lens, .environment) | .filter.method = "auto" | .effects.indirect_bounces = 1' "$tmp/job.json" >"$tmp/field.json"
check "light fields alone have no paths, and say what to ask instead" bash -c "
    ! '$build/shearwater' replay '$tmp/field.json' 0,0 0 2>'$tmp/said' && grep -q 'the plan has no paths' '$tmp/said' &&
    grep -q 'light:0 \"Light_emitter_7\" (samples 0 to 15), indirect (samples 0 to 15)' '$tmp/said'"
jq 'del(.environment) | .filter.method = "auto" | .effects.indirect_bounces = 1 | .sampling.spp = 9 | .sampling.lens_extra = 9 | .layers = ["beauty"]' "$tmp/job.json" >"$tmp/lens.json"
check "a lens's light field has samples" bash -c "'$build/shearwater' replay '$tmp/lens.json' 2,1 8 --json | jq -e '.kind == \"lens sample\" and .lens_point and (.path | length) > 0'"
check "... and those of second sets" bash -c "'$build/shearwater' replay '$tmp/lens.json' 2,1 256 --json | jq -e '.kind == \"lens sample of a second set\" and .samples == [256, 291]'"
serve_stop
tap_done
