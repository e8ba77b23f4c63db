#!/usr/bin/env bash
# Who may do what: every operation of the contract with every kind of credential; tokens from a file,
# read again on SIGHUP; what the command line and streams have of it.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/access.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
if ! command -v node >/dev/null || [ ! -d tests/browser/node_modules/yaml ]; then
    skip "the contract says who may do what" "needs node and its package yaml: make deps-browser"
    tap_done
fi
scene=$PWD/tests/scenes/cornell-box
tokens=$tmp/tokens.json
shearwater() { "$build/shearwater" "$@"; }

# The file.
declare -A token
make_token() { token[$1]=$(shearwater token "$tokens" --name "$1" --tenant "$2" --role "$3"); }
make_all() {
    make_token a_viewer a viewer && make_token a_submitter a submitter &&
        make_token b_viewer b viewer && make_token b_submitter b submitter && make_token admin ops admin
}
check "the command makes tokens" make_all
check "... of 64 random digits" grep -qxE 'sw_[0-9a-f]{64}' <<<"${token[admin]}"
check "... in a file for its owner alone" test "$(stat -c %a "$tokens")" = 600
no_token_in() { local t; for t in "${token[@]}"; do ! grep -qF "${t#sw_}" "$@" || return 1; done; }
check "... that holds none of them" no_token_in "$tokens"
check "... but their hashes" test "$(jq -r '.tokens[] | select(.name == "admin") | .sha256' "$tokens")" = \
    "$(printf %s "${token[admin]}" | sha256sum | cut -c1-64)"
again() { ! shearwater token "$tokens" --name admin --role admin 2>"$tmp/err" && grep -q 'admin is there already' "$tmp/err"; }
check "a name is taken once" again
odd() { ! shearwater token "$tokens" "$@" 2>/dev/null; }
check "a role that is none is refused" odd --name x --role root
check "a tenant that leads elsewhere is refused" odd --name x --tenant ../b
check "what was refused left the file alone" jq -e '.tokens | length == 5' "$tokens"

# refuses TEXT ARGS...: the server does not start, and says so.
refuses() {
    local text=$1; shift
    timeout 20 "$build/shearwater" serve --listen 127.0.0.1:0 --workers 0 --data "$tmp/refused" "$@" >/dev/null 2>"$tmp/err" && return 1
    grep -qF -- "$text" "$tmp/err" || { cat "$tmp/err"; return 1; }
}
with() { printf '%s' "$1" >"$tmp/other.json"; chmod "${2:-600}" "$tmp/other.json"; }
with "$(cat "$tokens")" 604
check "a file that others may read is refused" refuses 'chmod 600' --tokens "$tmp/other.json"
with "$(cat "$tokens")" 620
check "a file that its group may change is refused" refuses 'chmod 600' --tokens "$tmp/other.json"
check "a file that is not there is refused" refuses 'No such file' --tokens "$tmp/nothing.json"
mkfifo -m 600 "$tmp/pipe"
check "a pipe is refused and not waited for" refuses 'no regular file' --tokens "$tmp/pipe"
one='"name": "x", "tenant": "t", "role": "viewer"'
hash='"sha256": "5891b5b522d5df086d0ff0b110fbd9d21bb4fc7163af34d08286a2e846f6be03"'
while IFS='|' read -r text document; do
    with "$document"
    check "refused: $document" refuses "$text" --tokens "$tmp/other.json"
done <<END
tokens|[]
tokens|{"tokens": [], "more": 1}
/tokens/0/sha256|{"tokens": [{$one}]}
/tokens/0/sha256|{"tokens": [{$one, "sha256": "short"}]}
/tokens/0/role|{"tokens": [{"name": "x", "tenant": "t", "role": "worker", $hash}]}
/tokens/0/tenant|{"tokens": [{"name": "x", "tenant": "../../t", "role": "viewer", $hash}]}
/tokens/0/tenant|{"tokens": [{"name": "x", "tenant": "", "role": "viewer", $hash}]}
/tokens/0/name|{"tokens": [{"name": 7, "tenant": "t", "role": "viewer", $hash}]}
/tokens/0/token|{"tokens": [{$one, $hash, "token": "sw_secret"}]}
/tokens/1/name|{"tokens": [{$one, $hash}, {$one, $hash}]}
/tokens/1/sha256|{"tokens": [{$one, $hash}, {"name": "y", "tenant": "t", "role": "viewer", $hash}]}
other.json|{"tokens": [
END

# The contract.
serve_start "$tmp/data" --workers 2 --worker-threads 1 --tokens "$tokens" || { echo "Bail out! the server did not start"; exit 1; }
for name in "${!token[@]}"; do printf '%s %s\n' "$name" "${token[$name]}"; done | sort |
    jq -Rn '[inputs | split(" ") | {(.[0]): .[1]}] | add' >"$tmp/plain.json"
(trap - EXIT; node tests/system/access.mjs "$url" "$tmp/plain.json") >"$tmp/access.tap" 2>&1
grep -E '^(#|.*Error)' "$tmp/access.tap" | sed 's/^#* */# /'
relay() { grep -E '^(not )?ok ' "$tmp/access.tap" | sed -E 's/^((not )?ok) [0-9]+ - /\1|/'; }
while IFS='|' read -r verdict text; do
    passed() { [ "$verdict" = ok ]; }
    check "$text" passed
done < <(relay)
check "all of them were tried" grep -qE '^1\.\.[0-9]+$' "$tmp/access.tap"

# The command line.
as() { local who=$1; shift; SHEARWATER_SERVER=$url SHEARWATER_TOKEN=${token[$who]} "$build/shearwater" "$@"; }
submitted() { id=$(as a_submitter submit "$scene/job.json" --quiet 2>"$tmp/err") && [ ${#id} = 26 ]; }
check "the command line sends a token" submitted
check "... without it, it is told so" bash -c "! SHEARWATER_SERVER=$url '$build/shearwater' workers 2>'$tmp/err' && grep -q 'send a token' '$tmp/err'"
not_found() { ! as b_submitter cancel "$1" 2>"$tmp/err" && grep -q 'no such job' "$tmp/err"; }
check "another tenant cannot cancel the job" not_found "$id"
(umask 077 && printf '%s\n' "${token[a_submitter]}" >"$tmp/token")
check "a token comes from a file" shearwater workers --server "$url" --token-file "$tmp/token"
chmod 644 "$tmp/token"
readable() { ! shearwater workers --server "$url" --token-file "$tmp/token" 2>"$tmp/err" && grep -q 'chmod 600' "$tmp/err"; }
check "... that others cannot read" readable
in_clear() { ! SHEARWATER_TOKEN=${token[admin]} shearwater workers --server "http://$1:1" 2>"$tmp/err" && grep -q 'in the clear' "$tmp/err"; }
check "no token goes over the network in the clear" in_clear 192.0.2.1
check "... nor to a name that begins like ours" in_clear 127.0.0.1.evil.example

# SIGHUP.
status() { curl -sS --noproxy '*' --max-time 10 -o "$tmp/body" -w '%{http_code}' -H "Authorization: Bearer ${token[$1]}" "$url$2"; }
counted() { [ "$(grep -c "$1" "$tmp/data/stderr")" -ge "$2" ]; }
said() { eventually 5 counted "$@"; }
# A job that stays: the stream of an ended one ends by itself.
long=$(curl -sS --noproxy '*' -H "Authorization: Bearer ${token[a_submitter]}" -H 'Content-Type: application/json' "$url/v1/jobs" -d \
    "{\"scene\": {\"asset\": \"$(sha256sum <"$scene/cornell-box.glb" | cut -c1-64)\"}, \"image\": {\"width\": 1536, \"height\": 1536}, \"sampling\": {\"spp\": 4096}, \"priority\": 50, \"filter\": {\"method\": \"none\"}}" | jq -r .id)
curl -sN --noproxy '*' -H "Authorization: Bearer ${token[a_viewer]}" "$url/v1/jobs/$long/events" >"$tmp/stream" &
withdrawn=$!
track $withdrawn
curl -sN --noproxy '*' -H "Authorization: Bearer ${token[a_submitter]}" "$url/v1/jobs/$long/events" >"$tmp/kept" &
kept=$!
track $kept
streams_on() { [ -s "$tmp/stream" ] && [ -s "$tmp/kept" ]; }
check "two streams go on" eventually 5 streams_on
# Streams that a browser's sign-in let in: they end with it, and no other does.
sign_in() { # sign_in TOKEN-NAME: prints the cookie
    curl -sS --noproxy '*' -o /dev/null -D - -X POST -H "Authorization: Bearer ${token[$1]}" "${@:2}" "$url/v1/session" |
        tr -d '\r' | sed -n 's/^Set-Cookie: \([^;]*\);.*/\1/Ip'
}
sign_out() { curl -sS --noproxy '*' -o /dev/null -w '%{http_code}' -X DELETE -H "Cookie: $1" -H "Origin: $url" "$url/v1/session"; }
follow() { # follow COOKIE FEED FILE: sets $follower
    curl -sN --noproxy '*' -H "Cookie: $1" "$url/v1/jobs/$long/$2" >"$3" &
    follower=$!
    track $follower
    eventually 5 [ -s "$3" ]
}
first=$(sign_in a_viewer) second=$(sign_in a_viewer) third=$(sign_in a_submitter)
follow "$first" events "$tmp/events1"; events1=$follower
follow "$first" pixels "$tmp/pixels1"; pixels1=$follower
follow "$second" events "$tmp/events2"; events2=$follower
follow "$third" pixels "$tmp/pixels3"; pixels3=$follower
by_cookie_on() { [ -s "$tmp/events1" ] && [ -s "$tmp/pixels1" ] && [ -s "$tmp/events2" ] && [ -s "$tmp/pixels3" ]; }
check "four streams of browsers go on" by_cookie_on
check "signing out is answered" test "$(sign_out "$first")" = 204
check "... and ends the events that the sign-in let in" ended $events1 2
check "... and the pixels" ended $pixels1 2
fourth=$(sign_in a_submitter -H "Cookie: $third")
check "signing in anew ends what the sign-in of before let in" ended $pixels3 2
for _ in $(seq 64); do last=$(sign_in a_submitter); done
check "many sign-ins of one token push out its own oldest" test "$(curl -sS --noproxy '*' -o /dev/null -w '%{http_code}' -H "Cookie: $fourth" "$url/v1/jobs")" = 401
check "... and nobody else" test "$(curl -sS --noproxy '*' -o /dev/null -w '%{http_code}' -H "Cookie: $second" "$url/v1/jobs")" = 200
check "... whose stream goes on" kill -0 $events2
cp -p "$tokens" "$tmp/before.json"
printf '{"tokens": 7}' >"$tokens"
kill -HUP $server_pid
check "a bad file is told of" said 'tokens kept as they were' 1
check "... and the tokens stay" test "$(status a_viewer /v1/jobs)" = 200
chmod 644 "$tmp/before.json"
cp -p "$tmp/before.json" "$tokens"
kill -HUP $server_pid
check "so is a file that has become readable" said 'tokens kept as they were' 2
check "... and the tokens stay again" test "$(status admin /v1/jobs)" = 200
jq '.tokens |= map(select(.name != "a_viewer"))' "$tmp/before.json" >"$tokens"
chmod 600 "$tokens"
kill -HUP $server_pid
check "a good file is read again" said 'tokens read again tokens=4' 1
check "a token that is gone is refused" test "$(status a_viewer /v1/jobs)" = 401
check "others go on" test "$(status a_submitter /v1/jobs)" = 200
check "a stream of the withdrawn token is cut" ended $withdrawn 2
check "... and that of a browser which had signed in with it" ended $events2 2
check "... and no other" kill -0 $kept
jq '(.tokens[] | select(.name == "a_submitter")).role = "viewer"' "$tokens" >"$tmp/less.json"
cat "$tmp/less.json" >"$tokens"
kill -HUP $server_pid
check "roles are read again" said 'tokens read again tokens=4' 2
check "... so that what was allowed is not" test "$(curl -sS --noproxy '*' -o /dev/null -w '%{http_code}' -X DELETE -H "Authorization: Bearer ${token[a_submitter]}" "$url/v1/jobs/$long")" = 403
make_token fresh a viewer
kill -HUP $server_pid
check "a token made meanwhile is taken up" said 'tokens read again tokens=5' 1
check "... and let in" test "$(status fresh "/v1/jobs/$long")" = 200
check "its tenant's jobs survive a kill" bash -c "kill -9 $server_pid"
wait $server_pid 2>/dev/null
serve_start "$tmp/data" --workers 0 --tokens "$tokens"
check "... and are there for it" test "$(status fresh "/v1/jobs/$long")" = 200
check "... and for no other" test "$(status b_viewer "/v1/jobs/$long")" = 404
check "no token was ever written down" no_token_in -r "$tmp/data"
serve_stop

# A sign-in whose hours are over.
SHEARWATER_SIGN_IN_S=3 serve_start "$tmp/data" --workers 0 --tokens "$tokens"
short=$(sign_in fresh)
follow "$short" events "$tmp/short"
check "a browser follows" kill -0 $follower
sleep 1.5
check "... as long as it is signed in" kill -0 $follower
check "... and no longer" ended $follower 4
check "... since the cookie is nobody's then" test "$(curl -sS --noproxy '*' -o /dev/null -w '%{http_code}' -H "Cookie: $short" "$url/v1/jobs")" = 401
serve_stop

# Without tokens a restart serves all of it, as before there were any.
serve_start "$tmp/data" --workers 0
kill -HUP $server_pid
check "a hangup finds nothing to read again" said 'started without --tokens' 1
check "... and ends nothing" kill -0 $server_pid
check "without tokens everybody sees all" test "$(curl -sS --noproxy '*' -o /dev/null -w '%{http_code}' "$url/v1/jobs/$long")" = 200
serve_stop
beyond() { refuses "$1" --listen 0.0.0.0:0 "${@:2}"; }
check "beyond loopback: refused without guards" beyond '--tokens, --tls-cert and --tls-key are missing'
check "beyond loopback: refused with tokens alone" beyond '--tls-cert and --tls-key are missing' --tokens "$tokens"
tap_done
