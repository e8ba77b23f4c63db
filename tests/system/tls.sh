#!/usr/bin/env bash
# HTTP over TLS: the same answers behind a certificate, nothing without it, and handshakes that never
# end are cut off while others are served.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/tls.sh BUILD_DIR}
. tests/tap.bash
command -v openssl >/dev/null || { skip "HTTP over TLS" "needs openssl to make a certificate"; tap_done; }
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
umask 077
certificate() { # certificate NAME
    openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -keyout "$tmp/$1.key" -out "$tmp/$1.pem" \
        -subj "/CN=$1" -addext 'subjectAltName=DNS:localhost,IP:127.0.0.1' 2>"$tmp/openssl.log"
}
certificate ours && certificate other || { cat "$tmp/openssl.log"; echo "Bail out! no certificate"; exit 1; }
token=$("$build/shearwater" token "$tmp/tokens.json" --name ana --role submitter)
admin=$("$build/shearwater" token "$tmp/tokens.json" --name ops --role admin)
export SHEARWATER_REQUEST_MS=5000
serve_start "$tmp/data" --workers 1 --worker-threads 1 --tokens "$tmp/tokens.json" --tls-cert "$tmp/ours.pem" --tls-key "$tmp/ours.key" ||
    { echo "Bail out! the server did not start"; exit 1; }
port=${url##*:}
check "the address says so" grep -qE '^https://127\.0\.0\.1:[0-9]+$' <<<"$url"
get() { curl -sS --noproxy '*' --max-time 20 --cacert "$tmp/ours.pem" -o "$tmp/body" -D "$tmp/head" -w '%{http_code}' "$@"; }
is() { local got; got=$(get "${@:2}"); [ "$got" = "$1" ] || { echo "status $got"; cat "$tmp/body"; return 1; }; }
fails() { ! get "$@" >/dev/null 2>"$tmp/err"; }
bearer=(-H "Authorization: Bearer $token")
check "it answers" is 200 "$url/livez"
check "by the name of its certificate, too" is 200 "https://localhost:$port/livez"
check "to others it is somebody else" fails --cacert "$tmp/other.pem" "$url/livez"
check "in the clear it says nothing" bash -c "! curl -sS --noproxy '*' --max-time 10 http://127.0.0.1:$port/livez 2>/dev/null | grep -q ok"
for version in 1.0 1.1; do check "TLS $version is refused" fails --tls-max $version --ciphers 'DEFAULT@SECLEVEL=0' "$url/livez"; done
check "TLS 1.2 is spoken" is 200 --tls-max 1.2 "$url/livez"
check "TLS 1.3 is spoken" is 200 --tlsv1.3 "$url/livez"
check "without a token it is 401" is 401 "$url/v1/jobs"
check "with one it is not" is 200 "${bearer[@]}" "$url/v1/jobs"
check "the cookie goes over TLS alone" bash -c "
    curl -sS --noproxy '*' --cacert '$tmp/ours.pem' -D - -o /dev/null -X POST -H 'Authorization: Bearer $token' '$url/v1/session' | grep -i '^set-cookie:' | grep -q '; Secure'"
cookie=$(curl -sS --noproxy '*' --cacert "$tmp/ours.pem" -D - -o /dev/null -X POST -H "Authorization: Bearer $admin" "$url/v1/session" | sed -n 's/^[Ss]et-[Cc]ookie: \([^;]*\).*/\1/p')
change=(-X PATCH -H "Cookie: $cookie" -H 'Content-Type: application/json' -d '{"drain": false}' "$url/v1/workers/999999")
check "our page is the one of https (and there is no such worker)" is 404 -H "Origin: $url" "${change[@]}"
check "... and not that of http" is 403 -H "Origin: http://127.0.0.1:$port" "${change[@]}"

# The commands, and what they bring.
jq -n --arg scene "$scene" '{scene: {file: $scene}, image: {width: 128, height: 96}, sampling: {spp: 4}}' >"$tmp/job.json"
as() { SHEARWATER_SERVER=$url SHEARWATER_TOKEN=$token "$build/shearwater" "$@"; }
check "a command that does not know the certificate refuses it" bash -c "! SHEARWATER_SERVER=$url SHEARWATER_TOKEN=$token '$build/shearwater' workers 2>'$tmp/err' && grep -qi certificate '$tmp/err'"
submit() { id=$(as submit "$tmp/job.json" --quiet --ca "$tmp/ours.pem"); }
check "a job goes in" submit
check "it is watched to its end, and its picture comes" as watch "$id" --quiet --ca "$tmp/ours.pem" -o "$tmp/secret.exr"
check "its events are told" bash -c "curl -sN --noproxy '*' --max-time 5 --cacert '$tmp/ours.pem' -H 'Authorization: Bearer $token' '$url/v1/jobs/$id/events' | grep -q '^event: '"
check "a part of a file comes" is 206 "${bearer[@]}" -H 'Range: bytes=0-3' "$url/v1/jobs/$id/frames/1/image.exr"
(unset SHEARWATER_TOKEN; "$build/shearwater" render "$tmp/job.json" -o "$tmp/clear.exr" --quiet) 2>/dev/null
check "the picture has the bytes of one in the clear" cmp "$tmp/secret.exr" "$tmp/clear.exr"

# Handshakes that never end.
is_closed() { # is_closed FD: within 12 s; no process, of which a busy machine starts few a second
    local status
    while IFS= read -r -d '' -t $((12 * slower)) -u "$1" _; status=$?; [ $status -eq 0 ]; do :; done
    [ $status -le 128 ] || { echo "one is still open"; return 1; }
}
half_open() {
    local i fd fds=() start=$SECONDS
    for i in $(seq 300); do exec {fd}<>"/dev/tcp/127.0.0.1/$port" && fds+=("$fd"); done
    for fd in "${fds[@]:0:150}"; do printf '\x16\x03\x01\x02\x00\x01' >&"$fd"; done
    for i in $(seq 5); do is 200 "$url/livez" || return 1; done
    [ $((SECONDS - start)) -lt 5 ] || echo "# slow machine: 5 answers took $((SECONDS - start)) s"
    for fd in "${fds[@]}"; do is_closed "$fd" || return 1; exec {fd}>&-; done
    [ $((SECONDS - start)) -le $((20 * slower)) ] || { echo "they took $((SECONDS - start)) s"; return 1; }
}
check "300 handshakes that never end keep nobody waiting, and are cut off" half_open
check "noise is no request" bash -c "exec 9<>/dev/tcp/127.0.0.1/$port; printf 'GET / HTTP/1.1\r\n\r\n' >&9; ! timeout 12 cat <&9 | tr -d '\0' | grep -q 200"
slow_head() {
    (printf 'GET /livez HTTP/1.1\r\nHost: localhost\r\n'; for _ in $(seq 40); do printf 'a'; sleep 0.25; done) |
        timeout 20 openssl s_client -quiet -connect "127.0.0.1:$port" >"$tmp/slow" 2>/dev/null
    [ $? -ne 124 ] && ! grep -q 'HTTP/1.1 200' "$tmp/slow"
}
check "a head that trickles in over TLS is cut off" slow_head
check "after all that it answers" is 200 "$url/livez"
serve_stop

# Files, and addresses.
refuses() { # refuses TEXT ARGS...
    local text=$1; shift
    timeout 20 "$build/shearwater" serve --listen 127.0.0.1:0 --workers 0 --data "$tmp/refused" "$@" >/dev/null 2>"$tmp/err" && return 1
    grep -qF -- "$text" "$tmp/err" || { cat "$tmp/err"; return 1; }
}
check "a key of another certificate is refused" refuses 'cannot be used' --tls-cert "$tmp/ours.pem" --tls-key "$tmp/other.key"
check "a certificate alone is refused" refuses 'go together' --tls-cert "$tmp/ours.pem"
chmod 640 "$tmp/other.key"; chmod o+r "$tmp/other.key"
check "a key that others may read is refused" refuses 'chmod 600' --tls-cert "$tmp/other.pem" --tls-key "$tmp/other.key"
check "beyond loopback with TLS alone is refused" refuses '--tokens is missing' --listen 0.0.0.0:0 --tls-cert "$tmp/ours.pem" --tls-key "$tmp/ours.key"
# An address of nobody's (RFC 5737): with both guards it is tried, and nothing is opened by that.
check "beyond loopback with both it is tried" refuses 'cannot listen on 192.0.2.1' --listen 192.0.2.1:0 \
    --tokens "$tmp/tokens.json" --tls-cert "$tmp/ours.pem" --tls-key "$tmp/ours.key"
tap_done
