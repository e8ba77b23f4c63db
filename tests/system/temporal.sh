#!/usr/bin/env bash
# Temporal filtering: a frame that uses samples of the frames beside it has the same bytes whichever frame came
# first, on any workers, in any tiles, and with the coordinator killed; and it has less noise.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/temporal.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash

# Blocks under a lamp and a sky, of which one moves; and the Cornell box, whose frames would be of light fields one by one.
node --input-type=module - "$PWD" "$tmp" <<'J' || exit 1
const [root, folder] = process.argv.slice(2);
const { moving, movingBox, movingJob, movingLens } = await import(`${root}/tests/bench/scenes/moving.mjs`);
const { writeFileSync } = await import("node:fs");
const write = (name, scene, spp, more) =>
  writeFileSync(`${folder}/${name}.json`, JSON.stringify(movingJob(`${folder}/${scene}.glb`, 6, 112, spp, { layers: ["beauty"], ...more })));
for (const { name, glb } of [...moving, ...movingBox]) writeFileSync(`${folder}/${name}.glb`, glb());
write("two", "object", 4, { filter: { temporal: "2" } });
write("one", "object", 4, { filter: { temporal: "1" } });
write("none", "object", 4, { filter: { temporal: "none" } });
write("auto", "object", 4, {});
write("errors", "object", 4, { filter: { temporal: "2" }, layers: ["beauty", "error", "motion.forward", "normal"] });
write("middle", "object", 4, { filter: { temporal: "2" }, frames: { first: 2, last: 6 } });
write("gaps", "object", 4, { filter: { temporal: "2" }, frames: "1-5x2" });
write("gaps_none", "object", 4, { filter: { temporal: "none" }, frames: "1-5x2" });
write("single", "object", 4, { filter: { temporal: "2" }, frames: { first: 4 } });
write("single_none", "object", 4, { filter: { temporal: "none" }, frames: { first: 4 } });
write("target", "object", 4, { filter: { temporal: "2" }, sampling: { spp: 4, target_error: 0.5 }, frames: "1-2" });
write("passes", "still", 49, { filter: { temporal: "1" }, frames: "1-3", image: { width: 48, height: 36 } });
write("converged", "object", 256, { filter: { temporal: "none" }, sampling: { spp: 256, seed: 7 }, frames: { first: 4 } });
const box = movingBox[0].job, whole = { method: "none", residual: "halves" };
write("box", "box-object", 4, box);
write("box_named", "box-object", 4, { ...box, filter: { ...whole, temporal: "2" } });
write("box_seen", "box-object", 4, { ...box, effects: { ...box.effects, ambient_occlusion: { distance: 0.5 } }, layers: ["beauty", "occlusion", "visibility", "albedo"] });
write("box_fields", "box-object", 4, { ...box, filter: { temporal: "none" }, frames: { first: 4 } });
write("box_gaps", "box-object", 4, { ...box, frames: "4-6x2" });
write("box_true", "box-object", 256, { ...box, filter: whole, sampling: { spp: 256, seed: 7 }, frames: { first: 4 } });
const lens = movingLens[0].job;
write("lens", "object", 4, lens);
write("lens_field", "object", 4, { ...lens, filter: { temporal: "none" } });
write("lens_goes", "camera", 4, { ...lens, frames: "3-4" });
write("lens_goes_field", "camera", 4, { ...lens, frames: "3-4", filter: { temporal: "none" } });
write("lens_true", "object", 256, { ...lens, filter: whole, sampling: { spp: 256, seed: 7 }, frames: { first: 4 } });
J

same() { # same NAME OTHER FRAMES...
    local frame
    for frame in "${@:3}"; do cmp "$tmp/$1.$frame.exr" "$tmp/$2.$frame.exr" || return 1; done
}
alike() { "$build/shearwater" compare "$tmp/$1.exr" "$tmp/$2.exr" --layer beauty | jq -e '.rmse == 0'; }
differ() { ! alike "$@"; }
every() { # every RELATION NAME OTHER FRAMES...
    local frame
    for frame in "${@:4}"; do "$1" "$2.$frame" "$3.$frame" || return 1; done
}
error_of() { "$build/shearwater" compare "$tmp/$2.exr" "$tmp/$1.4.exr" | jq .rmse; }
less() { # less NAME OTHER SHARE [CONVERGED]
    local truth=${4:-converged}
    jq -en --argjson a "$(error_of "$1" "$truth")" --argjson b "$(error_of "$2" "$truth")" --argjson share "$3" '[$a, $b], $a < $share * $b'
}

check "a sequence is filtered over its frames" render two two.# --workers 1
check "... on three workers" render two three.# --workers 3
check "... which makes the same bytes" same two three 1 2 3 4 5 6
check "... in small blocks and tiles" env SHEARWATER_BLOCK_PX=32 "$build/shearwater" render "$tmp/two.json" --quiet --tile 16 -o "$tmp/small.#.exr" --workers 2
check "... the same" same two small 1 2 3 4 5 6
check "frames one by one" render none none.# --workers 2
check "... differ" every differ two none 1 4 6
check "a window of one frame on each side" render one one.# --workers 2
check "the converged frame" render converged converged --workers 2
check "one frame on each side has less error" less one none 0.85
check "two have still less" less two one 1
check "auto is one of them" render auto auto.# --workers 2
check "... the larger" every alike auto two 1 6
check "layers change no other pixel" render errors errors.# --workers 2
check "... of a sequence" every alike errors two 3

check "a sequence that light fields could bring" render box box.# --workers 1
check "... on three workers" render box boxes.# --workers 3
check "... has the same bytes" same box boxes 1 2 3 4 5 6
check "... and is of paths" render box_named named.# --workers 2
check "... all of it" every alike box named 1 4 6
check "other layers of it" render box_seen seen.# --workers 2
check "... change no other pixel" every alike box seen 1 4 6
check "a frame of it by itself, of fields" render box_fields fields.4 --workers 2
check "... and frames with gaps between them" render box_gaps apart.# --workers 2
check "... are the same" alike fields.4 apart.4
check "the converged frame of it" render box_true box_true --workers 2
check "the sequence has less error" less box fields 0.85 box_true
check "a sequence through a lens" render lens lens.# --workers 1
check "... on three workers" render lens lenses.# --workers 3
check "... has the same bytes" same lens lenses 1 2 3 4 5 6
check "its frames one by one" render lens_field lens_field.# --workers 2
check "its converged frame" render lens_true lens_true --workers 2
check "the sequence has less error" less lens lens_field 0.95 lens_true
check "a camera with a lens goes" render lens_goes goes.# --workers 2
check "... with frames one by one" render lens_goes_field goes_field.# --workers 2
check "... whatever is asked for" every alike goes goes_field 3 4

# Frames 4 to 6 know nothing of frame 1, and frame 4 alone of none.
check "fewer frames of it" render middle middle.# --workers 2
check "... show the same from the third on" every alike middle two 4 5 6
check "... and others at the cut" every differ middle two 2 3
check "a frame by itself" render single single.# --workers 1
check "... needs no window" render single_none alone.# --workers 1
check "... to the last bit" every alike single alone 4
check "frames with gaps between them" render gaps gaps.# --workers 1
check "... are filtered by themselves" render gaps_none lone.# --workers 1
check "... whatever is asked for" every alike gaps lone 1 3 5
check "several passes a tile" render passes passes.# --workers 2
check "... on one worker" render passes again.# --workers 1
check "... are the same" same passes again 1 2 3
check "a target has windows of none" render target target.# --workers 2

# The coordinator dies with frames that wait, and with frames that are done.
killed() { # killed DONE
    local id frame
    serve_start "$tmp/data$1" --workers 1 || return 1
    id=$("$build/shearwater" submit "$tmp/two.json" --server "$url" --quiet) || return 1
    eventually 40 shows "$id" ".progress.frames_done >= $1 and .progress.tiles_done > $((2 + 4 * $1))"
    serve_stop -KILL
    serve_start "$tmp/data$1" --workers 2 || return 1
    await_state "$id" finished 60 || return 1
    [ "$1" = 0 ] || shows "$id" '.log | any(.text | contains("taken up for the frames beside it"))' || return 1
    for frame in 1 2 3 4 5 6; do exr "$id" "$tmp/killed$1.$frame.exr" $frame || return 1; done
    serve_stop
    same two "killed$1" 1 2 3 4 5 6
}
check "a coordinator that is killed before its first frame is done goes on" killed 0
check "... with some done, whose samples others need" killed 2

# Without a spool these are traced again.
unspooled() {
    local id frame
    serve_start "$tmp/bare" --workers 1 || return 1
    id=$("$build/shearwater" submit "$tmp/two.json" --server "$url" --quiet) || return 1
    eventually 40 shows "$id" ".progress.frames_done >= 2"
    serve_stop -KILL
    rm -rf "$tmp/bare/spool"
    serve_start "$tmp/bare" --workers 2 || return 1
    await_state "$id" finished 60 || return 1
    for frame in 1 2 3 4 5 6; do exr "$id" "$tmp/bare.$frame.exr" $frame || return 1; done
    shows "$id" '.progress.frames_done == 6 and .progress.tiles_done == .progress.tiles_total' || return 1
    serve_stop
    same two bare 1 2 3 4 5 6
}
check "... and without what it had on disk" unspooled

# Windows of several jobs at once get on, also when one is paused and its frames are dropped.
side_by_side() {
    local ids=() id k
    serve_start "$tmp/many" --workers 2 || return 1
    for k in 1 2 3 4 5 6; do ids+=("$("$build/shearwater" submit "$tmp/two.json" --server "$url" --quiet)"); done
    eventually 40 shows "${ids[0]}" ".progress.frames_done >= 1"
    http -X PATCH -H 'content-type: application/json' -d '{"paused": true}' "$url/v1/jobs/${ids[0]}" >/dev/null
    await_state "${ids[5]}" finished 120 || return 1
    http -X PATCH -H 'content-type: application/json' -d '{"paused": false}' "$url/v1/jobs/${ids[0]}" >/dev/null
    for id in "${ids[@]}"; do await_state "$id" finished 120 || return 1; done
    for k in 1 2 3 4 5 6; do exr "${ids[0]}" "$tmp/many.$k.exr" $k || return 1; done
    serve_stop
    same two many 1 2 3 4 5 6
}
check "windows of several jobs do not hold each other up" side_by_side
tap_done
