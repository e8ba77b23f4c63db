#!/usr/bin/env bash
# Several effects in one frame: each costs where it is, and nothing where it is not; soft shadows and
# indirect light are filtered before the lens, and the picture is that of paths.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/combined.sh BUILD_DIR}
. tests/tap.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
pixels=$((96 * 80))

cat >"$tmp/all.json" <<J
{"scene": {"file": "$scene", "lights": false, "camera": {"eye": [0, 1, 3.2], "target": [0, 0.6, 0], "yfov_deg": 30}},
 "image": {"width": 96, "height": 80}, "sampling": {"spp": 9, "seed": 7}, "layers": ["beauty"]}
J
render() { # JOB OUT ARGUMENTS...
    "$build/shearwater" render "$tmp/$1.json" --quiet -o "$tmp/$2.exr" --stats "$tmp/$2.stats" "${@:3}"
}
counts() { jq -e "$2" "$tmp/$1.stats"; }
figure() { "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$2.exr" --layer beauty "${@:3}"; }

area='[{"type": "rectangle", "position": [0, 1.95, 0], "direction": [0, -1, 0], "width": 0.5, "height": 0.5, "radiance": [12, 11, 9]}]'
point='[{"type": "point", "position": [0, 1.9, 0], "intensity": [1, 1, 1]}]'

# Every subset of {soft shadows, indirect light, occlusion, lens}: what runs and what does not.
for shadows in 0 1; do for indirect in 0 1; do for occlusion in 0 1; do for lens in 0 1; do
    name=s$shadows-i$indirect-o$occlusion-l$lens
    [ $shadows = 1 ] && lights=$area || lights=$point
    jq --argjson lights "$lights" --argjson i $indirect --argjson o $occlusion --argjson l $lens '
        .lights = $lights | .effects.indirect_bounces = $i
        | if $o == 1 then .layers += ["occlusion"] else . end
        | if $l == 1 then .lens = {aperture_radius: 0.05, focus_distance: 3.1} else . end' \
        "$tmp/all.json" >"$tmp/$name.json"
    check "$name" render $name $name
    if [ $lens = 1 ] && [ $occlusion = 1 ]; then # a layer that with a lens paths alone give
        check "... is paths alone" counts $name "
            .rays.paths == $pixels * 9 and .rays.lens == 0 and .rays.occlusion > 0 and .rays.lens_centres == 0
            and .lens.samples_lit == 0 and .shadow.pixels_filtered == 0 and .indirect.pixels_filtered == 0
            and .cpu_s.shadow == 0 and .cpu_s.indirect == 0 and .cpu_s.lens == 0 and .cpu_s.lens_light == 0"
        continue
    fi
    fields=$((lens == 1 && (shadows == 1 || indirect == 1)))
    check "... soft shadows" counts $name "(.shadow.pixels_filtered > 0) == ($shadows == 1) and (.cpu_s.shadow > 0) == ($shadows == 1)"
    check "... indirect light" counts $name "(.rays.indirect > 0) == ($indirect == 1 or $occlusion == 1)
        and (.rays.indirect_shadow > 0) == ($indirect == 1)"
    check "... their filter" counts $name "(.cpu_s.indirect > 0) == ($indirect == 1 or $occlusion == 1)
        and (.indirect.pixels_filtered > 0) == ($indirect == 1 or $occlusion == 1)"
    check "... the lens" counts $name "(.rays.lens == $pixels * 9) == ($lens == 1) and (.rays.lens > 0) == ($lens == 1)
        and (.cpu_s.lens > 0) == ($lens == 1)"
    check "... light of fields at lens samples" counts $name "(.lens.samples_lit > 0) == ($fields == 1)
        and (.rays.lens_centres > 0) == ($fields == 1) and (.cpu_s.lens_light > 0) == ($fields == 1)"
    check "... no glossy lobes, no paths beside" counts $name '.rays.paths == 0 and .cpu_s.glossy == 0 and .glossy.pixels_filtered == 0'
done; done; done; done
check "without a lens, soft shadows or indirect light nothing is bounced, sheared or averaged" counts s0-i0-o0-l0 "
    .rays.primary == $pixels and .rays.shadow <= $pixels and .rays.indirect == 0"
check "samples that fields light cost one shadow ray a light and pixel, not one each" counts s0-i1-o0-l1 ".rays.shadow < $pixels * 2"

# The picture is that of paths, with less error the more samples there are.
render_reference() {
    jq '.filter.method = "none" | .sampling.seed = 8' "$tmp/s1-i1-o0-l1.json" >"$tmp/paths.json"
    render paths paths --spp 2048
}
check "paths" render_reference
for spp in 4 9 16 36; do check "$spp samples" render s1-i1-o0-l1 n$spp --spp $spp; done
falling() {
    local last=1e9 now
    for spp in 4 9 16 36; do
        now=$(figure paths n$spp | jq .rmse); echo "$spp: $now"
        awk "BEGIN {exit !($now < $last)}" || return 1
        last=$now
    done
}
check "the error falls with every step" falling
energy() { figure paths n$1 | tee /dev/stderr | jq -e '.finite and ([.ratio[] | values | . > 0.995 and . < 1.005] | all)'; }
for spp in 9 36; do check "$spp samples: the light is that of paths within 0.5 %" energy $spp; done
check "nine samples, each with light of its own" render s1-i1-o0-l1 own --method average --lens sheared --indirect average
quieter() {
    local lit own
    lit=$(figure paths n9 | jq .rmse) own=$(figure paths own | jq .rmse)
    echo "lit by fields $lit, each by itself $own" && awk "BEGIN {exit !($lit * 2.5 < $own)}"
}
check "... have more than 2.5 times the error" quieter

# However the frame is cut.
check "one worker" render s1-i1-o0-l1 a --workers 1 --worker-threads 1 --tile 32
check "three workers, other tiles" render s1-i1-o0-l1 b --workers 3 --tile 16
check "... give the same bytes" cmp "$tmp/a.exr" "$tmp/b.exr"
tap_done
