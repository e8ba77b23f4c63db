#!/usr/bin/env bash
# What boot.sh has done inside of the container: RESULT and what was looked at, a line each, in /root/results.
exec >/root/said 2>&1
set -x
url=http://127.0.0.1:8040 worker=shearwater-worker@127.0.0.1:8041
try() { local text=$1; shift; "$@"; printf '%d\t%s\n' $? "$text" >>/root/results; }
eventually() { local k; for k in $(seq 150); do "$@" && return 0; sleep 0.2; done; return 1; }
answers() { [ "$(curl -s -m 5 "$url/$1" | jq -r .status)" = ok ]; }
shows() { curl -s -m 5 "$url/v1/$1" | jq -e "$2"; }
has() { [ "$(systemctl show -p "$2" --value "$1")" = "$3" ]; }
job() { # SPP: submits a job; its id
    printf '{"scene": {"file": "/root/cornell-box.glb"}, "image": {"width": 192, "height": 192}, "sampling": {"spp": %d, "tile_px": 16}, "effects": {"indirect_bounces": 2}}' "$1" >/root/job.json
    shearwater submit /root/job.json --quiet
}

try "the coordinator starts" systemctl start shearwater
try "... and is ready" eventually answers readyz
try "a worker starts" systemctl start $worker
try "... and both workers are there" eventually shows workers '.workers | length == 2'
id=$(job 9)
try "a job, its scene imported in the box of the service, is finished" eventually shows "jobs/$id" '.state == "finished"'
try "... with a picture" curl -sf -o /root/picture.exr "$url/v1/jobs/$id/frames/1/image.exr"
try "the worker over TCP has traced of it" eventually shows workers '.workers | any(.name != "local-1" and .tiles_done > 0)'
try "reload does" systemctl reload shearwater
try "... and it still answers" answers livez
id=$(job 4000)
try "a long job runs" eventually shows "jobs/$id" '.progress.tiles_done > 0'
kill -9 "$(systemctl show -p MainPID --value shearwater)"
try "killed, it is back" eventually has shearwater NRestarts 1
try "... and ready" eventually answers readyz
try "... and goes on with the job" eventually shows "jobs/$id" '.state == "running" and .progress.tiles_done > 0'
try "... and so does the worker" eventually shows workers '.workers | length == 2'
try "stop stops it" systemctl stop shearwater
try "... as it should" has shearwater Result success
try "the worker waits meanwhile" has $worker ActiveState active
try "a start goes on" systemctl start shearwater
try "... with the job" eventually shows "jobs/$id" '.state == "running"'
try "stop stops the worker" systemctl stop $worker
try "... as it should" has $worker Result success
systemctl stop shearwater
objects() { journalctl -b -o cat "_SYSTEMD_UNIT=$1.service" | grep -v '^listening on ' | jq -es 'length > 2 and all(.message)'; }
try "the coordinator's journal is an object a line" objects shearwater
try "the worker's journal, too" objects $worker
try "nobody else can read what it stores" [ "$(stat -c %a /var/lib/private/shearwater)" = 700 ]
journalctl -b -o cat -u shearwater -u $worker | tail -n 200
echo "the end"
poweroff
