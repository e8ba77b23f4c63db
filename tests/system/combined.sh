#!/usr/bin/env bash
# Several effects in one frame: each costs where it is, and nothing where it is not; soft shadows and
# indirect light are filtered before the lens, and the picture is that of paths.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/combined.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
# The box without its lamp, whose surfaces are pure Lambert, and with half glossy ones.
node --input-type=module -e '
import { readFileSync, writeFileSync } from "node:fs";
import { glbWithout } from "./tests/bench/scenes/glb.mjs";
const plain = glbWithout(readFileSync("tests/scenes/cornell-box/cornell-box.glb"), /emitter/);
writeFileSync(process.argv[1], plain);
// The same bytes but for the first chunk: its text grows.
const length = plain.readUInt32LE(12), document = JSON.parse(plain.subarray(20, 20 + length));
for (const m of document.materials) m.pbrMetallicRoughness = { ...m.pbrMetallicRoughness, metallicFactor: 0.5, roughnessFactor: 0.4 };
for (const m of document.materials) delete m.extensions;
let text = JSON.stringify(document);
text += " ".repeat((4 - text.length % 4) % 4);
const head = Buffer.from(plain.subarray(0, 20)), rest = plain.subarray(20 + length);
head.writeUInt32LE(20 + text.length + rest.length, 8);
head.writeUInt32LE(text.length, 12);
writeFileSync(process.argv[2], Buffer.concat([head, Buffer.from(text), rest]));
' "$tmp/lambert.glb" "$tmp/glossy.glb"
pixels=$((96 * 80))

cat >"$tmp/all.json" <<J
{"scene": {"file": "$tmp/lambert.glb", "lights": false, "camera": {"eye": [0, 1, 3.2], "target": [0, 0.6, 0], "yfov_deg": 30}},
 "image": {"width": 96, "height": 80}, "sampling": {"spp": 9, "seed": 7}, "layers": ["beauty"]}
J

area='[{"type": "rectangle", "center": [0, 1.95, 0], "half_u": [0.25, 0, 0], "half_v": [0, 0, 0.25], "radiance": [12, 11, 9]}]'
point='[{"type": "point", "position": [0, 1.9, 0], "intensity": [1, 1, 1]}]'

# Every subset of {soft shadows, indirect light, occlusion, glossy surfaces, lens}: what runs and what
# does not. Glossy surfaces without a lens have fields of their diffuse lobes, and paths of the others;
# through a lens they have fields where the residual filter may not clean its samples.
subset() { # SHADOWS INDIRECT OCCLUSION GLOSSY LENS
    local name=s$1-i$2-o$3-g$4-l$5 lights=$point
    [ "$1" = 1 ] && lights=$area
    jq --argjson lights "$lights" --argjson i "$2" --argjson o "$3" --argjson g "$4" --argjson l "$5" --arg glossy "$tmp/glossy.glb" '
        .lights = $lights | .effects.indirect_bounces = $i
        | if $o == 1 then .layers += ["occlusion"] | .effects.ambient_occlusion = {distance: 0.4} else . end
        | if $g == 1 then .scene.file = $glossy else . end
        | if $l == 1 then .lens = {aperture_radius: 0.05, focus_distance: 3.1} else . end
        | if $l == 1 and $g == 1 then .filter.residual = "none" else . end' \
        "$tmp/all.json" >"$tmp/$name.json"
    check "$name" render "$name" "$name"
    # With a lens paths alone have the layer occlusion, and glossy surfaces have no field of shadows.
    local lens=$(($5 == 1 && $3 == 0)) alone=$(($5 == 1 && $3 == 1))
    local covers=$((alone == 0 && ($4 == 0 || $5 == 0)))
    local shadows=$(($1 == 1 && covers == 1)) bounces=$((alone == 0 && $2 == 1))
    local rays=$((alone == 0 && ($2 == 1 || $3 == 1))) glossy=$((lens == 1 && $4 == 1 && $2 == 1))
    local lit=$((lens == 1 && (shadows == 1 || bounces == 1)))
    local paths=$((alone == 1 || ($4 == 1 && lens == 0)))
    check_counts "$name" \
        "... soft shadows" "(.shadow.pixels_filtered > 0) == ($shadows == 1) and (.cpu_s.shadow > 0) == ($shadows == 1)" \
        "... indirect light" "(.indirect.pixels_filtered > 0) == ($rays == 1) and (.cpu_s.indirect > 0) == ($rays == 1)
            and ($2 == 1 or .rays.indirect_shadow == 0)" \
        "... glossy lobes" "(.glossy.pixels_filtered > 0) == ($glossy == 1) and (.cpu_s.glossy > 0) == ($glossy == 1)" \
        "... the lens" "(.rays.lens == $pixels * 9) == ($lens == 1) and (.rays.lens > 0) == ($lens == 1) and (.cpu_s.lens > 0) == ($lens == 1)" \
        "... light of fields at lens samples" "(.lens.samples_lit > 0) == ($lit == 1)
            and (.rays.lens_centres > 0) == ($lit == 1) and (.cpu_s.lens_relight > 0) == ($lit == 1)" \
        "... paths" "(.rays.paths > 0) == ($paths == 1) and ($3 == 1 or .rays.occlusion == 0)"
}
for shadows in 0 1; do for indirect in 0 1; do for occlusion in 0 1; do for glossy in 0 1; do for lens in 0 1; do
    subset $shadows $indirect $occlusion $glossy $lens
done; done; done; done; done
check "without a lens, soft shadows or indirect light nothing is bounced, sheared or averaged" counts s0-i0-o0-g0-l0 "
    .rays.primary == $pixels and .rays.shadow <= $pixels and .rays.indirect == 0"
check "samples that fields light cost one shadow ray a light and pixel, not one each" counts s0-i1-o0-g0-l1 ".rays.shadow < $pixels * 2"

# The picture is that of paths, with less error the more samples there are.
render_reference() {
    jq '.filter.method = "none" | .sampling.seed = 8' "$tmp/s1-i1-o0-g0-l1.json" >"$tmp/paths.json"
    render paths paths --spp 512
}
check "paths" render_reference
for spp in 4 9 36; do check "$spp samples" render s1-i1-o0-g0-l1 n$spp --spp $spp; done
falling() {
    local last=1e9 now
    for spp in 4 9 36; do
        now=$(figure paths n$spp | jq .rmse); echo "$spp: $now"
        awk "BEGIN {exit !($now < $last)}" || return 1
        last=$now
    done
}
check "the error falls with every step" falling
energy() { figure paths n$1 | tee /dev/stderr | jq -e '.finite and ([.ratio[] | values | . > 0.995 and . < 1.005] | all)'; }
for spp in 9 36; do check "$spp samples: the light is that of paths within 0.5 %" energy $spp; done
check "nine samples, each with light of its own" render s1-i1-o0-g0-l1 own --method average --lens sheared --indirect average
quieter() {
    local lit own
    lit=$(figure paths n9 | jq .rmse) own=$(figure paths own | jq .rmse)
    echo "lit by fields $lit, each by itself $own" && awk "BEGIN {exit !($lit * 2.5 < $own)}"
}
check "... have more than 2.5 times the error" quieter

# Glossy surfaces through the lens: the residual filter cleans samples that fields would leave noisy.
clean_glossy() {
    jq 'del(.filter)' "$tmp/s1-i1-o0-g1-l1.json" >"$tmp/glossy.json"
    jq '.filter.method = "none" | .sampling.seed = 8' "$tmp/glossy.json" >"$tmp/glossy-paths.json"
    render glossy-paths glossy-paths --spp 256 && render glossy glossy
}
check "glossy surfaces through the lens" clean_glossy
check "... are cleaned by the residual filter" counts glossy ".residual.pixels_filtered > 0 and .rays.lens == $pixels * 9 and .rays.paths == 0"
cleaner() {
    local cleaned fields
    cleaned=$(figure glossy-paths glossy | jq .rmse) fields=$(figure glossy-paths s1-i1-o0-g1-l1 | jq .rmse)
    echo "cleaned $cleaned, fields of indirect light $fields" && awk "BEGIN {exit !($cleaned * 1.1 < $fields)}"
}
check "... to less of an error" cleaner

# A sky before the open side of the box, and one with a sun in it, through the lens: fields bring what
# of it is soft, paths the sun's light.
node --input-type=module -e '
import { writeFileSync } from "node:fs";
const width = 64, height = 32;
for (const [path, sun] of [[process.argv[1], false], [process.argv[2], true]]) {
    const texels = Buffer.alloc(4 * width * height);
    for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) {
        const bright = sun && y === 10 && x === 48;
        texels.set(bright ? [255, 240, 200, 135] : [60 + 4 * y, 120, 220 - 3 * y, 129], 4 * (y * width + x));
    }
    writeFileSync(path, Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`), texels]));
}' "$tmp/soft.hdr" "$tmp/sun.hdr"
lit_like_paths() { # REFERENCE NAME PERCENT
    figure $1 $2 | tee /dev/stderr | jq -e --argjson p $3 '.finite and ([.ratio[] | values | (. - 1 | fabs) < $p / 100] | all)'
}
falling_sky() { # NAME
    local last=1e9 now
    for spp in 4 9 36; do
        now=$(figure $1-paths $1-n$spp | jq .rmse); echo "$spp: $now"
        awk "BEGIN {exit !($now < $last)}" || return 1
        last=$now
    done
}
for sky in soft sun; do for surface in lambert glossy; do
    name=$sky-$surface
    jq --arg sky "$tmp/$sky.hdr" --arg scene "$tmp/$surface.glb" '.environment = {file: $sky} | .lights = [] | .scene.file = $scene
        | .effects.indirect_bounces = 2 | .lens = {aperture_radius: 0.05, focus_distance: 3.1}' "$tmp/all.json" >"$tmp/$name.json"
    jq '.filter.method = "none" | .sampling.seed = 8' "$tmp/$name.json" >"$tmp/$name-none.json"
    check "$sky sky, $surface surfaces: paths" render $name-none $name-paths --spp 128
    for spp in 4 9 36; do check "... $spp samples that fields light" render $name $name-n$spp --spp $spp; done
    check "... most of them" counts $name-n9 '.lens.samples_lit > 8 * .lens.samples_own'
    check "... the error falls with every step" falling_sky $name
    # Of few samples of the sun's images in glossy surfaces the mean itself is noise of some percent.
    if [ $sky-$surface = sun-glossy ]; then steps=36 percent=1; else steps="9 36" percent=0.5; fi
    for spp in $steps; do check "... $spp samples: the light is that of paths within $percent %" lit_like_paths $name-paths $name-n$spp $percent; done
done; done

# Where lobes end: a floor of stripes two pixels wide, half metal beside metal, which has no diffuse light to
# look up but a lobe, and metal beside black, which has no lobe. What lobes see comes from lobes.
node --input-type=module -e '
import { writeFileSync } from "node:fs";
import { glbOf } from "./tests/bench/scenes/glb.mjs";
const stripes = (first) => {
  const positions = [], normals = [], indices = [], wide = 0.08;
  for (let x = -2, k = 0; x < 2 - 1e-6; x += wide, k++) {
    if (k % 2 !== first) continue;
    const n = positions.length / 3;
    positions.push(x, 0, -2, x + wide, 0, -2, x + wide, 0, 2, x, 0, 2);
    for (let i = 0; i < 4; i++) normals.push(0, 1, 0);
    indices.push(n, n + 2, n + 1, n, n + 3, n + 2);
  }
  return { positions, normals, indices };
};
const wall = { positions: [-2, 0, -2, 2, 0, -2, 2, 2, -2, -2, 2, -2], normals: [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1], indices: [0, 1, 2, 0, 2, 3] };
const metal = (color, metallic) => ({ color: [color, color, color], metallic, roughness: 0.5, specular: 1 });
for (const [path, a, b] of [[process.argv[1], metal(0.6, 0.5), metal(0.6, 1)], [process.argv[2], metal(0.95, 0.9), { color: [0.02, 0.02, 0.02] }]])
  writeFileSync(path, glbOf([{ name: "a", color: a.color, mesh: stripes(0), material: a }, { name: "b", color: b.color, mesh: stripes(1), material: b },
    { name: "wall", color: [0.7, 0.3, 0.2], mesh: wall }]));' "$tmp/metals.glb" "$tmp/black.glb"
for floor in metals black; do
    jq --arg scene "$tmp/$floor.glb" '.scene = {file: $scene, camera: {eye: [0, 2.5, 3], target: [0, 0, 0], yfov_deg: 40}}
        | .environment = {radiance: [1, 1, 1]} | .lights = [] | .effects.indirect_bounces = 2
        | .lens = {aperture_radius: 0.03, focus_distance: 3.9}' "$tmp/all.json" >"$tmp/$floor.json"
    jq '.filter.method = "none" | .sampling.seed = 8' "$tmp/$floor.json" >"$tmp/$floor-none.json"
    check "stripes of $floor: paths" render $floor-none $floor-paths --spp 400
    for spp in 16 64; do
        check "... $spp samples that fields light" render $floor $floor-$spp --spp $spp
        check "... the light is that of paths within 0.3 %" lit_like_paths $floor-paths $floor-$spp 0.3
    done
done
check "no sample that fields light looks for a soft sky" counts soft-lambert-n9 '.rays.shadow < .lens.samples_lit / 40'
check "... but for a sun" counts sun-lambert-n9 '.rays.shadow > .lens.samples_lit / 25'
check "one worker" render sun-glossy a --workers 1 --worker-threads 1 --tile 32
check "three workers, other tiles" render sun-glossy b --workers 3 --tile 16
check "... give the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"

# The box with a mirror for its back wall and another for its right one, which show each other: what they
# show is lit as it is beside them, and counts as many scatterings as paths do.
node --input-type=module -e '
import { readFileSync, writeFileSync } from "node:fs";
const plain = readFileSync(process.argv[1]), length = plain.readUInt32LE(12), document = JSON.parse(plain.subarray(20, 20 + length));
for (const m of document.materials.filter((m) => /BackWall|RightWall/.test(m.name))) {
    m.pbrMetallicRoughness = { metallicFactor: 1, roughnessFactor: 0, baseColorFactor: [0.9, 0.7, 0.8, 1] };
    delete m.extensions;
}
let text = JSON.stringify(document);
text += " ".repeat((4 - text.length % 4) % 4);
const head = Buffer.from(plain.subarray(0, 20)), rest = plain.subarray(20 + length);
head.writeUInt32LE(20 + text.length + rest.length, 8);
head.writeUInt32LE(text.length, 12);
writeFileSync(process.argv[2], Buffer.concat([head, Buffer.from(text), rest]));' "$tmp/lambert.glb" "$tmp/mirror.glb"
for bounces in 2 4; do
    name=mirror-$bounces
    jq --arg sky "$tmp/soft.hdr" --arg scene "$tmp/mirror.glb" --argjson n $bounces '.environment = {file: $sky} | .lights = []
        | .scene.file = $scene | .effects.indirect_bounces = $n | .lens = {aperture_radius: 0.05, focus_distance: 3.1}' "$tmp/all.json" >"$tmp/$name.json"
    jq '.filter.method = "none" | .sampling.seed = 8' "$tmp/$name.json" >"$tmp/$name-none.json"
    # Errors beside those of two bounces are compared, so that its paths must have little of their own.
    check "mirrors, $bounces bounces: paths" render $name-none $name-paths --spp $((bounces == 2 ? 384 : 128))
    for spp in 4 9 36; do check "... $spp samples that fields light" render $name $name-n$spp --spp $spp; done
    check "... through mirrors, too" counts $name-n9 '.rays.lens_mirrors > 0 and .lens.samples_lit > 8 * .lens.samples_own'
    check "... the error falls with every step" falling_sky $name
    for spp in 9 36; do check "... $spp samples: the light is that of paths within 0.5 %" lit_like_paths $name-paths $name-n$spp 0.5; done
done
check "no ray goes on from mirrors where there is none" counts soft-lambert-n9 '.rays.lens_mirrors == 0'
jq '.layers += ["normal"]' "$tmp/mirror-2.json" >"$tmp/mirror-own.json"
check "a layer that shows mirrors' own normals" render mirror-own mirror-own
check "... leaves what they show to paths" counts mirror-own '.rays.lens_mirrors == 0 and .lens.samples_lit > 0'
cleaner() {
    local seen own
    seen=$(figure mirror-2-paths mirror-2-n9 | jq .rmse) own=$(figure mirror-2-paths mirror-own | jq .rmse)
    echo "lit by fields $seen, by paths $own" && awk "BEGIN {exit !($seen * 1.3 < $own)}"
}
check "... with more than 1.3 times the error" cleaner
jq '.lights = [{type: "rectangle", center: [0, 1.9, 0.2], half_u: [0.25, 0, 0], half_v: [0, 0, 0.25], radiance: [12, 11, 9]}]' "$tmp/mirror-2.json" >"$tmp/mirror-light.json"
jq '.filter.method = "none" | .sampling.seed = 8' "$tmp/mirror-light.json" >"$tmp/mirror-light-none.json"
check "a light that mirrors show: paths" render mirror-light-none mirror-light-paths --spp 384
check "... 36 samples that fields light" render mirror-light mirror-light-n36 --spp 36
check "... the light is that of paths within 0.5 %" lit_like_paths mirror-light-paths mirror-light-n36 0.5
check "one worker" render mirror-light a --workers 1 --worker-threads 1 --tile 32
check "three workers, other tiles" render mirror-light b --workers 3 --tile 16
check "... give the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"

# Second sets of paths through the lens, beside samples that fields light.
jq '.sampling.lens_extra = 9' "$tmp/s1-i1-o0-g0-l1.json" >"$tmp/extra.json"
for spp in 9 36; do
    check "$spp samples and second sets" render extra e$spp --spp $spp
    check "... of a quarter of the pixels" counts e$spp ".lens.second_paths == $((pixels / 4 * 36)) and .rays.paths == .lens.second_paths"
    check "... and fields light the first" counts e$spp '.lens.samples_lit > .lens.samples_own'
done
bright() { figure paths e$1 | tee /dev/stderr | jq -e '.finite and ([.ratio[] | values | . > 0.99 and . < 1.01] | all)'; }
for spp in 9 36; do check "$spp samples and second sets: the light is that of paths within 1 %" bright $spp; done
fewer() {
    local with without
    with=$(figure paths e9 | jq .rmse) without=$(figure paths n9 | jq .rmse)
    echo "with $with, without $without" && awk "BEGIN {exit !($with < $without)}"
}
check "the error falls with second sets" fewer
check "one worker" render extra a --workers 1 --worker-threads 1 --tile 32
check "three workers, other tiles" render extra b --workers 3 --tile 16
check "... give the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"

# However the frame is cut.
check "one worker" render s1-i1-o0-g0-l1 a --workers 1 --worker-threads 1 --tile 32
check "three workers, other tiles" render s1-i1-o0-g0-l1 b --workers 3 --tile 16
check "... give the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"
tap_done
