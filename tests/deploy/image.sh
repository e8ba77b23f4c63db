#!/usr/bin/env bash
# The container image without a container engine: its root is mounted read-only, and a coordinator and a worker run on it
# as user 10001 without capabilities, in namespaces of their own and on a network that has loopback alone. As root.
#   tests/deploy/image.sh BUILD_DIR [ROOT]
# ROOT is a folder with the root of the image; default: that of the image `shearwater` of buildah (make image).
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/deploy/image.sh BUILD_DIR [ROOT]}
root=${2:-}
if [ "$(id -u)" != 0 ]; then echo "1..0 # SKIP namespaces and mounts want root"; exit; fi
[ -n "${IMAGE_TEST_INSIDE:-}" ] || exec env IMAGE_TEST_INSIDE=1 unshare --net --mount "$0" "$@"
ip link set lo up
. tests/tap.bash
. tests/system/jobs.bash
bail() { echo "Bail out! $*"; exit 1; }
if [ -z "$root" ]; then
    container=$(buildah from localhost/shearwater) || bail "there is no image shearwater: make image"
    trap 'tap_cleanup; buildah rm "$container" >/dev/null' EXIT
    root=$(buildah mount "$container") || bail "the image cannot be mounted"
    settings() { buildah inspect --type image localhost/shearwater | jq -e ".OCIv1.config | $1"; }
    check "the image runs as another user than root" settings '.User == "10001:10001"'
    check "... and keeps data and scenes outside of it" settings '.Volumes | has("/data") and has("/cache")'
    health() { buildah inspect --type image localhost/shearwater | jq -e '.Docker.config.Healthcheck.Test == ["CMD", "shearwater", "health"]'; }
    check "... and has a health check" health
fi
mount --make-rprivate /
mount --bind "$root" "$root" && mount -o remount,bind,ro "$root" || bail "the root cannot be mounted read-only"

# inside NAME COMMAND...: what an engine would do, with the folders $tmp/NAME.data and $tmp/NAME.cache.
inside() {
    local name=$1; shift
    install -d -o 10001 -g 10001 -m 700 "$tmp/$name.data" "$tmp/$name.cache"
    # $1 and $2: the root and the folders; the command follows.
    exec unshare --mount --pid --fork --kill-child --ipc --uts bash -c '
        root=$1 at=$2; shift 2
        hostname container
        mount -t proc proc "$root/proc" && mount -t tmpfs -o mode=1777 tmp "$root/tmp" && mount -t tmpfs -o mode=755 dev "$root/dev" || exit 125
        for device in null zero urandom random; do touch "$root/dev/$device"; mount --bind "/dev/$device" "$root/dev/$device"; done
        mount --bind "$at.data" "$root/data" && mount --bind "$at.cache" "$root/cache" || exit 125
        [ ! -d "$at.secret" ] || mount --bind "$at.secret" "$root/mnt" || exit 125
        exec env -i PATH=/usr/sbin:/usr/bin:/bin XDG_CACHE_HOME=/cache ${POD_NAME:+POD_NAME=$POD_NAME} chroot "$root" setpriv --reuid 10001 --regid 10001 \
            --clear-groups --no-new-privs --bounding-set=-all --inh-caps=-all "$@"' inside "$root" "$tmp/$name" "$@"
}
said() { (inside probe "$@"); }

check "it runs as user 10001" is "$(said id -u)" 10001
check "... without any capability" is "$(said sed -n 's/^CapBnd:[[:space:]]*//p' /proc/self/status)" 0000000000000000
writes() { said touch "$1" 2>"$tmp/said"; }
fails_to_write() { ! writes "$1" && grep -q 'Read-only file system' "$tmp/said"; }
for at in /data /cache /tmp; do check "it can write to $at" writes $at/here; done
for at in / /usr /etc /mnt; do check "... and not to $at" fails_to_write $at/here; done
programs_are_one() { local v; v=$(said shearwater --version | cut -d' ' -f2) && is "$v" "$(said shearwater-worker --version | cut -d' ' -f2)"; }
check "both programs are there, of one build" programs_are_one
libraries() { said sh -c 'for p in shearwater shearwater-worker shearwater-import; do ldd /usr/bin/$p; done' >"$tmp/said"; grep -q libembree "$tmp/said" && ! grep 'not found' "$tmp/said"; }
check "no library is missing" libraries
no_compiler() { is "$(said sh -c 'for p in gcc make curl sh; do command -v $p; done')" /usr/bin/sh; }
check "no compiler came along" no_compiler

# A key and tokens as an engine mounts them: root's, and readable by the group of the program.
secret() { install -d -m 755 "$tmp/$1.secret"; install -o 0 -g 10001 -m 440 "$tmp/worker.key" "$tmp/$1.secret/worker.key"; }
openssl rand -hex 32 >"$tmp/worker.key"
secret server; secret worker
(inside server shearwater serve --data /data --listen 127.0.0.1:8040 --workers 0 --worker-listen 127.0.0.1:8041 --worker-key /mnt/worker.key) \
    >"$tmp/server.out" 2>"$tmp/server.log" &
server=$!
track $server
url=http://127.0.0.1:8040
lives() { said shearwater health; }
check "the coordinator lives, its health check says" eventually 20 lives
not_ready() { ! said shearwater health --ready 2>"$tmp/health" && grep -q 'wait for a worker' "$tmp/health"; }
check "it is not ready without a worker" not_ready
(POD_NAME=worker-5d9f-x2 inside worker shearwater-worker --connect 127.0.0.1:8041 --key /mnt/worker.key --threads 2 --connect-within 20 --idle-exit 60) \
    >"$tmp/worker.log" 2>&1 &
worker=$!
track $worker
check "a worker joins under its pod's name" eventually 20 workers_are worker-5d9f-x2
check "it is ready then" eventually 5 said shearwater health --ready
id=$(submit '"image": {"width": 160, "height": 160}, "sampling": {"spp": 9}')
check "a job is done" await_state "$id" finished 60
exr "$id" "$tmp/contained.exr"
check "the scene is in the worker's cache" [ -n "$(find "$tmp/worker.cache" -type f)" ]
stop() { kill -TERM "$(tr -d ' ' <"/proc/$1/task/$1/children")" && wait "$1"; } # unshare's only child is the program
check "SIGTERM ends the worker in order" stop $worker
check "... and the coordinator" stop $server
check "the jobs' folder was written by user 10001 alone" [ -z "$(find "$tmp/server.data" ! -uid 10001)" ]
if is "$(said shearwater --version | cut -d' ' -f2)" "$("$build/shearwater" --version | cut -d' ' -f2)" >/dev/null; then
    "$build/shearwater" render "$tmp/job.json" --quiet -o "$tmp/here.exr"
    check "the bytes are those of this machine's build" cmp "$tmp/here.exr" "$tmp/contained.exr"
else
    skip "the bytes are those of this machine's build" "the image is of another build"
fi
tap_done
