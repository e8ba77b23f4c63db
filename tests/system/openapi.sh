#!/usr/bin/env bash
# proto/openapi.yaml against the running server: every route is documented, every documented
# operation answers as it says, and the job schema and the server agree on what a job is.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/openapi.sh BUILD_DIR}
. tests/tap.bash
if ! command -v node >/dev/null || [ ! -d tests/browser/node_modules/yaml ]; then
    skip "the contract and the server agree" "needs node and its package yaml: make deps-browser"
    tap_done
fi
coproc JUDGE { exec node tests/system/contract.mjs judge; }
track $JUDGE_PID
exec 7>&"${JUDGE[1]}" 8<&"${JUDGE[0]}"
contract() { # asks the judge; see contract.mjs
    local line
    (IFS=$'\t'; printf '%s\n' "$*") >&7
    while IFS= read -r line <&8; do
        case $line in "= "*) return "${line#= }" ;; esac
        printf '%s\n' "$line"
    done
    return 1
}
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
none=00000000000000000000000000

# The document alone, and beside the table of routes.
check "the contract is in order" contract structure
sed -n 's/^ROUTE([A-Z_]*, \([A-Z]*\), "\([^"]*\)", [a-z_]*, [A-Z]*, "\([^"]*\)")$/\1 \2 \3/p' \
    server/http/route.def | while read -r method path query; do
    [ "$query" = '*' ] && query=
    echo "$method $path $(tr ' ' '\n' <<<"$query" | sed '/^$/d' | sort | paste -sd,)"
done | sort >"$tmp/routes"
contract operations | sort >"$tmp/documented"
check "every route is read from its table" test "$(wc -l <"$tmp/routes")" = "$(grep -c '^ROUTE(' server/http/route.def)"
check "every route and its query is documented, and nothing else" diff "$tmp/routes" "$tmp/documented"

serve_start "$tmp/data" --workers 1 --worker-threads 1 || { echo "Bail out! the server did not start"; exit 1; }
: >"$tmp/seen"

# answers STATUS METHOD PATH-IN-THE-CONTRACT CURL-ARGUMENTS... TARGET
answers() {
    local want=$1 method=$2 path=$3 target=${!#}
    set -- "${@:4:$#-4}"
    local how=(-X "$method") got
    [ "$method" = HEAD ] && how=(-I)
    : >"$tmp/body"
    got=$(curl -sS --noproxy '*' --path-as-is --max-time "${wait_s:-30}" "${how[@]}" -o "$tmp/body" -D "$tmp/head" \
        -w '%{http_code} %{content_type}' "$@" "$url$target")
    # What curl wrote for HEAD is the head.
    [ "$method" = HEAD ] && : >"$tmp/body"
    local status=${got%% *} type=${got#* }
    type=${type%%;*}
    echo "$method $path $status" >>"$tmp/seen"
    [ "$status" = "$want" ] || { echo "status $status, not $want"; head -c 500 "$tmp/body"; return 1; }
    contract check "$method" "$path" "$status" "$type" "$tmp/head" "$tmp/body" || { head -c 2000 "$tmp/body"; return 1; }
}
try() { check "$2 $3 answers $1" answers "$@"; }
json=(-H 'Content-Type: application/json')
header() { sed -n "s/^$1: //Ip" "$tmp/head" | tr -d '\r'; }
long=/$(head -c 5000 /dev/zero | tr '\0' a)

# Assets.
asset=$(sha256sum <"$scene" | cut -c1-64)
p='/v1/assets/{sha256}'
try 404 HEAD $p "/v1/assets/$asset"
try 201 PUT $p -T "$scene" "/v1/assets/$asset"
try 200 PUT $p -T "$scene" "/v1/assets/$asset"
try 200 HEAD $p "/v1/assets/$asset"
try 400 HEAD $p "/v1/assets/short"
try 400 PUT $p -T "$scene" "/v1/assets/short"
try 422 PUT $p -T "$scene" "/v1/assets/$(printf '%064d' 1)"
try 413 PUT $p -H 'Content-Length: 2147483649' -H 'Expect: 100-continue' -d x "/v1/assets/$asset"

# A map of 4 x 2 texels of radiance 1.
{ printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n'; for _ in 1 2 3 4 5 6 7 8; do printf '\x80\x80\x80\x81'; done; } >"$tmp/map.hdr"
map=$(sha256sum <"$tmp/map.hdr" | cut -c1-64)
try 422 POST /v1/jobs "${json[@]}" -d "{\"scene\": {\"asset\": \"$asset\"}, \"environment\": {\"asset\": \"$map\"}}" /v1/jobs
check "... because the map is not there" jq -e '.pointer == "/environment/asset" and (.type | endswith("missing-asset"))' "$tmp/body"
try 201 PUT $p -T "$tmp/map.hdr" "/v1/assets/$map"

# Jobs: documents on which schema and server must agree. The server only checks (dry_run).
scene_member="\"scene\": {\"asset\": \"$asset\"}"
rectangle='"type": "rectangle", "center": [0, 1.9, 0], "half_u": [0.2, 0, 0], "half_v": [0, 0, 0.2]'
good=("{$scene_member}"
    "{\"scene\": {\"asset\": \"$asset\", \"files\": {}, \"camera\": null, \"lights\": true}}"
    "{\"scene\": {\"asset\": \"$asset\", \"camera\": 0}}"
    "{\"scene\": {\"asset\": \"$asset\", \"camera\": {\"eye\": [0, 1, 4], \"target\": [0, 1, 0], \"up\": [0, 1, 0], \"yfov_deg\": 179}}}"
    "{$scene_member, \"image\": {\"width\": 1, \"height\": 16384, \"pixel_type\": \"half\"}}"
    "{$scene_member, \"image\": {\"view\": \"agx\", \"exposure\": -32, \"png_bits\": 16, \"png_alpha\": true, \"exr_compression\": \"piz\"}}"
    "{$scene_member, \"lights\": [{$rectangle, \"radiance\": [1, 1, 1], \"profile\": \"gaussian\"}]}"
    "{$scene_member, \"lights\": [{\"type\": \"point\", \"position\": [0, 1, 0], \"intensity\": [1, 0, 0]},
        {\"type\": \"directional\", \"direction\": [0, -2, 0], \"irradiance\": [0, 1, 0]},
        {\"type\": \"spot\", \"position\": [0, 1, 0], \"direction\": [0, -1, 0], \"intensity\": [0, 0, 9], \"inner_deg\": 10, \"outer_deg\": 90}]}"
    "{$scene_member, \"effects\": {\"indirect_bounces\": 0, \"ambient_occlusion\": false}}"
    "{$scene_member, \"effects\": {\"indirect_bounces\": 64, \"ambient_occlusion\": {\"distance\": 0.5}}}"
    "{$scene_member, \"environment\": null, \"lens\": null}"
    "{$scene_member, \"environment\": {\"radiance\": [0, 1, 1e12]}}"
    "{$scene_member, \"environment\": {\"asset\": \"$map\"}}"
    "{$scene_member, \"environment\": {\"asset\": \"$map\", \"intensity\": 2.5, \"rotation_deg\": -360}}"
    "{$scene_member, \"lens\": {\"aperture_radius\": 0}}"
    "{$scene_member, \"lens\": {\"aperture_radius\": 0.1, \"focus_distance\": 5, \"blades\": 32, \"blade_rotation_deg\": 12.5}}"
    "{$scene_member, \"effects\": {\"ambient_occlusion\": {\"distance\": 1}}, \"filter\": {\"method\": \"none\"},
        \"layers\": [\"error\", \"occlusion\", \"diffuse_direct\", \"diffuse_indirect\"]}"
    "{$scene_member, \"sampling\": {\"spp\": 65536, \"light_spp\": 1, \"indirect_spp\": 0, \"seed\": 9007199254740992, \"tile_px\": 8}}"
    "{$scene_member, \"sampling\": {\"spp\": 4, \"target_error\": 0.02, \"max_spp\": 256}}"
    "{$scene_member, \"filter\": {\"method\": \"none\", \"mu\": 100}}"
    "{$scene_member, \"filter\": {\"method\": \"sheared\", \"mu\": 0.5}, \"layers\": [\"beauty\", \"filter_width\"]}"
    "{$scene_member, \"filter\": {\"method\": \"axis_aligned\"}}"
    "{$scene_member, \"filter\": {\"indirect\": \"average\"}}"
    "{$scene_member, \"filter\": {\"method\": \"average\", \"indirect\": \"blend\"}}"
    "{$scene_member, \"filter\": {\"indirect\": \"adaptive\", \"mu\": 2}}"
    "{$scene_member, \"filter\": {\"glossy\": \"bandlimit\"}}"
    "{$scene_member, \"layers\": [\"beauty\", \"direct\", \"indirect\", \"albedo\", \"normal\", \"depth\", \"samples\", \"visibility\", \"slope_min\", \"slope_max\", \"emission\", \"id\"]}"
    "{$scene_member, \"name\": null, \"comment\": \"two\\nlines\", \"labels\": [], \"webhook\": null}"
    "{$scene_member, \"name\": \"$(printf 'ä%.0s' {1..200})\", \"labels\": [\"b\", \"a:1\"]}"
    "{$scene_member, \"backplate\": null, \"rgbd\": null, \"catchers\": [\"Floor\", {\"ground\": {\"height\": -1}}], \"holdouts\": []}"
    "{$scene_member, \"catchers\": [{\"ground\": {\"height\": 0}}], \"composite\": {\"mode\": \"additive\"}, \"layers\": [\"catcher\", \"overlay\"]}"
    "{$scene_member, \"frames\": {\"first\": 0, \"last\": 99999}, \"priority\": -100}")
bad=('{}' '[]' '{"scene": {}}' '{"scene": {"asset": "x"}}' "{$scene_member, \"fast\": true}"
    "{\"scene\": {\"asset\": \"$asset\", \"file\": \"a.glb\"}}"
    "{\"scene\": {\"asset\": \"$asset\", \"camera\": -1}}"
    "{\"scene\": {\"asset\": \"$asset\", \"camera\": true}}"
    "{\"scene\": {\"asset\": \"$asset\", \"camera\": {\"eye\": [0, 1], \"target\": [0, 1, 0]}}}"
    "{\"scene\": {\"asset\": \"$asset\", \"camera\": {\"eye\": [0, 1, 4]}}}"
    "{\"scene\": {\"asset\": \"$asset\", \"camera\": {\"eye\": [0, 1, 4], \"target\": [0, 1, 0], \"yfov_deg\": 180}}}"
    "{\"scene\": {\"asset\": \"$asset\", \"lights\": 1}}"
    "{\"scene\": {\"asset\": \"$asset\", \"files\": {\"a.bin\": \"b\"}}}"
    "{$scene_member, \"image\": {\"width\": 0}}" "{$scene_member, \"image\": {\"width\": 16385}}"
    "{$scene_member, \"image\": {\"width\": 1.5}}" "{$scene_member, \"image\": {\"pixel_type\": \"byte\"}}"
    "{$scene_member, \"image\": {\"view\": \"aces\"}}" "{$scene_member, \"image\": {\"exposure\": 32.5}}"
    "{$scene_member, \"image\": {\"png_bits\": 12}}" "{$scene_member, \"image\": {\"png_alpha\": 1}}"
    "{$scene_member, \"image\": {\"exr_compression\": \"b44\"}}"
    "{$scene_member, \"image\": []}" "{$scene_member, \"lights\": [{\"type\": \"sun\"}]}"
    "{$scene_member, \"lights\": [{$rectangle}]}"
    "{$scene_member, \"lights\": [{$rectangle, \"radiance\": [-1, 0, 0]}]}"
    "{$scene_member, \"lights\": [{$rectangle, \"radiance\": [1, 1, 1], \"intensity\": [1, 1, 1]}]}"
    "{$scene_member, \"lights\": [{\"type\": \"point\", \"position\": [0, 1e30, 0], \"intensity\": [1, 0, 0]}]}"
    "{$scene_member, \"effects\": {\"indirect_bounces\": 65}}" "{$scene_member, \"effects\": {\"ambient_occlusion\": true}}"
    "{$scene_member, \"sampling\": {\"spp\": 0}}" "{$scene_member, \"sampling\": {\"spp\": 65537}}"
    "{$scene_member, \"sampling\": {\"seed\": -1}}" "{$scene_member, \"sampling\": {\"tile_px\": 7}}"
    "{$scene_member, \"sampling\": {\"target_error\": 1001}}" "{$scene_member, \"sampling\": {\"max_spp\": 65537}}" "{$scene_member, \"filter\": {\"method\": \"shear\"}}"
    "{$scene_member, \"filter\": {\"indirect\": \"none\"}}" "{$scene_member, \"filter\": {\"glossy\": \"none\"}}"
    "{$scene_member, \"filter\": {\"lens\": \"none\"}}"
    "{$scene_member, \"filter\": {\"mu\": 0}}" "{$scene_member, \"layers\": []}"
    "{$scene_member, \"layers\": [\"beauty\", \"beauty\"]}" "{$scene_member, \"layers\": [\"filter_widths\"]}"
    "{$scene_member, \"frames\": {\"first\": -1}}" "{$scene_member, \"priority\": 101}"
    "{$scene_member, \"effects\": {\"ambient_occlusion\": {}}}"
    "{$scene_member, \"name\": \"\"}" "{$scene_member, \"name\": \"a\\nb\"}" "{$scene_member, \"name\": \"a\\u202eb\"}"
    "{$scene_member, \"name\": \"$(printf 'ä%.0s' {1..201})\"}" "{$scene_member, \"comment\": \"\\u0007\"}"
    "{$scene_member, \"labels\": [\"a\", \"a\"]}" "{$scene_member, \"labels\": [\"a,b\"]}" "{$scene_member, \"labels\": null}"
    "{$scene_member, \"webhook\": {}}" "{$scene_member, \"webhook\": {\"url\": \"ftp://a/\"}}" "{$scene_member, \"webhook\": \"http://a/\"}"
    "{$scene_member, \"effects\": {\"ambient_occlusion\": {\"distance\": 0}}}"
    "{$scene_member, \"environment\": {}}" "{$scene_member, \"environment\": []}"
    "{$scene_member, \"environment\": {\"asset\": \"$map\", \"radiance\": [1, 1, 1]}}"
    "{$scene_member, \"environment\": {\"radiance\": [1, 1, 1], \"intensity\": 2}}"
    "{$scene_member, \"environment\": {\"asset\": \"$map\", \"intensity\": -1}}"
    "{$scene_member, \"environment\": {\"asset\": \"$map\", \"rotation_deg\": 361}}"
    "{$scene_member, \"environment\": {\"file\": \"sky.hdr\"}}"
    "{$scene_member, \"backplate\": {}}" "{$scene_member, \"backplate\": {\"asset\": \"$map\", \"fit\": \"contain\"}}"
    "{$scene_member, \"backplate\": {\"file\": \"photo.jpg\"}}" "{$scene_member, \"catchers\": {\"ground\": {\"height\": 0}}}"
    "{$scene_member, \"catchers\": [\"\"]}" "{$scene_member, \"catchers\": [{\"ground\": {}}]}"
    "{$scene_member, \"holdouts\": [{\"ground\": {\"height\": 0}}]}" "{$scene_member, \"holdouts\": [\"a\", \"a\"]}"
    "{$scene_member, \"composite\": {\"mode\": \"over\"}}"
    "{$scene_member, \"rgbd\": {}}" "{$scene_member, \"rgbd\": {\"document\": 1}}"
    "{$scene_member, \"rgbd\": {\"document\": \"a.json\", \"fit\": \"cover\"}}" "{$scene_member, \"rgbd\": {\"file\": \"a.json\"}}"
    "{$scene_member, \"lens\": {}}" "{$scene_member, \"lens\": {\"focus_distance\": 2}}"
    "{$scene_member, \"lens\": {\"aperture_radius\": -1, \"focus_distance\": 2}}"
    "{$scene_member, \"lens\": {\"aperture_radius\": 1, \"focus_distance\": 2, \"blades\": 33}}")
agree() { # agree STATUS DOCUMENT
    printf '%s' "$2" >"$tmp/document"
    local fits=200
    contract schema Job "$tmp/document" >"$tmp/misfits" || fits=422
    [ $fits = "$1" ] || { echo "the schema says $fits"; cat "$tmp/misfits"; return 1; }
    answers "$1" POST /v1/jobs "${json[@]}" --data-binary @"$tmp/document" "/v1/jobs?dry_run=1"
}
for document in "${good[@]}"; do check "schema and server accept ${document:0:160}" agree 200 "$document"; done
. tests/system/openapi_plans.bash
for document in "${bad[@]}"; do check "schema and server refuse $document" agree 422 "$document"; done

p=/v1/jobs
try 200 GET $p /v1/jobs
try 202 POST $p "${json[@]}" -H 'Idempotency-Key: k' -d "{$scene_member, \"image\": {\"width\": 80, \"height\": 72}, \"layers\": [\"beauty\", \"depth\"]}" /v1/jobs
id=$(jq -r .id "$tmp/body")
try 409 POST $p "${json[@]}" -H 'Idempotency-Key: k' -d "{$scene_member}" /v1/jobs
try 400 POST $p "${json[@]}" -d '{' /v1/jobs
try 413 POST $p "${json[@]}" -H 'Content-Length: 1048577' -H 'Expect: 100-continue' -d '{}' /v1/jobs
try 415 POST $p -d '{}' /v1/jobs
try 403 POST $p "${json[@]}" -H 'Origin: http://evil.example' -d '{}' /v1/jobs
try 414 GET $p "/v1/jobs?cursor=$long"
try 421 GET $p -H 'Host: evil.example' /v1/jobs
try 431 GET $p -H "X-Long: $long$long$long$long" /v1/jobs
try 400 GET $p '/v1/jobs?limit=0'

p='/v1/jobs/{id}'
# A second job on a large picture, to be looked at and cancelled while it runs.
try 202 POST /v1/jobs "${json[@]}" -d "{$scene_member, \"image\": {\"width\": 1536, \"height\": 1536}, \"sampling\": {\"spp\": 64}, \"priority\": -1}" /v1/jobs
running=$(jq -r .id "$tmp/body")
check "the small job finishes" await_state "$id" finished 120
try 200 GET $p "/v1/jobs/$id"
cp "$tmp/body" "$tmp/job"
jq .document "$tmp/job" >"$tmp/document"
check "its document is one that can be submitted again" contract schema Job "$tmp/document"
try 304 GET $p -H "If-None-Match: $(header ETag)" "/v1/jobs/$id"
try 404 GET $p "/v1/jobs/$none"
check "the large job runs" await_state "$running" running 60
try 200 GET $p "/v1/jobs/$running"
try 200 GET /v1/jobs '/v1/jobs?limit=1'
check "... with a link to the next page" grep -q 'rel="next"' "$tmp/head"
next=$(jq -r .next "$tmp/body")
try 200 GET /v1/jobs "/v1/jobs?cursor=$next&state=finished"
try 304 GET /v1/jobs -H "If-None-Match: $(header ETag)" "/v1/jobs?cursor=$next&state=finished"
try 200 GET /v1/jobs "/v1/jobs?limit=1&text=${asset:0:20}"
check "... and the next page is looked through, too" grep -q "&text=${asset:0:20}>; rel=.next" "$tmp/head"
try 400 GET /v1/jobs '/v1/jobs?text='
for name in 'Gulls, first' 'gulls, second'; do
    try 202 POST /v1/jobs "${json[@]}" -d "{$scene_member, \"image\": {\"width\": 8, \"height\": 8}, \"name\": \"$name\",
        \"labels\": [\"sc 1\"]}" /v1/jobs
done
try 200 GET /v1/jobs '/v1/jobs?limit=1&name=GULLS%2C&label=sc%201'
check "a name and a label find jobs" jq -e '.jobs[0].name == "gulls, second" and .jobs[0].labels == ["sc 1"]' "$tmp/body"
check "... and the next page looks for them, too" grep -q '&name=GULLS%2C&label=sc%201>; rel=.next' "$tmp/head"
try 200 GET /v1/jobs "/v1/jobs?limit=1&name=gulls&cursor=$(jq -r .next "$tmp/body")"
check "... and ends with the first" jq -e '.jobs[0].name == "Gulls, first" and .next == null' "$tmp/body"
try 200 GET /v1/jobs '/v1/jobs?label=sc'
check "a part of a label finds none" jq -e '.jobs == []' "$tmp/body"
check "the command line lists what it found" eval '"$build/shearwater" jobs --server "$url" --name gulls, --label "sc 1" | grep -c "ulls, .* \[sc 1\]" | grep -qx 2'
try 400 GET /v1/jobs '/v1/jobs?name='
try 400 GET /v1/jobs '/v1/jobs?label=a,b'
check "a finished job tells what happened to it" jq -e '(.log | map(.what)) == ["state", "state", "state", "frame", "frame", "state"] and
    .log[0].time == .created and .log[-1].text == "finished: all files are stored"' "$tmp/job"

# A live one is moved.
try 202 POST /v1/jobs "${json[@]}" -d "{$scene_member, \"image\": {\"width\": 64, \"height\": 48}, \"live\": true}" /v1/jobs
live=$(jq -r .id "$tmp/body")
check "the live job rests" await_state "$live" resting 60
try 200 GET $p "/v1/jobs/$live"
try 200 PATCH $p "${json[@]}" -d '{"camera": {"eye": [1, 1, 5], "target": [0, 1, 0]}}' "/v1/jobs/$live"
try 422 PATCH $p "${json[@]}" -d '{"camera": {"eye": [0, 1, 0], "target": [0, 1, 0]}}' "/v1/jobs/$live"
try 400 PATCH $p "${json[@]}" -d '{' "/v1/jobs/$live"
try 415 PATCH $p -d '{}' "/v1/jobs/$live"
try 413 PATCH $p "${json[@]}" -H 'Content-Length: 1048577' -H 'Expect: 100-continue' -d '{}' "/v1/jobs/$live"
try 404 PATCH $p "${json[@]}" -d '{"camera": null}' "/v1/jobs/$none"
try 409 PATCH $p "${json[@]}" -d '{"camera": null}' "/v1/jobs/$id"
try 202 DELETE $p "/v1/jobs/$live"
check "the live job is cancelled" await_state "$live" cancelled 60
try 204 GET $p/thumbnail "/v1/jobs/$live/thumbnail"

p='/v1/jobs/{id}/frames/{n}/image.exr'
try 200 GET $p "/v1/jobs/$id/frames/1/image.exr"
try 304 GET $p -H "If-None-Match: $(header ETag)" "/v1/jobs/$id/frames/1/image.exr"
try 206 GET $p -H 'Range: bytes=0-9' "/v1/jobs/$id/frames/1/image.exr"
try 416 GET $p -H 'Range: bytes=999999999-' "/v1/jobs/$id/frames/1/image.exr"
try 404 GET $p "/v1/jobs/$id/frames/7/image.exr"
p='/v1/jobs/{id}/thumbnail'
try 200 GET $p "/v1/jobs/$id/thumbnail"
small() { # small: the answer is a PNG of at most 160 px, and not a black one
    [ "$(head -c 8 "$tmp/body" | xxd -p)" = 89504e470d0a1a0a ] && [ "$(stat -c %s "$tmp/body")" -gt 500 ] &&
        (( 16#$(xxd -s 16 -l 4 -p "$tmp/body") <= 160 && 16#$(xxd -s 20 -l 4 -p "$tmp/body") <= 160 ))
}
check "it is a small PNG" small
tag=$(header ETag) && cp "$tmp/body" "$tmp/thumbnail"
try 304 GET $p -H "If-None-Match: $tag" "/v1/jobs/$id/thumbnail?of=x"
try 200 GET $p "$(jq -r .thumbnail "$tmp/job")"
check "the second time it is the kept one, the same" eval '[ "$(header ETag)" = "$tag" ] && cmp "$tmp/body" "$tmp/thumbnail"'
try 404 GET $p "/v1/jobs/$none/thumbnail"
try 400 GET $p "/v1/jobs/$id/thumbnail?size=9"
p='/v1/jobs/{id}/frames/{n}/image.png'
try 200 GET $p "/v1/jobs/$id/frames/1/image.png"
try 304 GET $p -H "If-None-Match: $(header ETag)" "/v1/jobs/$id/frames/1/image.png"
try 206 GET $p -H 'Range: bytes=0-9' "/v1/jobs/$id/frames/1/image.png"
try 416 GET $p -H 'Range: bytes=999999999-' "/v1/jobs/$id/frames/1/image.png"
try 200 GET $p "/v1/jobs/$id/frames/1/image.png?layer=depth&exposure=1.5"
try 200 GET $p "/v1/jobs/$id/frames/1/image.png?view=filmic&bits=16&alpha=1"
try 404 GET $p "/v1/jobs/$id/frames/1/image.png?layer=normal"
try 400 GET $p "/v1/jobs/$id/frames/1/image.png?view=aces"
try 400 GET $p "/v1/jobs/$id/frames/1/image.png?bits=12"
try 400 GET $p "/v1/jobs/$id/frames/1/image.png?alpha=2"
try 400 GET $p "/v1/jobs/$id/frames/1/image.png?layer=paint"
so_far() { # the picture of a running frame, once it has a first tile
    local end=$((SECONDS + 60 * slower))
    while [ $SECONDS -lt $end ]; do
        answers 200 GET "/v1/jobs/{id}/frames/{n}/image.$1" "/v1/jobs/$running/frames/1/image.$1" && break
        sleep 0.3
    done
    grep -qi '^cache-control: no-store' "$tmp/head"
}
check "a PNG of the picture so far" so_far png
check "an EXR of the picture so far" so_far exr

# Feeds and steering.
. tests/system/openapi_live.bash

# Workers, the end of jobs.
try 200 GET /v1/workers /v1/workers
worker=$(jq -r '.workers[0].id' "$tmp/body")
p='/v1/workers/{worker}'
try 200 PATCH $p "${json[@]}" -d '{"drain": false}' "/v1/workers/$worker"
try 404 PATCH $p "${json[@]}" -d '{"drain": true}' /v1/workers/999999999
try 415 PATCH $p -d '{}' "/v1/workers/$worker"
try 422 PATCH $p "${json[@]}" -d '{"drain": 1}' "/v1/workers/$worker"
try 422 PATCH $p "${json[@]}" -d '{"drian": true}' "/v1/workers/$worker"
try 413 PATCH $p "${json[@]}" -H 'Content-Length: 1048577' -H 'Expect: 100-continue' -d '{}' "/v1/workers/$worker"
try 409 DELETE '/v1/assets/{sha256}' "/v1/assets/$asset"
check "... because of the job that has not ended" jq -e --arg id "$running" '(.type | endswith("asset-in-use")) and (.detail | contains($id))' "$tmp/body"
p='/v1/jobs/{id}'
try 202 DELETE $p "/v1/jobs/$running"
check "the job is cancelled" await_state "$running" cancelled 30
try 409 DELETE $p "/v1/jobs/$running"
try 409 GET '/v1/jobs/{id}/pixels' "/v1/jobs/$running/pixels"
wait_s=5 try 200 GET '/v1/jobs/{id}/events' "/v1/jobs/$running/events"
try 204 DELETE $p "/v1/jobs/$running?purge=1"
try 404 DELETE $p "/v1/jobs/$running"
printf 'this is no scene' >"$tmp/noise"
noise=$(sha256sum <"$tmp/noise" | cut -c1-64)
try 201 PUT '/v1/assets/{sha256}' -T "$tmp/noise" "/v1/assets/$noise"
try 422 POST /v1/jobs "${json[@]}" -d "{\"scene\": {\"asset\": \"$noise\"}}" '/v1/jobs?dry_run=1'
try 202 POST /v1/jobs "${json[@]}" -d "{\"scene\": {\"asset\": \"$noise\"}}" /v1/jobs
failed=$(jq -r .id "$tmp/body")
check "a job whose scene is none fails" await_state "$failed" failed 30
try 200 GET $p "/v1/jobs/$failed"
check "... and says why" jq -e '.error.detail | length > 0' "$tmp/body"

# Without tokens nobody is asked who he is; tests/system/access.sh has the rest.
try 200 GET /v1/stats /v1/stats
try 200 GET /v1/session /v1/session
try 204 POST /v1/session -d '' /v1/session
try 204 DELETE /v1/session /v1/session

# The server's own.
for path in /livez /readyz /metrics /openapi.yaml /; do try 200 GET $path $path; done
try 304 GET / -H "If-None-Match: $(header ETag)" /
try 200 GET /openapi.yaml /openapi.yaml
check "... the file in the sources" cmp "$tmp/body" proto/openapi.yaml
try 304 GET /openapi.yaml -H "If-None-Match: $(header ETag)" /openapi.yaml
for file in $(cd web && find . -type f -not -name '.*' | sed 's/^\.//'); do try 200 GET '/{file}' "$file"; done
try 304 GET '/{file}' -H "If-None-Match: $(header ETag)" "$file"

# Assets go last: others need them.
p='/v1/assets/{sha256}'
try 204 DELETE $p "/v1/assets/$noise"
try 404 DELETE $p "/v1/assets/$noise"
try 400 DELETE $p "/v1/assets/short"

# Methods that a path does not have.
concrete() { sed "s/{sha256}/$asset/; s/{id}/$id/; s/{n}/1/; s/{worker}/$worker/; s/{file}/main.js/" <<<"$1"; }
not_allowed() { # every other method of a path
    local path=$1 known method target answer head
    known=$'\n'$(<"$tmp/documented") target=$(concrete "$path")
    for method in GET HEAD PUT POST PATCH DELETE OPTIONS BREW; do
        [[ $known == *$'\n'"$method $path "* ]] && continue
        [ $method = HEAD ] && [[ $known == *$'\n'"GET $path "* ]] && continue
        ask "$target" $method
        exec {answer}>&-
        [[ ${head,,} == "http/1.1 405 "*$'\nallow: '* ]] || { echo "$method: $head"; return 1; }
    done
}
for path in $(awk '{print $2}' "$tmp/documented" | sort -u); do
    check "$path refuses other methods" not_allowed "$path"
done
serve_stop

# What the tests above cannot bring about for each route: limits and troubles that all routes share
# (tests/system/http.sh has them, and load.sh quotas), a server without files, one that shuts down.
serve_start "$tmp/idle" --workers 0
try 503 GET /readyz /readyz
serve_stop
shared='400|401|403|408|414|421|429|431|500|503|507'
not_seen() {
    local method path rest status missing=0
    while read -r method path rest; do
        for status in $(contract statuses "$method" "$path"); do
            grep -qE "^($shared)$" <<<"$status" && continue
            case "$path $status" in "/ 404" | "/openapi.yaml 404") continue ;; esac
            grep -qxF "$method $path $status" "$tmp/seen" || { echo "$method $path $status was not seen"; missing=1; }
        done
    done <"$tmp/documented"
    return $missing
}
try_missing_file() { serve_start "$tmp/idle" --workers 0 && answers 404 GET '/{file}' /nothing.js; }
check "a file that is not there is not found" try_missing_file
serve_stop
check "every documented status was seen" not_seen
tap_done
