#!/usr/bin/env bash
# Hostile HTTP against the real server: what must be refused is refused with the right status and a
# problem document, and nothing else is disturbed.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/http.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb

export SHEARWATER_REQUEST_MS=3000 SHEARWATER_UPLOAD_MS=6000
serve_start "$tmp/data" --workers 1 || { echo "Bail out! the server did not start"; exit 1; }
port=${url##*:}
none=00000000000000000000000000

# Sends bytes as they are; prints what comes back until the server closes or $1 seconds have passed.
raw() {
    local seconds=$1 text=$2
    exec 9<>"/dev/tcp/127.0.0.1/$port" || return 1
    printf '%b' "$text" >&9
    timeout "$seconds" cat <&9
    exec 9>&- 9<&-
}
status_of() { sed -n '1s/^HTTP\/1\.1 \([0-9]*\).*/\1/p' | tr -d '\r'; }

# raw_is STATUS BYTES: the first answer has this status.
raw_is() {
    local got; got=$(raw 8 "$2" | tr -d '\0' | status_of)
    [ "$got" = "$1" ] || { echo "status ${got:-none}, not $1"; return 1; }
}
# is STATUS CURL-ARGUMENTS: status, and a well-formed problem document for errors.
is() {
    local want=$1; shift
    local got; got=$(http -o "$tmp/body" -D "$tmp/head" -w '%{http_code}' "$@")
    [ "$got" = "$want" ] || { echo "status $got, not $want"; cat "$tmp/body"; return 1; }
    [ "$want" -lt 400 ] || is_problem "$want" "$tmp/body" "$tmp/head"
}
is_problem() {
    grep -qi '^content-type: application/problem+json' "$3" &&
        jq -e --argjson status "$1" '(.type | startswith("urn:shearwater:problem:")) and
            (.title | length > 0) and .status == $status' "$2" >"$tmp/problem"
}
header() { sed -n "s/^$1: //Ip" "$tmp/head" | tr -d '\r'; }
pointer_is() { jq -e --arg p "$1" '.pointer == $p' "$tmp/body"; }
json=(-H 'Content-Type: application/json')
H='Host: localhost\r\n'

# Framing: requests that two readers could take apart in two ways.
smuggled='GET /metrics HTTP/1.1\r\n'$H'\r\n'
check "Content-Length with Transfer-Encoding is refused" raw_is 400 \
    "POST /v1/jobs HTTP/1.1\r\n${H}Content-Type: application/json\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n$smuggled"
check "two Content-Lengths are refused" raw_is 400 \
    "POST /v1/jobs HTTP/1.1\r\n${H}Content-Type: application/json\r\nContent-Length: 5\r\nContent-Length: 50\r\n\r\n{}   $smuggled"
check "two equal Content-Lengths are refused" raw_is 400 \
    "POST /v1/jobs HTTP/1.1\r\n${H}Content-Length: 2\r\nContent-Length: 2\r\n\r\n{}"
check "an unknown transfer coding is refused" raw_is 400 \
    "POST /v1/jobs HTTP/1.1\r\n${H}Transfer-Encoding: gzip, chunked\r\n\r\n0\r\n\r\n"
check "a transfer coding in HTTP/1.0 is refused" raw_is 400 \
    "POST /v1/jobs HTTP/1.0\r\n${H}Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"
check "a Content-Length that is no number is refused" raw_is 400 \
    "POST /v1/jobs HTTP/1.1\r\n${H}Content-Length: 0x10\r\n\r\n"
one_answer() {
    local answers
    answers=$(raw 8 "$1" | tr -d '\0' | grep -o 'HTTP/1\.1 [0-9]' | wc -l)
    [ "$answers" = 1 ] || { echo "$answers answers"; return 1; }
}
check "a refused body is not read as the next request" one_answer \
    "GET /livez HTTP/1.1\r\n${H}Content-Length: 64\r\n\r\n$smuggled"
check "the same for PATCH" one_answer \
    "PATCH /v1/nothing HTTP/1.1\r\n${H}Content-Length: 64\r\n\r\n$smuggled"
check "the same for an unknown method" one_answer \
    "BREW /livez HTTP/1.1\r\n${H}Content-Length: 64\r\n\r\n$smuggled"
check "a body on GET is refused" is 400 -X GET -d '{}' "$url/v1/jobs"
check "two pipelined requests get two answers" bash -c "
    exec 9<>/dev/tcp/127.0.0.1/$port
    printf 'GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\nGET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' >&9
    [ \$(timeout 5 cat <&9 | grep -o 'HTTP/1.1 200' | wc -l) = 2 ]"

# Host and origin.
check "another Host is refused" is 421 -H 'Host: evil.example' "$url/livez"
check "a Host that begins like ours is refused" is 421 -H 'Host: localhost.evil.example' "$url/livez"
check "no Host is refused" raw_is 400 'GET /livez HTTP/1.1\r\n\r\n'
check "two Hosts are refused" raw_is 400 "GET /livez HTTP/1.1\r\n${H}Host: evil.example\r\n\r\n"
check "localhost with any port is served" is 200 -H 'Host: LOCALHOST:9999' "$url/livez"
check "a page of another origin cannot submit" is 403 -H 'Origin: http://evil.example' "${json[@]}" -d '{}' "$url/v1/jobs"
check "a page without an origin cannot submit" is 403 -H 'Origin: null' "${json[@]}" -d '{}' "$url/v1/jobs"
check "a page of another port cannot cancel" is 403 -H 'Origin: http://localhost:1' -X DELETE "$url/v1/jobs/$none"
check "the viewer's own page may" is 404 -H "Origin: $url" -X DELETE "$url/v1/jobs/$none"

# Targets.
check "an unknown path is not found" is 404 "$url/v1/nothing"
check "a wrong method is told the right ones" is 405 -X PUT "$url/v1/jobs"
check "... in Allow" test "$(header Allow)" = "POST, GET, HEAD"
check "traversal is refused" is 400 --path-as-is "$url/../../etc/passwd"
check "encoded traversal is refused" is 400 --path-as-is "$url/%2e%2e/%2e%2e/etc/passwd"
check "an encoded slash is refused" is 400 "$url/..%2f..%2fetc%2fpasswd"
check "an encoded NUL is refused" is 400 "$url/index.html%00.png"
check "a backslash is refused" is 400 "$url/..%5cindex.html"
check "an absolute target is refused" raw_is 400 "GET http://localhost/livez HTTP/1.1\r\n${H}\r\n"
check "a file outside the list is not found" is 404 "$url/Makefile"
long=$(head -c 5000 /dev/zero | tr '\0' a)
check "a long target is refused" is 414 "$url/$long"
check "a longer target than memory is refused" raw_is 414 "GET /$(head -c 40000 /dev/zero | tr '\0' a) HTTP/1.1\r\n${H}\r\n"
check "an unknown query parameter is refused" is 400 "$url/v1/jobs?limt=3"
check "a repeated query parameter is refused" is 400 "$url/v1/jobs?limit=3&limit=4"
for limit in 0 101 -1 1x 99999999999; do
    check "limit=$limit is refused" is 400 "$url/v1/jobs?limit=$limit"
done
check "no text to look for is refused" is 400 "$url/v1/jobs?text="
check "a long text to look for is refused" is 400 "$url/v1/jobs?text=${long:1:129}"
check "a state that is none is refused" is 400 "$url/v1/jobs?state=done"
check "a cursor that is none is refused" is 400 "$url/v1/jobs?cursor=%27%3B--"
for id in x 0123456789ABCDEFGHJKMNPQRS "$none$none" %27; do
    check "the job id $id is not found" is 404 "$url/v1/jobs/$id"
done
check "a job that is not there is not found" is 404 "$url/v1/jobs/$none"
check "... its events neither" is 404 "$url/v1/jobs/$none/events"
check "... its pixels neither" is 404 "$url/v1/jobs/$none/pixels"
check "... its pictures neither" is 404 "$url/v1/jobs/$none/frames/1/image.exr"
check "a layer that is none is refused" is 400 "$url/v1/jobs/$none/frames/1/image.png?layer=x"
for exposure in nan inf 0x1 99 1,5 ""; do
    check "exposure=$exposure is refused" is 400 "$url/v1/jobs/$none/frames/1/image.png?exposure=$exposure"
done

# Header fields.
big=$(head -c 20000 /dev/zero | tr '\0' b)
check "large header fields are refused" raw_is 431 "GET /livez HTTP/1.1\r\n${H}X-Big: $big\r\n\r\n"
check "header fields above memory are refused" raw_is 431 "GET /livez HTTP/1.1\r\n${H}X-Big: $big$big\r\n\r\n"
check "many header fields are refused" raw_is 431 "GET /livez HTTP/1.1\r\n${H}$(printf 'A: b\\r\\n%.0s' $(seq 200))\r\n"
no_success() { ! raw 8 "$1" | tr -d '\0' | grep 'HTTP/1\.[01] [23]'; } # no -q: it would end before who writes
check "nonsense is not served" no_success 'nonsense\r\n\r\n'
check "bytes that are no text are not served" no_success '\x16\x03\x01\x02\x00\x01\xfc\xff\r\n\r\n'

# Bodies.
check "another media type is refused" is 415 -H 'Content-Type: text/plain' -d '{}' "$url/v1/jobs"
check "no media type is refused" is 415 -H 'Content-Type:' -d '{}' "$url/v1/jobs"
check "malformed JSON is refused" is 400 "${json[@]}" -d '{"scene":' "$url/v1/jobs"
check "an empty body is refused" is 400 "${json[@]}" -X POST "$url/v1/jobs"
check "a repeated member is refused" is 400 "${json[@]}" -d '{"scene": {}, "scene": {}}' "$url/v1/jobs"
check "bytes that are no UTF-8 are refused" is 400 "${json[@]}" --data-binary $'{"scene": "\xff"}' "$url/v1/jobs"
deep=$(printf '[%.0s' $(seq 5000))$(printf ']%.0s' $(seq 5000))
check "deep nesting is refused" is 400 "${json[@]}" -d "$deep" "$url/v1/jobs"
head -c 1048577 /dev/zero | tr '\0' ' ' >"$tmp/large"
check "a large document is refused before it is read" raw_is 413 \
    "POST /v1/jobs HTTP/1.1\r\n${H}Content-Type: application/json\r\nContent-Length: 1048577\r\n\r\n"
check "a large chunked document is refused" bash -c "
    code=\$(curl -sS --noproxy '*' -o /dev/null -w '%{http_code}' -H 'Content-Type: application/json' \
        -H 'Transfer-Encoding: chunked' -H 'Expect:' --data-binary @'$tmp/large' '$url/v1/jobs'); [ \$code = 413 ]"
asset=$(sha256sum <"$scene" | cut -c1-64)
check "an unknown member is refused" is 422 "${json[@]}" -d "{\"scene\": {\"asset\": \"$asset\"}, \"fast\": true}" "$url/v1/jobs"
check "... and named" pointer_is /fast
check "a wrong type is refused" is 422 "${json[@]}" -d "{\"scene\": {\"asset\": \"$asset\"}, \"image\": {\"width\": \"9\"}}" "$url/v1/jobs"
check "... and named" pointer_is /image/width
check "a number out of range is refused" is 422 "${json[@]}" -d "{\"scene\": {\"asset\": \"$asset\"}, \"image\": {\"height\": 0}}" "$url/v1/jobs"
check "... and named" pointer_is /image/height
check "a missing scene is refused" is 422 "${json[@]}" -d '{}' "$url/v1/jobs"
check "an array is refused" is 422 "${json[@]}" -d '[]' "$url/v1/jobs"
check "a missing asset is refused" is 422 "${json[@]}" -d "{\"scene\": {\"asset\": \"$(printf '%064d' 0)\"}}" "$url/v1/jobs"
check "... and named" pointer_is /scene/asset

# Assets.
check "a digest of the wrong form is refused" is 400 -T "$scene" "$url/v1/assets/abc"
check "upper case too" is 400 -T "$scene" "$url/v1/assets/${asset^^}"
check "an unknown asset is not known" bash -c "curl -sSI --noproxy '*' '$url/v1/assets/$asset' | grep -q '^HTTP/1.1 404'"
check "a body with another digest is refused" is 422 -T "$scene" "$url/v1/assets/$(printf '%064d' 1)"
check "... and not kept" bash -c "curl -sSI --noproxy '*' '$url/v1/assets/$(printf '%064d' 1)' | grep -q '^HTTP/1.1 404'"
check "an asset above the cap is refused before it is read" raw_is 413 \
    "PUT /v1/assets/$asset HTTP/1.1\r\n${H}Content-Length: 2147483649\r\n\r\n"
check "an upload is stored" is 201 -T "$scene" "$url/v1/assets/$asset"
check "again, it is known" is 200 -T "$scene" "$url/v1/assets/$asset"
check "chunked, too" is 200 -H 'Transfer-Encoding: chunked' -T "$scene" "$url/v1/assets/$asset"
check "HEAD tells its size" bash -c "curl -sSI --noproxy '*' '$url/v1/assets/$asset' | tr -d '\r' | grep -qix 'content-length: $(stat -c %s "$scene")'"
check "an empty file is an asset, too" is 201 -X PUT --data-binary @/dev/null "$url/v1/assets/$(sha256sum </dev/null | cut -c1-64)"

# Time.
slow_body() {
    local start=$SECONDS got
    exec 9<>"/dev/tcp/127.0.0.1/$port"
    printf 'POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 1000\r\n\r\n' >&9
    (for _ in $(tries 40); do printf ' ' >&9; sleep 0.25; done) 2>/dev/null &
    local writer=$!
    got=$(timeout 9 cat <&9 | status_of)
    kill $writer 2>/dev/null
    wait $writer 2>/dev/null
    exec 9>&- 9<&-
    [ "$got" = 408 ] && [ $((SECONDS - start)) -le $((6 * slower)) ] || { echo "status $got after $((SECONDS - start)) s"; return 1; }
}
check "a body that trickles in is cut off" slow_body
slow_head() {
    local start=$SECONDS
    exec 9<>"/dev/tcp/127.0.0.1/$port"
    (for c in G E T ' ' / l i v e z ' ' H T T P / 1 . 1 a b c d e f g h i j k l m n; do printf '%s' "$c" >&9; sleep 0.25; done) 2>/dev/null &
    local writer=$!
    timeout 9 cat <&9 >"$tmp/slow"
    kill $writer 2>/dev/null
    wait $writer 2>/dev/null
    exec 9>&- 9<&-
    [ $((SECONDS - start)) -le $((6 * slower)) ] || { echo "open for $((SECONDS - start)) s"; return 1; }
}
check "a head that trickles in is cut off" slow_head
aborted() {
    local i
    for i in $(seq 20); do
        exec 9<>"/dev/tcp/127.0.0.1/$port"
        printf 'PUT /v1/assets/%s HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\nabc' "$asset" >&9
        exec 9>&- 9<&-
    done
    eventually 6 nothing_left # at the latest when they have been idle for SHEARWATER_REQUEST_MS
}
nothing_left() { [ -z "$(ls "$tmp/data/tmp")" ] || { ls -R "$tmp/data/tmp"; return 1; }; }
check "broken uploads leave nothing behind" aborted

# A real job, its answers and conditions.
document="{\"scene\": {\"asset\": \"$asset\"}, \"image\": {\"width\": 96, \"height\": 80}, \"sampling\": {\"spp\": 1}, \"layers\": [\"beauty\", \"normal\"]}"
check "a job is accepted" is 202 "${json[@]}" -H 'Idempotency-Key: one' -d "$document" "$url/v1/jobs"
id=$(jq -r .id "$tmp/body")
check "... at its Location" test "$(header Location)" = "/v1/jobs/$id"
check "the same key and body give the same job" is 202 "${json[@]}" -H 'Idempotency-Key: one' -d "$document" "$url/v1/jobs"
check "... the very same" jq -e --arg id "$id" '.id == $id and .existed' "$tmp/body"
check "the same key with another body is refused" is 409 "${json[@]}" -H 'Idempotency-Key: one' -d "$document " "$url/v1/jobs"
check "a key with blanks is refused" is 400 "${json[@]}" -H 'Idempotency-Key: a b' -d "$document" "$url/v1/jobs"
check "a long key is refused" is 400 "${json[@]}" -H "Idempotency-Key: ${long:0:129}" -d "$document" "$url/v1/jobs"
check "a dry run gives a plan" is 200 "${json[@]}" -d "$document" "$url/v1/jobs?dry_run=1"
check "... and no job" bash -c "curl -sS --noproxy '*' '$url/v1/jobs' | jq -e '.jobs | length == 1'"
check "dry_run=maybe is refused" is 400 "${json[@]}" -d "$document" "$url/v1/jobs?dry_run=maybe"
check "the job finishes" await_state "$id" finished 60
check "it is told with a tag" is 200 "$url/v1/jobs/$id"
tag=$(header ETag)
check "which it is known by" is 304 -H "If-None-Match: W/$tag" "$url/v1/jobs/$id"
check "another tag gets it again" is 200 -H 'If-None-Match: "x"' "$url/v1/jobs/$id"
check "HEAD has no body" bash -c "[ -z \"\$(curl -sS --noproxy '*' -X HEAD --max-time 3 -o - '$url/v1/jobs/$id' 2>/dev/null)\" ]"
check "cancelling what has ended is refused" is 409 -X DELETE "$url/v1/jobs/$id"

image=$url/v1/jobs/$id/frames/1/image
check "the EXR comes whole" is 200 "$image.exr"
mv "$tmp/body" "$tmp/whole.exr"
tag=$(header ETag)
size=$(stat -c %s "$tmp/whole.exr")
check "its tag is its SHA-256" test "$tag" = "\"$(sha256sum <"$tmp/whole.exr" | cut -c1-64)\""
check "a part of it is a part" is 206 -H 'Range: bytes=10-19' "$image.exr"
check "... named" test "$(header Content-Range)" = "bytes 10-19/$size"
check "... its bytes" cmp "$tmp/body" <(tail -c +11 "$tmp/whole.exr" | head -c 10)
check "the last bytes of it" is 206 -H 'Range: bytes=-7' "$image.exr"
check "... its bytes" cmp "$tmp/body" <(tail -c 7 "$tmp/whole.exr")
check "a part beyond it is refused" is 416 -H "Range: bytes=$size-" "$image.exr"
check "... and told its size" test "$(header Content-Range)" = "bytes */$size"
check "a part of another version is the whole" is 200 -H 'Range: bytes=10-19' -H 'If-Range: "x"' "$image.exr"
check "a part of this version is a part" is 206 -H 'Range: bytes=10-19' -H "If-Range: $tag" "$image.exr"
check "a known picture is not sent" is 304 -H "If-None-Match: $tag" "$image.exr"
check "the PNG is one" bash -c "curl -sS --noproxy '*' '$image.png' | head -c 8 | cmp - <(printf '\x89PNG\r\n\x1a\n')"
check "a part of it is a part" is 206 -H 'Range: bytes=1-3' "$image.png"
check "... its bytes" cmp "$tmp/body" <(printf PNG)
check "with another exposure, too" is 200 "$image.png?exposure=-2.5"
check "... which is drawn, and comes whole" is 200 -H 'Range: bytes=1-3' "$image.png?exposure=-2.5"
check "and another layer" is 200 "$image.png?layer=normal"
tag=$(header ETag)
check "which is known by its tag" is 304 -H "If-None-Match: $tag" "$image.png?layer=normal"
check "a layer that the job lacks is not found" is 404 "$image.png?layer=depth"
check "a frame that the job lacks is not found" is 404 "$url/v1/jobs/$id/frames/2/image.exr"
check "the events of an ended job are one snapshot" bash -c "
    curl -sS --noproxy '*' --max-time 5 '$url/v1/jobs/$id/events' | grep -c '^event: ' | grep -qx 1"
check "its pixels come once and end" bash -c "
    [ \$(curl -sS --noproxy '*' --max-time 5 '$url/v1/jobs/$id/pixels' | wc -c) = $((32 + 4 * 32 + 96 * 80 * 6)) ]"

# The page.
check "the page is served" is 200 "$url/"
check "with a strict policy" bash -c "grep -i '^content-security-policy:' '$tmp/head' | grep -q \"default-src 'none'.*frame-ancestors 'none'\""
check "and is not sniffed" test "$(header X-Content-Type-Options)" = nosniff
check "it is known by its tag" is 304 -H "If-None-Match: $(header ETag)" "$url/"
check "the metrics are lines of Prometheus" bash -c "
    curl -sS --noproxy '*' '$url/metrics' >'$tmp/metrics' &&
    ! grep -vE '^(# (HELP|TYPE) [a-z_]+ .+|[a-z_]+(\{[a-z_]+=\"[^\"]*\"(,[a-z_]+=\"[^\"]*\")*\})? -?[0-9.e+-]+)\$' '$tmp/metrics' &&
    grep -q 'shearwater_http_requests_total{method=\"POST\",route=\"/v1/jobs\",status=\"422\"}' '$tmp/metrics'"

# The end.
check "purging removes it" is 204 -X DELETE "$url/v1/jobs/$id?purge=1"
check "... for good" is 404 "$url/v1/jobs/$id"
check "the server is still alive" is 200 "$url/livez"
stops() {
    local status
    kill -TERM "$server_pid"
    ended "$server_pid" 15 || { echo "still there after 15 s"; return 1; }
    wait "$server_pid"
    status=$?
    [ $status = 0 ] || { echo "status $status"; tail -n 40 "$tmp/data/stderr"; return 1; }
}
# A reader of events must not keep it from stopping.
check "another job, for its events" is 202 "${json[@]}" -d "{\"scene\": {\"asset\": \"$asset\"}, \"image\": {\"width\": 2048, \"height\": 2048}, \"sampling\": {\"spp\": 256}}" "$url/v1/jobs"
curl -sS --noproxy '*' --max-time 30 "$url/v1/jobs/$(jq -r .id "$tmp/body")/events" >"$tmp/events" 2>/dev/null &
track $!
check "the events are begun" eventually 10 grep -q '^event: snapshot' "$tmp/events"
check "it stops in order when told to" stops

# Idle clients leave descriptors for the work: with few of them a job still ends well.
few_descriptors() {
    local n id fds=() status=0
    mkdir "$tmp/few"
    printf '#!/bin/sh\nulimit -n 100\nexec "%s/shearwater" "$@"\n' "$(realpath "$build")" >"$tmp/few/shearwater"
    chmod +x "$tmp/few/shearwater"
    build=$tmp/few serve_start "$tmp/few/data" --workers 1 || return 1
    jq -n --arg scene "$scene" '{scene: {file: $scene}, sampling: {spp: 16}}' >"$tmp/few/job.json"
    id=$("$build/shearwater" submit "$tmp/few/job.json" --server "$url" --quiet) || return 1
    for n in $(seq 150); do exec {fd}<>"/dev/tcp/127.0.0.1/${url##*:}" && fds+=("$fd"); done
    sleep 2
    for fd in "${fds[@]}"; do exec {fd}>&-; done
    await_state "$id" finished 40 || status=1
    serve_stop || status=1
    return $status
}
check "idle connections take no descriptor that a job needs" few_descriptors

refused_bind() {
    local out
    out=$("$build/shearwater" serve --listen "$1" --data "$tmp/other" --workers 0 2>&1) && return 1
    grep -qi "$2" <<<"$out" || { echo "$out"; return 1; }
}
check "an address for others is refused" refused_bind 0.0.0.0:0 'tokens and TLS'
check "... in IPv6 too" refused_bind '[::]:0' 'tokens and TLS'
check "an address that is none is refused" refused_bind nonsense 'ADDRESS:PORT'
tap_done
