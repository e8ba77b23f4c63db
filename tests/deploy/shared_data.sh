#!/usr/bin/env bash
# --data and a worker's cache on a file system that hosts share: MooseFS, here with its servers and two clients for two
# hosts, in a network namespace that has loopback alone. As root; `make shared-data` installs it.
#   tests/deploy/shared_data.sh BUILD_DIR
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/deploy/shared_data.sh BUILD_DIR}
if [ "$(id -u)" != 0 ]; then echo "1..0 # SKIP namespaces and mounts want root"; exit; fi
for program in mfsmaster mfschunkserver mfsmount; do
    command -v $program >/dev/null || { echo "1..0 # SKIP $program is not installed: make shared-data"; exit; }
done
[ -n "${SHARED_TEST_INSIDE:-}" ] || exec env SHARED_TEST_INSIDE=1 unshare --net --mount "$0" "$@"
. tests/tap.bash
. tests/system/jobs.bash
mount --make-rprivate /
ip link set lo up && ip addr add 10.99.0.1/32 dev lo # its servers do without 127.0.0.1
fs=$tmp/fs
mkdir -p "$fs"/{master,chunks,disk} "$tmp"/{one,two}
cp /var/lib/mfs/metadata.mfs.empty "$fs/master/metadata.mfs"
echo '10.99.0.1 / rw,alldirs,maproot=0:0' >"$fs/exports"
echo "$fs/disk" >"$fs/disks"
printf '%s\n' "DATA_PATH = $fs/master" "EXPORTS_FILENAME = $fs/exports" 'WORKING_USER = root' 'WORKING_GROUP = root' >"$fs/master.cfg"
printf '%s\n' "DATA_PATH = $fs/chunks" "HDD_CONF_FILENAME = $fs/disks" 'HDD_LEAVE_SPACE_DEFAULT = 16MiB' 'MASTER_HOST = 10.99.0.1' \
    'BIND_HOST = 10.99.0.1' 'WORKING_USER = root' 'WORKING_GROUP = root' >"$fs/chunks.cfg"
mfsmaster -c "$fs/master.cfg" -f start >"$fs/master.log" 2>&1 & master=$!; track $master
mfschunkserver -c "$fs/chunks.cfg" -f start >"$fs/chunks.log" 2>&1 & track $!
mounted() { [ "$(stat -f -c %T "$1")" = fuseblk ] || [ "$(stat -f -c %T "$1")" = fuse ]; }
host() { mfsmount -H 10.99.0.1 -f "$tmp/$1" >"$fs/$1.log" 2>&1 & track $!; eventually 20 mounted "$tmp/$1"; }
trap 'umount -l "$tmp/one" "$tmp/two"; tap_cleanup' EXIT
writes() { echo here >"$tmp/one/probe" && [ "$(cat "$tmp/two/probe")" = here ]; }
answers() { : </dev/tcp/10.99.0.1/9421; }
if ! { eventually 10 answers && host one && host two && eventually 20 writes; }; then
    skip "data on a shared file system" "MooseFS does not start here: $(tail -qn 1 "$fs"/*.log | tr '\n' ' ')"
    tap_done
fi

# ---- the coordinator's data ----
scene=$PWD/tests/scenes/cornell-box/cornell-box.glb
big='"image": {"width": 320, "height": 320}, "sampling": {"spp": 128, "tile_px": 16}, "filter": {"method": "none"}'
check "a coordinator takes a folder of it" serve_start "$tmp/one/data" --workers 1 --worker-threads 1
first=$server_pid
second() { ! "$build/shearwater" serve --listen 127.0.0.1:0 --data "$tmp/two/data" --workers 0 2>"$tmp/second" && grep -q 'another coordinator uses this folder' "$tmp/second"; }
check "a second one, on another host, is refused it" second
id=$(submit "$big")
landed() { [ "$(number "$id" .progress.tiles_done)" -ge "$1" ]; }
check "tiles land in the spool" eventually 60 landed 60

# The file system does not answer for a while.
kill -STOP $master
lives() { is "$(http --max-time 2 -o "$tmp/body" -w '%{http_code}' "$url/livez")" 200; }
check "while it does not answer the coordinator lives" lives
told() { is "$(http -o "$tmp/body" -w '%{http_code}' "$url/readyz")" 503; }
check "... and says that it is not ready" eventually 10 told
kill -CONT $master
ready() { is "$(http -o "$tmp/body" -w '%{http_code}' "$url/readyz")" 200; }
check "when it answers again, so does /readyz" eventually 20 ready
check "the job goes on" is "$(job_state "$id")" running

# The coordinator dies, and another host goes on.
before=$(number "$id" .progress.tiles_done)
kill -9 $first; wait $first 2>/dev/null
takes_over() { serve_start "$tmp/two/data" --workers 1 --worker-threads 2; }
check "another host takes over" eventually 30 takes_over
check "the job is finished there" await_state "$id" finished 120
check "... from the tiles that had landed" shows "$id" ".statistics.tiles.resumed >= $before / 2"
exr "$id" "$tmp/shared.exr"
"$build/shearwater" render "$tmp/job.json" --quiet -o "$tmp/alone.exr"
check "the bytes are those of a local disk" cmp "$tmp/alone.exr" "$tmp/shared.exr"

# Results by range and ETag.
image=$url/v1/jobs/$id/frames/1/image.exr
etag=$(http -I "$image" | tr -d '\r' | sed -n 's/^[Ee][Tt]ag: //p')
check "a result has an ETag" [ -n "$etag" ]
part() { http -o "$tmp/$1" -w '%{http_code}' -H "Range: bytes=$2" -H "If-Range: $etag" "$image"; }
size=$(stat -c %s "$tmp/shared.exr")
by_parts() { is "$(part p1 0-999)" 206 && is "$(part p2 1000-$((size - 1001)))" 206 && is "$(part p3 -1000)" 206 && cat "$tmp"/p[123] | cmp - "$tmp/shared.exr"; }
check "it comes in parts, which make the whole" by_parts
check "who has it is told so" is "$(http -o "$tmp/body" -w '%{http_code}' -H "If-None-Match: $etag" "$image")" 304
check "who has another gets it whole" is "$(http -o "$tmp/body" -w '%{http_code}' -H 'If-Range: "other"' -H 'Range: bytes=0-9' "$image")" 200
check "the database is whole" is "$(sqlite3 "$tmp/two/data/jobs.sqlite" 'PRAGMA integrity_check')" ok
serve_stop

# ---- workers' cache ----
umask 077
openssl rand -hex 32 >"$tmp/key"
serve_start "$tmp/local" --workers 0 --worker-listen 127.0.0.1:0 --worker-key "$tmp/key"
port=$(worker_port "$tmp/local")
worker() { "$build/shearwater-worker" --connect "127.0.0.1:$port" --key "$tmp/key" --threads 1 --cache "$tmp/$1/cache" --name "$1" "${@:2}" 2>"$tmp/$1.log" & track $!; }
worker one; worker two
eventually 10 workers_are "one two"
id=$(submit "$big")
check "workers of two hosts share a cache" await_state "$id" finished 120
exr "$id" "$tmp/cached.exr"
check "... and make the same bytes" cmp "$tmp/alone.exr" "$tmp/cached.exr"
both() { http "$url/v1/workers" | jq -e 'all(.workers[]; .tiles_done > 0)'; }
check "both have traced" both
check "one scene is in it" is "$(find "$tmp/one/cache" -type f | wc -l)" 1
serve_stop
tap_done
