#!/usr/bin/env bash
# The end of a job is told to a program of somebody's: signed, again and again until it is taken, over a restart, only to
# hosts that the operator allows, and without holding anything else up.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/webhook.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
command -v node >/dev/null || { skip "the end of a job is told" "needs node"; tap_done; exit; }

openssl rand -hex 32 >"$tmp/key" && chmod 600 "$tmp/key"
node tests/system/webhook_receiver.mjs "$tmp/key" "$tmp/calls" "$tmp/closed" >"$tmp/port" &
track $!
touch "$tmp/calls"
eventually 10 test -s "$tmp/port"
port=$(cat "$tmp/port")
export SHEARWATER_WEBHOOK_RETRY_MS=100 SHEARWATER_WEBHOOK_MS=2000

small='"image": {"width": 16, "height": 16}, "sampling": {"spp": 1}'
hooked() { submit "$small, \"name\": \"$1\", \"webhook\": {\"url\": \"$2\"}"; }
refused() { ! hooked x "$1" 2>"$tmp/refused" && grep -q "/webhook/url: $2" "$tmp/refused"; }
calls() { jq -se "[.[] | select(.path == \"$1\")] | $2" "$tmp/calls"; }
hosts=(--webhook-hosts "hooks.example,127.0.0.1:$port" --webhook-key "$tmp/key")

start
check "without hosts of the operator's a job with a webhook is refused" refused "http://127.0.0.1:$port/flaky" 'this server tells nobody'
serve_stop
cannot() { ! timeout 20 "$build/shearwater" serve --listen 127.0.0.1:0 --data "$tmp/none" "$@" >"$tmp/cannot" 2>&1; }
cp "$tmp/key" "$tmp/open" && chmod 644 "$tmp/open"
check "a key that others can read is refused" cannot --webhook-hosts a --webhook-key "$tmp/open"
check "hosts without a key are refused" cannot --webhook-hosts a
check "a host that is none is refused" cannot --webhook-hosts 'a:b' --webhook-key "$tmp/key"

start "${hosts[@]}"
check "another port is refused" refused "http://127.0.0.1:1/flaky" '127.0.0.1:1 is none of the hosts'
by_option() { ! "$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet --webhook "$1" 2>"$tmp/refused" && grep -q "/webhook/url: $2" "$tmp/refused"; }
check "... also of submit --webhook" by_option "http://127.0.0.1:2/flaky" '127.0.0.1:2 is none of the hosts'
check "another name of the host is refused" refused "http://localhost:$port/flaky" "localhost:$port is none"
check "... in other spellings, too" refused "http://127.0.0.1:$port@hooks.other/" 'it names a user'
check "a port that is not the scheme's own is refused" refused "https://hooks.example:8443/" 'hooks.example:8443 is none'
hanging=$(hooked hangs "http://127.0.0.1:$port/hang")
flaky=$(hooked 'Gulls \"1\"' "http://127.0.0.1:$port/flaky")
check "one that fails twice is told a third time" eventually 30 calls /flaky 'map(.answer) == [500, 302, 204]'
check "... each time by a POST whose signature is right" calls /flaky 'all(.valid and .method == "POST")'
check "... with the job's id, name, state and links" calls /flaky ".[2].body == {id: \"$flaky\", name: \"Gulls \\\"1\\\"\",
    state: \"finished\", links: {job: \"/v1/jobs/$flaky\", page: \"/#/jobs/$flaky\", thumbnail: \"/v1/jobs/$flaky/thumbnail\"}}"
check "no redirect is followed" calls /elsewhere 'length == 0'
check "one that does not answer is called meanwhile, and again" eventually 30 calls /hang 'length >= 2 and all(.valid)'
answers_at_once() { [ "$(curl -sS --noproxy '*' -o /dev/null -w '%{time_total} < 0.5\n' "$url/v1/jobs" | bc)" = 1 ]; }
command -v bc >/dev/null && check "... while the server answers others at once" answers_at_once
metric() { http "$url/metrics" | grep -E "^$1\$" >/dev/null; } # -q would end before all is read
check "metrics count what was taken" eventually 10 metric 'shearwater_webhooks_total{outcome="delivered"} 1'
check "... and what failed" metric 'shearwater_webhooks_total{outcome="failed"} [3-9]'
http -o /dev/null -X DELETE "$url/v1/jobs/$hanging?purge=1"

# One that waits, of a coordinator whose clock is a year ahead of the next one's. (tests/fake/preload_faults.c)
touch "$tmp/closed"
serve_stop
ahead() {
    head -c 232 /dev/zero >"$tmp/control"
    node -e 'const fs = require("fs"), file = fs.openSync(process.argv[1], "r+"), b = Buffer.alloc(8);
        b.writeBigInt64LE(31536000n); fs.writeSync(file, b, 0, 8, 192);' "$tmp/control"
    LD_PRELOAD=$(realpath "$build/tests/fake/preload_faults.so") FAULTS_FOR=shearwater FAULTS_CONTROL=$tmp/control start "${hosts[@]}"
    eventually 5 grep -q "^$(($(date +%Y) + 1))-" "$tmp/data/stderr"
}
if is_sanitized; then start "${hosts[@]}"; else check "a coordinator's clock is a year ahead" ahead; fi
submit "$small" >/dev/null # writes the document
late=$("$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet --name late --webhook "http://127.0.0.1:$port/late")
check "one that is closed is called" eventually 30 calls /late 'length >= 1'
serve_stop -KILL
rm "$tmp/closed"
start "${hosts[@]}"
check "after a restart it is told" eventually 30 calls /late 'last | .answer == 200 and .valid'
count=$(jq -s length "$tmp/calls")
sleep 1
check "what was taken is told once" is "$(jq -s length "$tmp/calls")" "$count"
check "... of the job before the restart" calls /late "last | .body.id == \"$late\""
serve_stop
tap_done
