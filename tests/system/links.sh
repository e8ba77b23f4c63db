#!/usr/bin/env bash
# Worker links over TCP behind a key: who has it renders the same bytes, who has not is refused, and
# somebody on the line sees nothing and changes nothing.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/links.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
umask 077
new_key() { head -c 32 /dev/urandom | od -An -v -tx1 | tr -d " \n"; echo; }
new_key >"$tmp/key"
new_key >"$tmp/other"
jq -n --arg scene "$scene" '{scene: {file: $scene}, image: {width: 128, height: 96}, sampling: {spp: 4, tile_px: 16}}' >"$tmp/job.json"
render() { # render OUT [EXTRA-SED]: the job on the running server
    id=$("$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet) && await_state "$id" finished 60 &&
        curl -sS --noproxy '*' -o "$1" "$url/v1/jobs/$id/frames/1/image.exr"
}
serve_start "$tmp/plain" --workers 1 --worker-threads 1
check "a picture in the clear, over a Unix socket" render "$tmp/plain.exr"
received() { curl -sS --noproxy '*' "$url/v1/jobs/$id" | jq .statistics.bytes_received; } # by the last job
quick=$(received)
serve_stop

serve_start "$tmp/keyed" --workers 0 --worker-listen 127.0.0.1:0 --worker-key "$tmp/key" || { echo "Bail out! no server"; exit 1; }
port=$(worker_port "$tmp/keyed")
worker() { # worker NAME PORT ARGS...: in the background; its pid is in $worker
    "$build/shearwater-worker" --connect "127.0.0.1:$2" --threads 1 --cache "$tmp/cache-$1" --name "$1" "${@:3}" >"$tmp/$1.log" 2>&1 &
    worker=$!
    track $worker
}
told() { grep -q "$2" "$tmp/$1.log" || { cat "$tmp/$1.log"; return 1; }; }
says() { eventually 5 told "$@"; }
worker wrong "$port" --key "$tmp/other"; wrong=$worker
worker keyless "$port"; keyless=$worker
check "a worker with another key is told so" says wrong 'does not have this key'
check "a worker without one does not get in" says keyless 'closed the link'
check "neither is in the roster" eventually 5 workers_are ''
kill $wrong $keyless
node tests/fake/tap.mjs "$port" "$tmp/seen" >"$tmp/tap.port" & track $!
eventually 5 [ -s "$tmp/tap.port" ]
worker right "$(cat "$tmp/tap.port")" --key "$tmp/key"; right=$worker
check "a worker with the key gets in" eventually 5 workers_are right
check "it renders" render "$tmp/keyed.exr"
check "... the same bytes" cmp "$tmp/plain.exr" "$tmp/keyed.exr"
check "... as quickly packed as there: nothing leaves the machine" [ "$(received)" -eq "$quick" ]
build_id=$("$build/shearwater" --version | cut -d' ' -f2)
sees_nothing() { [ "$(stat -c %s "$tmp/seen")" -gt 100000 ] && ! grep -qaF -e "$build_id" -e right "$tmp/seen"; }
check "somebody on the line sees neither its name nor its build" sees_nothing
kill $right
check "it leaves" eventually 5 workers_are ''
worker small "$port" --key "$tmp/key" --pack small; small=$worker
check "one that packs as over a network gets in" eventually 5 workers_are small
check "... it renders" render "$tmp/small.exr"
check "... the same bytes" cmp "$tmp/plain.exr" "$tmp/small.exr"
check "... of fewer" [ "$(received)" -lt $((quick * 85 / 100)) ]
kill $small
check "... and leaves" eventually 5 workers_are ''
worker unpacked "$port" --pack tight
check "there is no other way to pack" says unpacked '"tight" is neither quick nor small'
misdirected() { "$build/shearwater-worker" --connect "$1" >"$tmp/misdirected.log" 2>&1; [ $? -eq 2 ] && grep -q -e 'unix:PATH or HOST:PORT' -e 'a socket path has' "$tmp/misdirected.log"; }
for address in nowhere unix: 127.0.0.1:0 '[::1]:99999' '[]:80' "$(printf '%0300d' 0):80" "unix:$(printf '%0200d' 0)"; do
    check "what is no address is wrong use: ${address:0:30}" misdirected "$address"
done

# Changed on the way: the link breaks, is dialled again, and the picture is what it is.
for at in 40 300 20000; do
    node tests/fake/tap.mjs "$port" "$tmp/flipped" $at >"$tmp/flip.port" & flip=$!
    track $flip
    eventually 5 [ -s "$tmp/flip.port" ]
    worker "flipped$at" "$(cat "$tmp/flip.port")" --key "$tmp/key"
    check "with a bit flipped at byte $at the job ends well" render "$tmp/flipped.exr"
    check "... the link was lost over it" says "flipped$at" 'lost\|closed the link\|key\|again'
    check "... and the bytes are the same" cmp "$tmp/plain.exr" "$tmp/flipped.exr"
    kill $worker $flip
    : >"$tmp/flip.port"
    eventually 5 workers_are '' >/dev/null
done

# Who never ends the handshake, or speaks something else.
closed_within() { # closed_within SECONDS BYTES
    local start=$SECONDS
    exec 9<>"/dev/tcp/127.0.0.1/$port" || return 1
    printf '%b' "$2" >&9
    timeout 20 cat <&9 >/dev/null
    exec 9>&- 9<&-
    [ $((SECONDS - start)) -le $(($1 * slower)) ] || { echo "after $((SECONDS - start)) s"; return 1; }
}
check "noise is cut off at once" closed_within 2 'this is no handshake, but a sentence\n'
check "a handshake that stops half-way is cut off" closed_within 8 '\x16\x03\x01\x02'
check "so is one that never begins" closed_within 8 ''
many() { local i fds=() fd; for i in $(seq 200); do exec {fd}<>"/dev/tcp/127.0.0.1/$port" && fds+=("$fd"); done
         worker meanwhile "$port" --key "$tmp/key"; eventually 5 workers_are meanwhile; local status=$?
         for fd in "${fds[@]}"; do exec {fd}>&-; done; kill $worker; return $status; }
check "200 that say nothing keep nobody out" many
serve_stop

# The other way round, files, and addresses.
serve_start "$tmp/clear" --workers 0 --worker-listen 127.0.0.1:0
port=$(worker_port "$tmp/clear")
worker early "$port" --key "$tmp/key"
check "a worker with a key does not talk to a coordinator without" says early 'does not have this key'
check "... which does not list it" eventually 5 workers_are ''
serve_stop
refuses() { # refuses TEXT ARGS...
    local text=$1; shift
    timeout 20 "$build/shearwater" serve --listen 127.0.0.1:0 --workers 0 --data "$tmp/refused" "$@" >/dev/null 2>"$tmp/err" && return 1
    grep -qF -- "$text" "$tmp/err" || { cat "$tmp/err"; return 1; }
}
check "beyond loopback without a key is refused" refuses 'without --worker-key' --worker-listen 0.0.0.0:0
# An address of nobody's (RFC 5737): with a key it is tried, and nothing is opened by that.
check "beyond loopback with a key is tried" refuses 'cannot bind' --worker-listen 192.0.2.1:0 --worker-key "$tmp/key"
chmod 644 "$tmp/other"
check "a key that others may read is refused" refuses 'chmod 600' --worker-listen 127.0.0.1:0 --worker-key "$tmp/other"
worker_refuses() { ! "$build/shearwater-worker" --connect 127.0.0.1:1 --key "$1" 2>"$tmp/err" && grep -q "$2" "$tmp/err"; }
check "... by workers, too" worker_refuses "$tmp/other" 'chmod 600'
echo 'no key' >"$tmp/none"
check "what is no key is refused" worker_refuses "$tmp/none" '64 hexadecimal digits'
tap_done
