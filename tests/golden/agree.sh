#!/usr/bin/env bash
# Scenes of others, rendered and held against the pictures that their authors publish.
#   tests/golden/agree.sh BUILD_DIR [short | long] [NAME]
# short: small and noisy, for every run of the tests; long: as large as the references and, as they
# are, under a tent over the pixel: where the Cornell box's lamp, a hundred times as bright as what
# surrounds it, ends on the edge of an 8 x 8 box, a box shows.
# README.md says where scenes come from. $GOLDEN_SPP in place of each scene's own samples per pixel. What fails leaves its picture, and a picture of the difference, in
# BUILD_DIR/golden. README.md says why each bound stands where it does.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/golden/agree.sh BUILD_DIR [short | long] [NAME]}
form=${2:-short} only=${3:-}
. tests/tap.bash
kept=$build/golden
mkdir -p "$kept"

# pick SHORT LONG: the one of this form.
pick() { if [ "$form" = long ]; then echo "$2"; else echo "$1"; fi; }

# render NAME FOLDER SHRINK SPP [JQ-FILTER]: FOLDER's job, SHRINK times smaller, to $tmp/NAME.exr. The
# scene is what $tmp/NAME.glb holds, if that is there, else FOLDER's own.
render() {
    local name=$1 folder=$scenes/glb/$2 quiet=
    jq --argjson shrink "$3" --argjson spp "${GOLDEN_SPP:-$4}" --arg folder "$folder" \
       --arg filter "$(pick box tent)" --arg edited "$(test -e "$tmp/$name.glb" && echo "$tmp/$name.glb")" \
       '.scene.file = (if $edited == "" then $folder + "/" + .scene.file else $edited end)
        | if .environment.file then .environment.file = $folder + "/" + .environment.file else . end
        | .image.width /= $shrink | .image.height /= $shrink | .sampling.spp = $spp
        | .filter.method = "none" | .image.pixel_filter = $filter | .layers = ["beauty", "error"]
        | '"${5:-.}" \
       "$folder/job.json" >"$tmp/$name.json" || return 1
    [ "$form" = long ] || quiet=--quiet
    echo "# $name: $(jq -r '"\(.image.width) x \(.image.height), \(.sampling.spp) spp, \(.effects.indirect_bounces) bounces"' "$tmp/$name.json")"
    "$build/shearwater" render "$tmp/$name.json" -o "$tmp/$name.exr" $quiet 2> >(tee "$tmp/$name.log" >&2)
}

# compared NAME REFERENCE SHRINK BOX [ARGUMENTS]: the figures, into $tmp/NAME.figures.
compared() {
    local name=$1 reference=$scenes/$2/TungstenRender.exr shrink=$3 box=$4
    shift 4
    "$build/shearwater" compare "$reference" "$tmp/$name.exr" --reference-box "$shrink" --box "$box" \
        --difference "$tmp/$name-difference.png" "$@" >"$tmp/$name.figures" || return 1
    jq -r '"#   mean / reference \(.ratio | map(. * 1e5 | round / 1e5)), standard error of means \([range(3) as $c | .z.mean_error[$c] / .mean_reference[$c]] | map(. * 1e5 | round / 1e5))",
           "#   relMSE \(.relmse), of which noise \(.z.relmse); z: median \(.z.median), beyond 3: \(.z.beyond3), beyond 4: \(.z.beyond4)"' \
        "$tmp/$name.figures"
}

# holds NAME TEXT JQ-CONDITION: one test on the figures. `near($x)`: means are within $x of the
# reference's, and four of their standard errors.
holds() {
    local name=$1 before=$tap_failed
    check "$name: $2" jq -e 'def near($x): . as $f | all(range(3);
        ($f.ratio[.] - 1 | fabs) <= $x + 4 * $f.z.mean_error[.] / $f.mean_reference[.]); .finite and ('"$3"')' \
        "$tmp/$name.figures"
    [ "$before" -eq "$tap_failed" ] && return
    cp -f "$tmp/$name.exr" "$tmp/$name-difference.png" "$kept/" &&
        echo "# see $kept/$name-difference.png and $kept/$name.exr"
}

# One failed test for what could not even be compared.
broken() { check "$1 renders" eval "cat '$tmp/$1.log' >&2; false"; }

# wanted NAME FOLDER: whether to run it and its files are there.
wanted() {
    [[ $1 == *"$only"* ]] || return 1
    local file
    for file in "glb/$2/job.json" "$2/TungstenRender.exr"; do
        has_scene "$file" "$1 agrees with its author's picture" || return 1
    done
}

cornell() {
    local shrink box
    wanted cornell-box cornell-box-bitterli || return
    shrink=$(pick 8 1) box=$(pick 1 8)
    if ! render cornell-box cornell-box-bitterli "$shrink" "$(pick 100 64)" ||
        ! compared cornell-box cornell-box-bitterli "$shrink" "$box"; then
        broken cornell-box
        return
    fi
    holds cornell-box "means within 0.5 %" 'near(0.005)'
    holds cornell-box "relMSE of 8 x 8 boxes below $(pick "1e-3 and twice the noise's" 1e-3)" \
        "$(pick '.relmse < 1e-3 + 2 * .z.relmse' '.relmse < 1e-3')"
    holds cornell-box "z is hardly wider than noise$(pick " but at the lamp's edges" "")" \
        "$(pick '.z.median < 0.8 and .z.beyond3 < 0.025' '.z.median < 0.75 and .z.beyond3 < 0.015')"
    [ "$form" = long ] || return
    holds cornell-box "what our noise leaves unexplained is the reference's own" \
        '(.relmse - .z.relmse) > 0.9e-4 and (.relmse - .z.relmse) < 1.4e-4'
}

living() {
    local shrink box
    wanted living-room living-room || return
    shrink=$(pick 10 1) box=$(pick 1 8)
    if render living-room living-room "$shrink" 64 &&
        compared living-room living-room "$shrink" "$box"; then
        holds living-room "means within 1 %" 'near(0.01)'
    else
        broken living-room
    fi

    # With three materials as the picture has them, not as the converted scene does.
    [ "$form" = long ] || return
    if "$build/tests/golden/glb_edit" "$scenes/glb/living-room/living-room.glb" tests/golden/living-room.json \
        "$tmp/living-room-matched.glb" && render living-room-matched living-room "$shrink" 64 &&
        compared living-room-matched living-room "$shrink" "$box"; then
        holds living-room-matched "means within 0.5 %" 'near(0.005)'
        holds living-room-matched "relMSE below 2e-3 and the noise's" '.relmse < 2e-3 + .z.relmse'
    else
        broken living-room-matched
    fi
}

# The reference of this scene holds light that was scattered once: walls that reflect copper plates
# would not be grey.
veach_is_direct() {
    "$build/shearwater" compare "$scenes/veach-mis/TungstenRender.exr" "$scenes/veach-mis/TungstenRender.exr" \
        --crop 0,240,240,320 | jq -e '.mean_reference | .[0] > 0.01 and .[0] == .[1] and .[1] == .[2]'
}

veach() {
    local shrink box
    wanted veach-mis veach-mis || return
    shrink=$(pick 8 1) box=$(pick 1 8)
    check "veach-mis: the reference's walls are grey: it has no indirect light" veach_is_direct

    # Its own metals: Beckmann facets, copper, a third of it.
    if awk -f tests/golden/conductors.awk "$scenes/veach-mis/scene.xml" >"$tmp/conductors.json" &&
        "$build/tests/golden/glb_edit" "$scenes/glb/veach-mis/veach-mis.glb" "$tmp/conductors.json" "$tmp/veach-beckmann.glb" &&
        render veach-beckmann veach-mis "$shrink" 64 '.effects.indirect_bounces = 0' &&
        compared veach-beckmann veach-mis "$shrink" "$box"; then
        holds veach-beckmann "means within 1 %" 'near(0.01)'
        holds veach-beckmann "relMSE below $(pick "1e-3 and twice the noise's" 1e-3)" \
            "$(pick '.relmse < 1e-3 + 2 * .z.relmse' '.relmse < 1e-3')"
    else
        broken veach-beckmann
    fi

    # glTF's metals: GGX, and brighter towards grazing angles.
    if render veach-gltf veach-mis "$shrink" "$(pick 64 16)" '.effects.indirect_bounces = 0' &&
        compared veach-gltf veach-mis "$shrink" "$box" --range 30; then
        holds veach-gltf "direct light: means up to 3 % brighter" \
            'near(0.03) and (.ratio | add / 3 > 0.99)'
    else
        broken veach-gltf
    fi
    [ "$form" = long ] || return
    if render veach-gltf-indirect veach-mis "$shrink" 16 &&
        compared veach-gltf-indirect veach-mis "$shrink" "$box" --range 30; then
        holds veach-gltf-indirect "all light: means 2 to 6 % brighter, as another path tracer's" \
            '.ratio | all(. > 1.02 and . < 1.06)'
    else
        broken veach-gltf-indirect
    fi
}

cornell
living
veach
[ $tap_n -gt 0 ] || skip "agreement" "no scene is named $only"
tap_done
