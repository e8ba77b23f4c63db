#!/usr/bin/env bash
# filter.residual "oidn": refused where Open Image Denoise is not there or is not what it should be; else a frame's paths
# go through it once all is drawn, what goes wrong there ends the frame, and other layers stay. The libraries are ours:
# tests/bench/oidn has its network, tests/fake/oidn misbehaves.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/oidn.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash

libraries=$(realpath -e "$build/tests/oidn") || { echo "Bail out! the libraries are not built"; exit 1; }
mkdir "$tmp/absent"
: >"$tmp/absent/libOpenImageDenoise.so.2" # as good as none, also where there is one
with() { # with LIBRARY BEHAVIOUR COMMAND...
    case $1 in absent) local folder=$tmp/absent ;; *) local folder=$libraries/$1 ;; esac
    LD_LIBRARY_PATH=$folder FAKE_OIDN=$2 "${@:3}"
}
document() { # document NAME MEMBERS
    printf '{"scene": {"file": "%s/tests/scenes/cornell-box/cornell-box.glb"}, "image": {"width": 70, "height": 45}, %s}' "$PWD" "$2" >"$tmp/$1.json"
}
layers='"layers": ["beauty", "direct", "indirect", "emission", "albedo", "normal"]'
paths='"sampling": {"spp": 4, "seed": 3, "tile_px": 16}, "effects": {"indirect_bounces": 2}'
document paths "$paths, $layers, \"filter\": {\"method\": \"none\", \"residual\": \"oidn\"}"
document tiles "${paths/16/32}, $layers, \"filter\": {\"method\": \"none\", \"residual\": \"oidn\"}"
document plain "$paths, $layers, \"filter\": {\"method\": \"none\"}"
document covered "\"sampling\": {\"spp\": 4}, \"filter\": {\"residual\": \"oidn\"}"
document covered_auto "\"sampling\": {\"spp\": 4}"
document lens "$paths, \"lens\": {\"aperture_radius\": 0.05, \"focus_distance\": 3}, \"filter\": {\"residual\": \"oidn\"}"
document frames "$paths, \"frames\": \"1-3\", \"filter\": {\"method\": \"none\", \"residual\": \"oidn\", \"temporal\": \"2\"}"
document single "$paths, \"frames\": \"2\", \"filter\": {\"method\": \"none\", \"residual\": \"oidn\"}"

refused() { # refused LIBRARY BEHAVIOUR WORDS
    with "$1" "$2" render paths refused 2>"$tmp/said" && return 1
    cat "$tmp/said"
    grep -qF "/filter/residual: $3" "$tmp/said" && [ ! -e "$tmp/refused.exr" ]
}
env_free() { SHEARWATER_PEER_WEIGHTS= "$@"; }
check "a machine without it refuses the job" refused absent - "Open Image Denoise 2 is not installed on the coordinator's machine ("
check "a library that lacks a function is refused" refused lacks half "libOpenImageDenoise.so.2 lacks oidnSetFilterBool, which Open Image Denoise 2 has"
check "version 1 is refused" refused fake version "Open Image Denoise 1.4.3 is installed, but oidn needs a version 2"
check "a machine that it has no device for is refused" refused fake nowhere "Open Image Denoise: this CPU is too old"
check "... or whose device fails" refused fake device "Open Image Denoise: the device is out of order"
check "the network without weights is refused" env_free refused network - "Open Image Denoise: SHEARWATER_PEER_WEIGHTS names no weights"
check "other jobs ask for no library" with absent - render plain plain

# Light as it is, and half of it.
check "paths go through it" with fake same render paths same
check "... and come back changed" with fake half render paths half
names='["R","G","B"] | map([., "direct." + ., "indirect." + ., "emission." + .])[]'
pixels() { # pixels COMMAND-OF-JQ: of each pixel of three rows, of both pictures: $same, $half
    local x y
    for y in 3 20 41; do for x in 0 9 23 35 48 69; do
        jq -n -e --argjson same "$("$build/tests/bench/exr_pixel" "$tmp/same.exr" $x $y)" --argjson half "$("$build/tests/bench/exr_pixel" "$tmp/half.exr" $x $y)" "$1" || return 1
    done; done
}
check "what is given back stands in the picture" pixels "[$names | . as \$n | (\$same[\$n[0]] - (\$n[1:] | map(\$same[.]) | add)) | fabs < 1e-5] | all"
check "... half where it is half" pixels "[$names | (\$half[.[0]] - 0.5 * \$same[.[0]]) | fabs < 1e-8] | all"
equal() { compared "$1" "$2" "$3" | jq -e '.rmse == 0'; }
for layer in direct indirect emission albedo normal; do check "the layer $layer is the plain mean" equal same half $layer; done
check "fields that bring all leave nothing to it" with fake half render covered covered
check "... so that the picture is that of auto" with absent - render covered_auto covered_auto
check "... to the last bit" equal covered covered_auto beauty
check "paths through a lens go through it" with fake same render lens lens_same
check "... as paths of pixels" with fake half render lens lens_half
halves() { figure "$1" "$2" | jq -e '(.mean_test | add) as $t | (.mean_reference | add) as $r | $r > 0 and (2 * $t / $r - 1 | fabs) < 1e-6'; }
check "... with half the light where it halves it" halves lens_same lens_half
with fake half "$build/shearwater" render "$tmp/frames.json" --quiet -o "$tmp/frames.%d.exr"
check "frames of a sequence go through it one by one" with fake half render single single
check "... so that a frame alone has the same light" bash -c "'$build/shearwater' compare '$tmp/single.exr' '$tmp/frames.2.exr' | jq -e '.rmse == 0'"

# A room with mirrors and windows.
room() { # room METHOD
    local place=$PWD/tests/scenes/grey-white-room
    printf '{"scene": {"file": "%s/room.glb"}, "environment": {"file": "%s/sky.hdr"}, "image": {"width": 96, "height": 64}, "effects": {"indirect_bounces": 4},
        "sampling": {"spp": 4}, "layers": ["beauty", "albedo", "normal"], "filter": {"method": "none", "residual": "%s"}}' "$place" "$place" "$1" >"$tmp/room_$1.json"
    with fake same render "room_$1" "room_$1"
}
check "a room with mirrors goes through it" room oidn
check "... as well as by halves" room halves
check "... with the same guides: what mirrors show" equal room_oidn room_halves albedo

# What tells of it.
says() { strings -a "$tmp/$1.exr" | grep -A 2 shearwater:denoiser | grep -q "Open Image Denoise $2"; }
check "the file names it, with its version" says same 2.3.99
check "other files name none" bash -c "! grep -q denoiser '$tmp/plain.exr'"
check "its CPU time counts" counts half '.cpu_s.oidn > 0'
check "... where it runs alone" counts plain '.cpu_s.oidn == 0'

# The same bytes on one machine.
check "workers and tiles change nothing" with fake half render tiles other --workers 2
check "... of the picture" equal half other beauty

# What goes wrong while it runs.
fails() { # fails BEHAVIOUR WORDS
    with fake "$1" render paths failed 2>"$tmp/said" && return 1
    cat "$tmp/said"
    grep -qF "$2" "$tmp/said" && [ ! -e "$tmp/failed.exr" ]
}
check "numbers that are none end the frame" fails nan "frame 1: Open Image Denoise 2.3.99 gave 1 numbers of 9450 that are not finite"
check "errors of its own do" fails execute "frame 1: Open Image Denoise 2.3.99: it was asked to fail"
check "... also without a word" fails filter "frame 1: Open Image Denoise 2.3.99 makes no filter"
check "short memory makes the frame begin again" with fake memory render paths again
check "... and it gets its picture" equal half again beauty

# Its network: weights that pass colours on give the picture back.
node tests/system/pass_weights.mjs 0 "$tmp/colour.tza"
network() { SHEARWATER_PEER_WEIGHTS=$1 with network - render "${@:2}"; }
check "the network runs" network "$tmp/colour.tza" paths passed
near() { figure "$1" "$2" | jq -e '.rmse < 1e-4 * .mean_reference[0]'; }
check "... and passes on what it was given" near same passed
check "... in CPU time of its own" counts passed '.cpu_s.oidn > 0 and .cpu_s.residual == 0'
weights=${SHEARWATER_PEER_WEIGHTS:-$build/peer/rt_hdr_alb_nrm.tza}
document many '"sampling": {"spp": 1024, "seed": 9}, "effects": {"indirect_bounces": 2}, "filter": {"method": "none"}'
if [ -e "$weights" ]; then
    check "a picture of many paths" render many many
    check "with trained weights the network runs" network "$weights" paths denoised
    error() { figure many "$1" | jq .relmse; }
    cleaner() { echo "$(error plain) $(error denoised)"; jq -n -e --argjson a "$(error plain)" --argjson b "$(error denoised)" '$b < $a / 3'; }
    check "... and has a third of the error at most" cleaner
else
    skip "the trained network" "there are no weights (make peer-weights)"
fi

# The service.
serve_fake() { with "$1" "$2" serve_start "$tmp/data" --workers 2 --worker-threads 1; }
members='"image": {"width": 96, "height": 64}, "sampling": {"spp": 4, "tile_px": 16}, "filter": {"method": "none", "residual": "oidn"}'
check "a server without it starts" serve_fake absent -
asset=$(sha256sum <tests/scenes/cornell-box/cornell-box.glb | cut -c1-64)
http -T tests/scenes/cornell-box/cornell-box.glb -o "$tmp/body" "$url/v1/assets/$asset"
post() { http -H 'Content-Type: application/json' -d "{\"scene\": {\"asset\": \"$asset\"}, $members}" "$url/v1/jobs$1"; }
answers() { post "$1" | jq -e '.status == 422 and ([.. | strings | select(. == "/filter/residual")] | length) > 0'; }
check "it refuses a job" answers ''
check "... and its plan" answers '?dry_run=1'
serve_stop
check "a server whose library takes long to load starts" serve_fake fake slow
served_meanwhile() {
    local loading
    post '?dry_run=1' >"$tmp/slow" & loading=$!
    nap 0.5
    http --max-time 2 -o "$tmp/body" "$url/v1/health" && kill -0 $loading || return 1 # it still loads
    wait $loading && jq -e '.plan.residual_filter == "oidn"' "$tmp/slow"
}
check "it serves others while it loads the library" served_meanwhile
serve_stop
check "a server with it starts" serve_fake fake half
planned() { post '?dry_run=1' | jq -e '.plan | .residual_filter == "oidn" and any(.light_filters[]; .filter == "oidn")'; }
check "it plans the job" planned
id=$(post '' | jq -r .id)
check "it renders it" await_state "$id" finished 60
check "... and counts its time for metrics" bash -c "curl -sS --noproxy '*' '$url/metrics' | grep -qE '^shearwater_cpu_seconds_total\{stage=\"oidn\"\} (0\.[0-9]*[1-9]|[1-9])'"
live=$(members="$members, \"live\": true" post '' | jq -r .id)
check "a live job comes to rest" await_state "$live" resting 60
exr "$live" "$tmp/live.exr"; exr "$id" "$tmp/still.exr"
check "... with the filtered picture" equal live still beauty
check "... by name" says live 2.3.99
move() { http -f -o "$tmp/moved" -X PATCH -H 'Content-Type: application/json' -d '{"camera": {"eye": [1, 1.2, 3], "target": [0, 1, 0], "up": [0, 1, 0], "yfov_deg": 50}}' "$url/v1/jobs/$live"; }
check "its camera is moved" move
check "... and it rests again" await_state "$live" resting 60
http -o "$tmp/body" -X DELETE "$url/v1/jobs/$live"
members=${members/64/720} members=${members/96/960} id=$(post '' | jq -r .id)
check "a job that is begun" pause_at "$id" 3
serve_stop KILL
check "a server that has lost it starts" serve_fake absent -
"$build/shearwater" steer "$id" --server "$url" --resume >/dev/null
fails_so() { shows "$id" '.state == "failed" and (.error | tostring | test("is not installed"))'; }
check "... and ends the job with the reason" eventually 30 fails_so
serve_stop
tap_done
