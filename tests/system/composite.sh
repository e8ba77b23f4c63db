#!/usr/bin/env bash
# Objects in photographs: a room path-traced with a box against the box put into a picture of the room
# without it; photographs keep their bits where no object reaches; what cannot be composed is refused
# where it stands.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/composite.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
composed() { "$build/tests/bench/exr_composite" "$tmp/$1.exr" "$tmp/$2.exr" "$tmp/$3.exr" "${@:4}" | tee /dev/stderr; }

cp tests/scenes/photograph/*.obj tests/scenes/photograph/*.mtl "$tmp/"

# -- a made room --
# room NAME SCENE MEMBERS: a job, seen from its open side.
room() {
    echo "{\"scene\": {\"file\": \"$2\", \"camera\": {\"eye\": [0, 1, 5], \"target\": [0, 1, 0], \"yfov_deg\": 28}},
        \"image\": {\"width\": 96, \"height\": 96}, \"effects\": {\"indirect_bounces\": 4}, $3}" >"$tmp/$1.json"
}
reference='"sampling": {"spp": 1024}, "filter": {"method": "none"}'
in_room='"catchers": ["white", "left", "green"], "holdouts": ["lamp"], "layers": ["composite", "catcher", "overlay"]'
room truth room-and-box.obj "$reference"
room plate room.obj "$reference"
for spp in 4 16 64; do room "at_$spp" room-and-box.obj "\"backplate\": {\"file\": \"plate.exr\"}, \"sampling\": {\"spp\": $spp}, $in_room"; done
room add room-and-box.obj "\"backplate\": {\"file\": \"plate.exr\"}, \"sampling\": {\"spp\": 16}, \"composite\": {\"mode\": \"additive\"}, $in_room"
for name in truth plate at_4 at_16 at_64 add; do check "$name is rendered" render $name $name; done
for name in at_4 at_16 at_64 add; do composed truth plate $name 2>/dev/null | sed "s/^/# $name: /"; done
near() { composed truth plate "$1" | jq -e ".rms < $2 and .plate_rms > 0.1"; }
check "at 16 samples a pixel the composite is within 2 % of the truth" near at_16 0.02
check "... and where differences are added" near add 0.02
check "at 4 within 3 %" near at_4 0.03

# -- a mirror on a tiled floor, of which the scene knows a grey ground --
node --input-type=module - "$tmp" <<'J' || exit 1
import { writeFileSync } from "node:fs";
const tiles = Array.from({ length: 256 }, (_, k) => [k % 16, k >> 4]), at = (k) => k / 4 - 2;
const corners = tiles.flatMap(([x, z]) => [[0, 1], [1, 1], [1, 0], [0, 0]].map(([i, j]) => `v ${at(x + i)} 0 ${at(z + j)}`));
const faces = tiles.map(([x, z], k) => `usemtl ${(x + z) % 2 ? "red" : "white"}\nf ${[1, 2, 3, 4].map((i) => 4 * k + i).join(" ")}`);
const mirror = (first) => ["v -0.6 0.05 -0.15", "v 0.6 0.05 -0.15", "v 0.6 1 0.15", "v -0.6 1 0.15", "g mirror", "usemtl mirror", `f ${[0, 1, 2, 3].map((k) => first + k).join(" ")}`];
const write = (name, lines) => writeFileSync(`${process.argv[2]}/${name}.obj`, ["mtllib materials.mtl", "mtllib mirror.mtl", ...lines, ""].join("\n"));
writeFileSync(`${process.argv[2]}/mirror.mtl`, "newmtl mirror\nKd 0.95 0.95 0.95\nPm 1\nPr 0\n");
write("tiles", [...corners, ...faces]);
write("tiles-and-mirror", [...corners, ...faces, ...mirror(1025)]);
write("mirror", mirror(1));
J
outside() { # NAME SCENE MEMBERS
    echo "{\"scene\": {\"file\": \"$2\", \"camera\": {\"eye\": [0, 1.3, 3], \"target\": [0, 0.3, 0], \"yfov_deg\": 45}},
        \"image\": {\"width\": 96, \"height\": 96}, \"environment\": {\"radiance\": [0.6, 0.8, 1]}, $3}" >"$tmp/$1.json"
}
outside floor tiles.obj '"sampling": {"spp": 256}, "filter": {"method": "none"}'
outside both tiles-and-mirror.obj '"sampling": {"spp": 256}, "filter": {"method": "none"}'
outside mirrored mirror.obj '"backplate": {"file": "floor.exr"}, "catchers": [{"ground": {"height": 0}}], "sampling": {"spp": 16}'
for name in floor both mirrored; do check "$name is rendered" render $name $name; done
composed both floor mirrored 2>/dev/null | sed 's/^/# mirrored: /'
check "a mirror shows the tiles of the photograph" eval 'composed both floor mirrored | jq -e ".rms < 0.06 and .plate_rms > 0.2"'
check "two workers and other tiles mirror the same bytes" eval 'render mirrored mirrored2 --workers 2 --tile 16 && cmp "$tmp/mirrored.exr" "$tmp/mirrored2.exr"'

# -- a photograph --
# Under a sun and without bounces an object reaches its shadow and no further.
cat >"$tmp/sun.json" <<JSON
{"scene": {"file": "box.obj", "camera": {"eye": [0, 3, 8], "target": [0, 0.3, 0], "yfov_deg": 40}},
 "image": {"width": 192, "height": 192}, "effects": {"indirect_bounces": 0}, "sampling": {"spp": 9},
 "lights": [{"type": "directional", "direction": [0.5, -1, -0.3], "irradiance": [3, 2.8, 2.5]}],
 "backplate": {"file": "large.exr"}, "catchers": [{"ground": {"height": 0}}]}
JSON
check "a photograph is taken" render plate large --size 192x192 --spp 4
check "a ground under the object catches its shadow in it" render sun sun --png "$tmp/sun.png"
check "... and the object stands before it" eval 'composed large large sun 60,60,72,72 | jq -e ".changed > 100"'
# Filters read as far as 65 pixels away.
for part in 0,0,192,14 0,178,192,14 0,0,14,192 178,0,14,192; do
    check "... while no bit changes far away, at $part" eval "composed large large sun $part | jq -e '.same == 1'"
done
check "two workers and other tiles give the same bytes" render sun again --workers 2 --tile 16
check "... all of them" cmp "$tmp/sun.exr" "$tmp/again.exr"
many() { jq '.sampling.spp = 40' "$tmp/sun.json" >"$tmp/many.json"; render many many && render many many2 --workers 2 --tile 8 && cmp "$tmp/many.exr" "$tmp/many2.exr"; }
check "... in several passes, too" many

# From the command line, onto a picture of 8 bits.
check "a PNG for a backplate is made" render plate small --png "$tmp/photo.png" --spp 4
check "options put a scene into it" "$build/shearwater" render "$tmp/box.obj" -o "$tmp/cli.exr" --size 64x64 --spp 4 --bounces 1 \
    --backplate "$tmp/photo.png" --fit cover --catcher-ground 0 --composite additive --quiet
check "... with the layers of a composite" eval '"$build/tests/bench/exr_pixel" "$tmp/cli.exr" 5 5 | jq -e "has(\"composite.R\") and has(\"catcher.G\") and has(\"A\")"'

# A block that moves, under a lamp that is not in the photograph and stands still.
node --input-type=module - "$PWD" "$tmp" <<'J' || exit 1
import { writeFileSync } from "node:fs";
const [, , root, tmp] = process.argv;
const { moving, movingJob } = await import(`${root}/tests/bench/scenes/moving.mjs`);
const one = moving.find(({ name }) => name === "object");
writeFileSync(`${tmp}/moving.glb`, one.glb());
writeFileSync(`${tmp}/moving.json`, JSON.stringify({ ...movingJob("moving.glb", 2, 64, 4), layers: ["catcher", "composite"],
  backplate: { file: "photo.png", fit: "cover" }, catchers: ["floor", "tall", { ground: { height: -0.01 } }] }));
J
check "a sequence is composed with it" "$build/shearwater" render "$tmp/moving.json" -o "$tmp/moving.####.exr" --quiet
check "... frame by frame" eval 'test -s "$tmp/moving.0002.exr" && ! cmp -s "$tmp/moving.0001.exr" "$tmp/moving.0002.exr"'
check "... and lights the floor" eval '"$build/tests/bench/exr_pixel" "$tmp/moving.0002.exr" 32 44 | jq -e ".[\"catcher.R\"] != 1"'

# -- what is refused --
# refused PLACE TEXT FILTER: the job of the sun, changed by jq.
refused() {
    jq "$3" "$tmp/sun.json" >"$tmp/bad.json"
    ! "$build/shearwater" render "$tmp/bad.json" -o "$tmp/bad.exr" --quiet >"$tmp/said" 2>&1 || return 1
    cat "$tmp/said"
    grep -qF -- "$1" "$tmp/said" && grep -q -- "$2" "$tmp/said"
}
check "a catcher that is not there" refused /catchers/1 'no node or material "roof"' '.catchers += ["roof"]'
"$build/shearwater" render "$tmp/room-and-box.obj" -o "$tmp/two.exr" --size 16x16 --spp 1 --catcher white --catcher roof --quiet 2>"$tmp/said"
check "of the second of two options" grep -q '/catchers/1.*no node or material "roof"' "$tmp/said"
check "a holdout that is not there" refused /holdouts/0 'no node or material "roof"' '.holdouts = ["roof"]'
check "one that is both" refused /holdouts/0 'a catcher and a holdout' '.catchers = ["box"] | .holdouts = ["blue"]'
check "a photograph of another size" refused /backplate "the photograph has 192 x 192 px, the picture 48 x 192" '.image.width = 48'
check "a scene for a photograph" refused /backplate/asset "a scene, no photograph" '.backplate.file = "box.obj"'
check "a photograph for a map of light" refused /environment/asset "a photograph, no environment map" '.environment = {file: "photo.png"}'
# The header of a PNG of 10^9 pixels.
{ printf '\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x80\0\0\0\x7a\x12\x08\x02\0\0\0'; head -c 100 /dev/zero; } >"$tmp/huge.png"
check "a photograph of a thousand million pixels" refused /backplate/asset "32768 x 31250" '.backplate.file = "huge.png"'
tap_done
