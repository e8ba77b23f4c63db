# TAP for system tests, and the processes they start. Source it; end with tap_done.
#   check TEXT COMMAND...     one test: passes when the command does
#   skip TEXT REASON          one test that cannot run here
#   has_scene FILE TEXT       whether the folder of scenes, $scenes, has a file; else the test is skipped
#   serve_start DATA [ARGS]   a coordinator on a free loopback port; sets $url and $server_pid
#   serve_stop [SIGNAL]
#   read_url PATH COMMAND...  the command reads the body of a GET at $url, in the clear
#   read_member PATH NAME     sets $value to the first member of that name in it, a word or a number
#   nap SECONDS
#   worker_port DATA          the port for workers of the coordinator that was started last, on stdout
#   kill_holding PID          kill -9 of the only worker, while it holds tiles
# Where programs are slow all waits are longer: by $TEST_SLOWER, which tests/run sets for sanitized
# builds; those of timeout and of curl --max-time, too.
# Everything started through `track` is killed when the script ends; $tmp is a folder of its own.
tap_n=0 tap_failed=0 tracked=() slower=${TEST_SLOWER:-1}
tmp=$(mktemp -d)
tap_cleanup() {
    local pid
    for pid in "${tracked[@]}"; do kill -9 "$pid" 2>/dev/null; done
    wait 2>/dev/null
    rm -rf "$tmp"
}
trap tap_cleanup EXIT
trap 'exit 130' INT TERM
track() { tracked+=("$1"); }

# What is preloaded before a sanitizer's allocator breaks it. (grep reads to the end: nm must not fail.)
is_sanitized() { [ "$(nm "$build/shearwater" | grep -c '__[at]san_init')" -gt 0 ]; }
# crashes_expected: processes from here on die of a SIGSEGV as they do without a sanitizer, which would report it.
crashes_expected() { export ASAN_OPTIONS=${ASAN_OPTIONS:-}:handle_segv=0 TSAN_OPTIONS=${TSAN_OPTIONS:-}:handle_segv=0; }
# tries N: numbers, for a loop that looks so often for something with a sleep between.
tries() { seq $(($1 * slower)); }
if [ "$slower" != 1 ]; then
    timeout() {
        local seconds=$1
        [[ $seconds =~ ^[0-9]+$ ]] || { command timeout "$@"; return; } # not for how long it may take
        shift
        command timeout $((seconds * slower)) "$@"
    }
    curl() {
        local words=()
        while [ $# -gt 0 ]; do
            words+=("$1")
            [ "$1" != --max-time ] || { words+=($(($2 * slower))); shift; }
            shift
        done
        command curl "${words[@]}"
    }
fi

check() {
    local text=$1; shift
    tap_n=$((tap_n + 1))
    if "$@" >"$tmp/check.out" 2>&1; then echo "ok $tap_n - $text"
    else
        echo "not ok $tap_n - $text"
        echo "#   $*"; tail -n 20 "$tmp/check.out" | sed 's/^/# /'
        tap_failed=$((tap_failed + 1))
    fi
}
skip() { tap_n=$((tap_n + 1)); echo "ok $tap_n - $1 # SKIP $2"; }
# Without that folder one line of the script says so, for all its tests of it.
scenes=$(realpath -m "${SHEARWATER_SCENES:-scenes}") scenes_missed=
has_scene() {
    [ ! -e "$scenes/$1" ] || return 0
    if [ -d "$scenes" ]; then skip "$2" "$1 is not in $scenes"
    elif [ -z "$scenes_missed" ]; then
        scenes_missed=1
        skip "scenes that are not shipped" "\$SHEARWATER_SCENES names no folder of them: tests/golden/README.md"
    fi
    return 1
}
tap_done() { echo "1..$tap_n"; [ "$tap_failed" -eq 0 ]; exit; }

serve_start() {
    local data=$1; shift
    mkdir -p "$data"
    : >"$data/stdout" # the line of a server before this one must not be read
    touch "$data/stderr"
    told_bytes=$(stat -c %s "$data/stderr")
    "$build/shearwater" serve --listen 127.0.0.1:0 --data "$data" "$@" \
        >"$data/stdout" 2>>"$data/stderr" &
    server_pid=$!
    track $server_pid
    url=
    for _ in $(tries 200); do
        url=$(sed -n 's/^listening on //p' "$data/stdout")
        [ -n "$url" ] && return 0
        kill -0 $server_pid 2>/dev/null || { cat "$data/stderr" >&2; return 1; }
        nap 0.05
    done
    return 1
}
# It is said in the log, whose lines are written beside the service: perhaps after its address.
worker_port() {
    local port
    for _ in $(tries 200); do
        port=$(tail -c +$((told_bytes + 1)) "$1/stderr" | sed -nE 's/.*worker_port"?[=:]([0-9]+).*/\1/p')
        [ -n "$port" ] && { echo "$port"; return 0; }
        nap 0.05
    done
    echo "no port for workers in $1/stderr" >&2
    return 1
}
serve_stop() { kill "${1:--TERM}" "$server_pid" 2>/dev/null; wait "$server_pid" 2>/dev/null; }

# Tests ask often, and starting curl takes three times as long as starting jq, which takes ten times as long as no process.
ask() { # ask PATH [METHOD]: opens $answer behind the head of what is answered, which is $head
    local line
    head=
    exec {answer}<>"/dev/tcp/127.0.0.1/${url##*:}" || return 1
    printf '%s %s HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n' "${2:-GET}" "$1" >&$answer
    while read -r line && [ "$line" != $'\r' ]; do head+=$line$'\n'; done <&$answer
}
read_url() {
    local answer head status
    ask "$1" || return 1
    "${@:2}" <&$answer
    status=$?
    exec {answer}>&-
    return $status
}
read_member() {
    local answer head part
    value=
    ask "$1" || return 1
    while IFS= read -r -d , part; do
        [[ $part != *"\"$2\":"* ]] || { value=${part#*"\"$2\":"} value=${value//[\"\}]/}; break; }
    done <&$answer
    exec {answer}>&-
    [ -n "$value" ]
}
# Sleeps without a process: nothing is ever written there.
exec {silence}<> <(:)
nap() { read -r -t "$1" -u $silence; :; }

# A worker that stands still is given what it has room for; all that it had sent is read by then.
kill_holding() {
    local held=0 _
    kill -STOP "$1"
    for _ in $(tries 100); do
        nap 0.1
        held=$(read_url /v1/workers jq '[.workers[].tiles_in_hand] | add')
        [ "$held" -gt 0 ] && break
    done
    kill -9 "$1"
    echo "killed with $held tiles in hand"
    [ "$held" -gt 0 ]
}

# job_state ID, await_state ID STATE SECONDS
job_state() { local value; read_member "/v1/jobs/$1" state && echo "$value"; }
await_state() {
    local value end=$((SECONDS + $3 * slower))
    while [ $SECONDS -lt $end ]; do
        read_member "/v1/jobs/$1" state
        [ "$value" != "$2" ] || return 0
        case $value in failed | cancelled | finished) break ;; esac
        nap 0.05
    done
    echo "job $1 is $value, not $2" >&2
    read_url "/v1/jobs/$1" jq -c '{state, error, progress}' >&2
    return 1
}
