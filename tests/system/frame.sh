#!/usr/bin/env bash
# The same picture, whatever the machines: bytes of the EXR are equal for any worker count, tile
# size, thread count, and with a worker or the coordinator killed in between.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/frame.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb

cat >"$tmp/job.json" <<J
{"scene": {"file": "$scene"}, "image": {"width": 203, "height": 151},
 "sampling": {"spp": 9, "seed": 7}, "effects": {"indirect_bounces": 1},
 "layers": ["beauty", "direct", "indirect", "albedo", "normal", "depth", "id", "samples",
            "visibility", "slope_min", "slope_max", "filter_width", "emission"]}
J
jq '.filter.method = "axis_aligned"' "$tmp/job.json" >"$tmp/aligned.json"
jq '.filter.method = "sheared"' "$tmp/job.json" >"$tmp/sheared.json"
jq '.image = {width: 512, height: 512} | .sampling.spp = 16' "$tmp/job.json" >"$tmp/long.json"

same() { cmp "$tmp/$1.exr" "$tmp/$2.exr"; }

check "render writes an EXR, a PNG and statistics" \
    render job base --workers 1 --worker-threads 1 --tile 32 --png "$tmp/base.png" --stats "$tmp/stats.json"
check "the EXR has the layers that were asked for" bash -c "
    exrheader '$tmp/base.exr' | grep -q 'direct.R' && exrheader '$tmp/base.exr' | grep -q 'slope_max.S'"
check "statistics hold what a script needs" jq -e '
    .cpu_s.import >= 0 and .cpu_s.trace > 0 and .cpu_s.reconstruct > 0 and .cpu_s.total > 0 and
    .cpu_s.shadow > 0 and .shadow.pixels_filtered > 0 and
    .wall_s > 0 and .frames.wall_s > .frames.stored_late_s and
    .frames.stored_late_s >= .frames.drawn_late_s and .frames.drawn_late_s > 0 and .rays.primary == 203*151 and .rays.shadow > 0 and .rays.indirect > 0 and
    (.skipped | type) == "object" and .bytes_received > 0 and
    .peak_rss_bytes.server > 0 and .peak_rss_bytes.worker > 0' "$tmp/stats.json"
for workers in 2 4; do
    check "$workers workers give the same bytes" render job "w$workers" --workers $workers
    check "... compared" same base "w$workers"
done
for tile in 16 64; do
    check "tiles of $tile give the same bytes" render job "t$tile" --workers 2 --tile $tile
    check "... compared" same base "t$tile"
done
# The same holds for each filter; auto is the sheared one here, which the files' job says, not their
# pixels.
check "the axis-aligned filter" render aligned aligned --workers 1 --worker-threads 1 --tile 32
check "... gives the same bytes with other tiles and workers" render aligned aligned2 --workers 3 --tile 16
check "... compared" same aligned aligned2
check "the sheared filter" render sheared sheared --workers 2 --tile 64
check "... is what auto takes" bash -c "
    '$build/shearwater' compare '$tmp/base.exr' '$tmp/sheared.exr' | jq -e '.finite and .rmse == 0'"
check "... and is another than the axis-aligned" bash -c "
    '$build/shearwater' compare '$tmp/base.exr' '$tmp/aligned.exr' | jq -e '.finite and .rmse > 0'"
check "three threads give the same bytes" render job threads --workers 1 --worker-threads 3
check "... compared" same base threads

# Files are where one expects them: a pipe or a device is written to, not replaced by a file, and a
# folder that is not there is told of before the work.
through_a_pipe() {
    mkfifo "$tmp/pipe" || return 1
    cat "$tmp/pipe" >"$tmp/piped.exr" & track $!
    timeout 60 "$build/shearwater" render "$tmp/job.json" --quiet -o "$tmp/pipe" && wait $! &&
        [ -p "$tmp/pipe" ] && same base piped
}
check "a picture goes through a pipe" through_a_pipe
told_at_once() {
    local out
    out=$("$build/shearwater" render "$tmp/no-such-job.json" -o "$tmp/no-such-folder/x.exr" 2>&1) && return 1
    grep -q no-such-folder <<<"$out" || { echo "$out"; return 1; }
}
check "a folder that is missing is named before anything else" told_at_once
scene_is_a_pipe() {
    mkfifo "$tmp/scene.glb" && echo '{"scene": {"file": "scene.glb"}}' >"$tmp/pipe.json"
    timeout 20 "$build/shearwater" render "$tmp/pipe.json" >"$tmp/pipe.log" 2>&1
    [ $? = 1 ] && grep -q 'scene.glb is not a regular file' "$tmp/pipe.log"
}
check "a scene that is a pipe is refused, not waited for" scene_is_a_pipe

# The picture is right, not only repeatable: the mean of few samples is that of many, and the light
# is as strong and as warm as it has been since its estimators were held against closed forms.
jq '.sampling = {spp: 100, seed: 8}' "$tmp/job.json" >"$tmp/many.json"
mean_is() { # LAYER R G B, each within 2 %
    "$build/shearwater" compare "$tmp/many.exr" "$tmp/base.exr" --layer "$1" |
        jq -e --argjson held "[$2, $3, $4]" '
            .finite and ((.bias | fabs) < 0.01 * (.mean_reference | add / 3)) and
            ([.mean_test, $held] | transpose | all(.[0] / .[1] > 0.98 and .[0] / .[1] < 1.02))'
}
check "a hundred samples a pixel" render many many --workers 2
check "direct light has their mean" mean_is direct 0.04461 0.02934 0.008394
check "indirect light has their mean" mean_is indirect 0.01986 0.01198 0.002635
check "what is the same is alike" bash -c "
    '$build/shearwater' compare '$tmp/base.exr' '$tmp/t16.exr' --ssim --flip |
        jq -e '.ssim == 1 and .flip.mean == 0 and .flip.max == 0'"
check "other samples are less alike" bash -c "
    '$build/shearwater' compare '$tmp/base.exr' '$tmp/aligned.exr' --ssim --flip --exposure 2 --curve filmic |
        jq -e '.ssim < 1 and .ssim > 0 and .flip.mean > 0 and .flip.q1 <= .flip.median'"
check "options of perceptual metrics are checked" bash -c "
    for wrong in '--exposure x' '--gamma 9' '--curve round' '--ppd 1' '--where depth,0,9'; do
        ! '$build/shearwater' compare '$tmp/base.exr' '$tmp/base.exr' --flip \$wrong 2>'$tmp/said' || exit 1
        grep -q -- \"\${wrong%% *}\" '$tmp/said' || exit 1
    done"
# A picture by light fields beside two references by paths: of 16 samples a pixel, seeds 1 and 2, and of 256.
jq '.image = {width: 96, height: 72} | .layers = ["beauty"]' "$tmp/job.json" >"$tmp/judged.json"
references() {
    local of
    for of in "1 16" "2 16" "3 256" "4 256"; do
        jq --argjson seed "${of% *}" --argjson spp "${of#* }" '.filter.method = "none" | .sampling = {spp: $spp, seed: $seed}' \
            "$tmp/judged.json" >"$tmp/paths.json" && render paths "reference${of% *}" || return 1
    done
    render judged judged
}
check "two pairs of references, and a picture" references
beside() { "$build/shearwater" compare "$tmp/reference$1.exr" --reference-pair "$tmp/reference$2.exr" "$tmp/$3.exr" "${@:4}"; }
beside_a_pair() {
    jq -es '.[0] as $few | .[1] as $many | all(.[]; .psnr_db > 35 and .psnr_db < 40 and .rmse01 > 0 and .flip.mean > 0 and (has("reason") | not))
        and ($few.psnr_db - $many.psnr_db | fabs) < 0.5 and ($few.relmse999 / $many.relmse999 - 1 | fabs) < 0.1
        and $few.relmse > 1.5 * $many.relmse' <(beside 1 2 judged --flip) <(beside 3 4 judged --flip) &&
        cmp <(beside 3 4 judged) <("$build/shearwater" compare "$tmp/reference3.exr" "$tmp/judged.exr" --reference-pair "$tmp/reference4.exr")
}
check "compare takes the noise of two references out of the error" beside_a_pair
as_near_as_noise() {
    beside 1 2 reference1 | jq -e '.psnr_db == null and .rmse01 == null and .relmse999 == 0 and (.reason | test("noise"))'
}
check "... and says so where that noise hides it" as_near_as_noise
pair_refused() { # WORDS IN THE MESSAGE, ARGUMENTS
    ! "$build/shearwater" compare "$tmp/reference1.exr" "${@:2}" >"$tmp/said" 2>&1 && grep -q "$1" "$tmp/said" || { cat "$tmp/said"; return 1; }
}
check "a second reference that is not there is named" pair_refused no-such.exr --reference-pair "$tmp/no-such.exr" "$tmp/judged.exr"
check "a second reference of another size is refused" pair_refused 'sizes differ: 203 x 151 and 96 x 72' --reference-pair "$tmp/base.exr" "$tmp/judged.exr"
check "a pair judges all pixels" pair_refused 'combined with --where' --reference-pair "$tmp/reference2.exr" "$tmp/judged.exr" --where depth,0,9
check "compare finds no difference where there is none" bash -c "
    '$build/shearwater' compare '$tmp/base.exr' '$tmp/t16.exr' | jq -e '.finite and .rmse == 0'"

# Two workers of their own; one is killed while tiles are out.
worker() { "$build/shearwater-worker" --connect "unix:$1/worker.sock" --threads 1 \
               --cache "$1/cache-$2" >"$1/worker-$2.log" 2>&1 & track $!; workers+=($!); }
finish_with_killed_worker() {
    local data=$tmp/kill workers=()
    serve_start "$data" --workers 0 || return 1
    worker "$data" a; worker "$data" b
    local id done_tiles
    id=$("$build/shearwater" submit "$tmp/long.json" --server "$url" --quiet) || return 1
    eventually 10 has_landed "$id" 20
    done_tiles=$(number "$id" '.progress.tiles_done // 0')
    kill -9 "${workers[0]}"
    await_state "$id" finished 120 || return 1
    curl -sSf --noproxy '*' -o "$tmp/killed.exr" "$url/v1/jobs/$id/frames/1/image.exr" || return 1
    reissued=$(curl -sS --noproxy '*' "$url/metrics" | awk '/tiles_reissued_total/ && !/^#/ {print $2}')
    serve_stop
    echo "tiles done at the kill: $done_tiles, re-issued: $reissued"
    [ "$done_tiles" -ge 20 ] && [ "$done_tiles" -lt 240 ]
}
check "a frame whose worker is killed half-way finishes" finish_with_killed_worker
check "the undisturbed frame" render long undisturbed --workers 2
check "... has the same bytes" same undisturbed killed

finish_after_restart() {
    local data=$tmp/restart
    serve_start "$data" --workers 2 || return 1
    local id first
    first=$("$build/shearwater" submit "$tmp/long.json" --server "$url" --quiet) || return 1
    id=$("$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet) || return 1
    eventually 20 has_landed "$first" 1
    serve_stop -KILL
    serve_start "$data" --workers 2 || return 1
    await_state "$first" finished 120 && await_state "$id" finished 60 || return 1
    curl -sSf --noproxy '*' -o "$tmp/restarted.exr" "$url/v1/jobs/$first/frames/1/image.exr" &&
        curl -sSf --noproxy '*' -o "$tmp/restarted2.exr" "$url/v1/jobs/$id/frames/1/image.exr"
}
check "a coordinator killed and restarted finishes its jobs" finish_after_restart
check "... the first with the same bytes" same undisturbed restarted
check "... the second with the same bytes" same base restarted2
check "it stops in order on SIGTERM" serve_stop
tap_done
