#!/usr/bin/env bash
# What is narrower than a pixel: sub-samples that no pixel around them shows are shaded on their own.
# Their light is that of paths, and their bytes do not depend on who traced what.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/lone.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
command -v node >/dev/null || { skip "lone sub-samples" "needs node"; tap_done; }
node --input-type=module -e '
import { writeFileSync } from "node:fs";
import { wires, fence, job } from "./tests/bench/scenes/wires.mjs";
for (const [name, glb] of [["wires", wires()], ["fence", fence()]]) {
    writeFileSync(`${process.argv[1]}/${name}.glb`, glb);
    writeFileSync(`${process.argv[1]}/${name}.json`, JSON.stringify(job(`${process.argv[1]}/${name}.glb`)));
}' "$tmp"

# Beside converged light at the same points of the picture, with the list and without it.
judged() { # NAME BEFORE_MIN AFTER_MAX
    [ -e "$tmp/$1.blob" ] || "$build/shearwater-import" --root "$tmp" --in "$1.glb" --out "$tmp/$1.blob" >/dev/null || return 1
    jq '.scene.asset = "0" * 64 | del(.scene.file)' "$tmp/$1.json" >"$tmp/$1-blob.json"
    "$build/tests/bench/exr_lone" "$tmp/$1.blob" "$tmp/$1-blob.json" 36 1 | tee "$tmp/$1.judged"
    jq -e --argjson before "$2" --argjson after "$3" '.lone > 0.02 and .before > $before and .after < $after' "$tmp/$1.judged"
}
like_paths() { # NAME PERCENT: all light together, and that of squares of 16 pixels
    figure "$1-paths" "$1" | tee /dev/stderr |
        jq -e --argjson p "$2" '.finite and ([.ratio[] | values | (. - 1 | fabs) < $p / 100] | length == 3 and all)' || return 1
    figure "$1-paths" "$1" --box 16 | tee /dev/stderr | jq -e '.rmse < 0.04'
}
for name in wires fence; do
    check "$name: nine light samples a pixel" render $name $name
    check "... of sub-samples that nobody shows all are shaded, and none is left" counts $name '
        .pixels.sub_samples_lone > 4000 and .pixels.sub_samples_unmatched == 0 and .rays.lone > 0'
    jq '.filter.method = "none" | .sampling.seed = 8' "$tmp/$name.json" >"$tmp/$name-none.json"
    check "... paths" render $name-none $name-paths --spp 128
    check "... the light is that of paths within 0.5 %" like_paths $name 0.5
done
check "wires: the error of their light falls to less than a third" judged wires 0.5 0.2
check "fence: the same, to less than a fifth" judged fence 0.6 0.15

# The same bytes for any tile size, number of workers and threads.
for cut in "16 1" "24 2" "64 2"; do
    set -- $cut
    jq --argjson t "$1" '.sampling.tile_px = $t' "$tmp/wires.json" >"$tmp/wires-$1.json"
    check "tiles of $1 px, $2 workers" render wires-$1 wires-$1 --workers $2
    check "... the same bytes" cmp "$tmp/wires.exr" "$tmp/wires-$1.exr"
done

# Layers are sums.
jq '.layers = ["beauty", "direct", "indirect", "albedo"]' "$tmp/fence.json" >"$tmp/layers.json"
check "with layers" render layers layers
layers_add_up() {
    local x
    for x in 100,150 60,140 200,160 128,120; do
        "$build/tests/bench/exr_pixel" "$tmp/layers.exr" ${x%,*} ${x#*,} |
            jq -e '([.R, .G, .B] | add) as $all | ([."direct.R", ."direct.G", ."direct.B", ."indirect.R", ."indirect.G", ."indirect.B"] | add) as $sum
                | $all > 0 and ($all - $sum | fabs) < 1e-4 * $all' || return 1
    done
}
check "... direct and indirect light add up to the picture" layers_add_up

# What needs none has none.
jq '.lens = {aperture_radius: 0.05, focus_distance: 3.1}' "$tmp/fence.json" >"$tmp/lens.json"
jq -n --arg scene "$PWD/tests/scenes/cornell-box/cornell-box.glb" \
    '{scene: {file: $scene}, image: {width: 160, height: 160}, sampling: {spp: 4, seed: 3}}' >"$tmp/box.json"
check "a box of large walls" render box box
check "... has next to none" counts box '.pixels.sub_samples_lone < 20'

# Paths beside light fields bring direct light; the list has indirect light alone.
node --input-type=module -e '
import { readFileSync, writeFileSync } from "node:fs";
const glb = readFileSync(process.argv[1]), length = glb.readUInt32LE(12);
const document = JSON.parse(glb.subarray(20, 20 + length));
for (const m of document.materials) if (m.name !== "back") m.pbrMetallicRoughness = { ...m.pbrMetallicRoughness, metallicFactor: 0.5, roughnessFactor: 0.4 };
for (const m of document.materials) delete m.extensions;
let text = JSON.stringify(document);
text += " ".repeat((4 - text.length % 4) % 4);
const head = Buffer.from(glb.subarray(0, 20)), rest = glb.subarray(20 + length);
head.writeUInt32LE(20 + text.length + rest.length, 8);
head.writeUInt32LE(text.length, 12);
writeFileSync(process.argv[2], Buffer.concat([head, Buffer.from(text), rest]));' "$tmp/fence.glb" "$tmp/metal.glb"
jq --arg f "$tmp/metal.glb" '.scene.file = $f | .sampling.spp = 36 | .filter.indirect = "constant"' "$tmp/fence.json" >"$tmp/metal.json"
jq '.filter.method = "none" | .sampling.seed = 8' "$tmp/metal.json" >"$tmp/metal-none.json"
check "a fence of half-glossy laths, with paths" render metal metal
check "... whose lone sub-samples have indirect light and lobes" counts metal '
    .pixels.sub_samples_lone > 4000 and .rays.paths > 0 and .rays.lone > 0'
check "... paths alone" render metal-none metal-paths --spp 128
check "... the light is that of paths within 1 %" like_paths metal 1

# A target is reached with them.
jq '.scene.file |= . | .sampling = {spp: 16, seed: 5, target_error: 0.03, max_spp: 64}' "$tmp/metal.json" >"$tmp/target.json"
check "a frame with a target" render target target
check "... has them, too" counts target '.pixels.sub_samples_lone > 4000 and .target.rounds > 0'

# What lies about them is refused, and the picture stays what it is.
data=$tmp/data
check "a coordinator starts" serve_start "$data" --workers 0
refused() {
    local id real
    timeout 60 "$build/tests/fake/fake_worker" --connect "unix:$data/worker.sock" --script lone --name liar >"$tmp/liar.log" 2>&1 &
    track $!
    "$build/shearwater-worker" --connect "unix:$data/worker.sock" --threads 1 --name real --cache "$data/cache" >"$tmp/real.log" 2>&1 &
    real=$!
    track $real
    eventually 10 workers_are "liar real"
    id=$("$build/shearwater" submit "$tmp/wires.json" --server "$url" --quiet) || return 1
    await_state "$id" finished 60 || { cat "$tmp/liar.log"; return 1; }
    curl -sSf --noproxy '*' -o "$tmp/refused.exr" "$url/v1/jobs/$id/frames/1/image.exr" || return 1
    kill $real; wait $real
    curl -sS --noproxy '*' "$url/metrics" | awk '/results_total.*corrupt/ {n = $2} END {exit !(n > 0)}' || return 1
    cmp "$tmp/wires.exr" "$tmp/refused.exr"
}
check "hostile lists are refused, and change no byte" refused
says() { # JOB SENTENCE
    "$build/shearwater" submit "$tmp/$1.json" --dry-run --server "$url" | tee /dev/stderr |
        jq -e --arg s "$2" '[.. | objects | select(.what? == "lone sub-samples") | .why] == [$s]'
}
plans() { "$build/shearwater" submit "$tmp/$1.json" --dry-run --server "$url" | tee /dev/stderr | jq -e '[.. | .planes? | values | index("lone")] | any(. != null)'; }
check "the plan says so where there are such sub-samples" plans wires
check "... with a lens why not" says lens "the camera has a lens: its samples make the picture"
check "... and with paths alone" says fence-none "there are no sub-samples: paths go through all of a pixel"
check "... the coordinator ends in order" serve_stop
tap_done
