#!/usr/bin/env bash
# Workers as tasks of an array in a real Slurm on this machine: four render a frame, one is killed, two are told to go,
# and no byte changes. What Slurm needs is started here, on loopback, and ends with the script. `make slurm` installs it.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=$(realpath "${1:?usage: tests/system/slurm.sh BUILD_DIR}")
. tests/tap.bash
. tests/system/jobs.bash
host=$(hostname -s 2>/dev/null || uname -n)
umask 077
openssl rand -hex 32 >"$tmp/key"
launch() { (cd "$tmp" && "$build/shearwater" workers launch slurm --connect "127.0.0.1:$port" --key "$tmp/key" "$@"); } # logs of tasks go there

# What is wrong is said before anything is submitted.
port=8041
refuses() { local status; launch "${@:3}" >"$tmp/refused" 2>&1; status=$?; is $status "$1" && grep -q -- "$2" "$tmp/refused" || { cat "$tmp/refused"; return 1; }; }
check "a time that is none is refused" refuses 2 'is no time' --time soon
check "one too short is refused" refuses 2 'between 2 minutes' --time 1
check "so is an address without a port" refuses 2 'HOST:PORT' --connect here
check "so are five thousand jobs" refuses 2 'not in 1..4096' --jobs 5000
install -m 640 "$tmp/key" "$tmp/open"
check "so is a key that a group can read" refuses 1 'chmod 600' --key "$tmp/open" --print
check "so is one that is not there" refuses 1 'No such file' --key "$tmp/none" --print
check "the script can be seen" launch --jobs 4 --cpus 1 --time 10 --print
check "... and is none that bash cannot read" bash -n "$tmp/check.out"
no_sbatch() { ! PATH=/nonexistent launch 2>"$tmp/refused" && grep -q 'is Slurm installed here' "$tmp/refused"; }
check "without sbatch this is said" no_sbatch

for program in munged slurmctld slurmd sbatch; do
    command -v $program >/dev/null || { skip "workers in Slurm" "$program is not installed: make slurm"; tap_done; }
done

free_port() { node -e 'const s = require("net").createServer().listen(0, "127.0.0.1", () => { console.log(s.address().port); s.close(); })'; }
mkdir -p "$tmp/slurm/state" "$tmp/slurm/spool" "$tmp/munge" "$tmp/scratch"
chmod 755 "$tmp" "$tmp/slurm" # munged asks for it
head -c 128 /dev/urandom >"$tmp/munge/key"
# Sites give tasks a scratch folder so.
printf '#!/bin/sh\necho export TMPDIR=%s\n' "$tmp/scratch" >"$tmp/prolog"
chmod 700 "$tmp/prolog"
cat >"$tmp/slurm.conf" <<C
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$tmp/munge/socket
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
StateSaveLocation=$tmp/slurm/state
SlurmdSpoolDir=$tmp/slurm/spool
SlurmctldPidFile=$tmp/slurm/slurmctld.pid
SlurmdPidFile=$tmp/slurm/slurmd.pid
SlurmdParameters=config_overrides
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=1
ReturnToService=2
KillWait=10
TaskProlog=$tmp/prolog
NodeName=$host NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
C
export SLURM_CONF=$tmp/slurm.conf
munged --foreground --force --num-threads=2 --key-file="$tmp/munge/key" --socket="$tmp/munge/socket" --pid-file="$tmp/munge/pid" \
    --seed-file="$tmp/munge/seed" --log-file="$tmp/munge/log" >"$tmp/munge/out" 2>&1 &
track $!
eventually 5 [ -S "$tmp/munge/socket" ]
slurmctld -D >"$tmp/slurm/slurmctld.log" 2>&1 & track $!
slurmd -D -N "$host" >"$tmp/slurm/slurmd.log" 2>&1 & track $!
is_up() { [ "$(sinfo -h -o %T 2>/dev/null)" = idle ]; }
if ! eventually 20 is_up; then
    skip "workers in Slurm" "Slurm does not start here: $(tail -qn 1 "$tmp/munge/out" "$tmp/slurm/slurmctld.log" "$tmp/slurm/slurmd.log" | tr '\n' ' ')"
    tap_done
fi

# The array.
serve_start "$tmp/data" --workers 0 --worker-listen 127.0.0.1:0 --worker-key "$tmp/key" || { echo "Bail out! no server"; exit 1; }
port=$(worker_port "$tmp/data")
box='"image": {"width": 320, "height": 320}, "sampling": {"spp": 128, "tile_px": 16}, "filter": {"method": "none"}'
array=$(launch --jobs 4 --cpus 1 --time 10 --idle-exit 10) # on a busy machine the first wait so long for the last
task_names() { local t; for t in "$@"; do printf '%s:slurm-%s_%s ' "$host" "$array" "$t"; done | sed 's/ $//'; }
check "an array of four workers is submitted" [ -n "$array" ]
check "its tasks join under their names" eventually 30 workers_are "$(task_names 1 2 3 4)"
secret() { scontrol write batch_script "$array" "$tmp/stored" >/dev/null && grep -q -- "--key '$tmp/key'" "$tmp/stored" && ! grep -qF "$(cat "$tmp/key")" "$tmp/stored"; }
check "Slurm has the key's path, and not the key" secret
queue_is_empty() { [ -z "$(squeue -h)" ]; }
trap 'scancel "$array"; eventually 15 queue_is_empty; tap_cleanup' EXIT # no task outlives Slurm
id=$(submit "$box")
check "they trace" eventually 60 has_landed "$id" 20
four_folders() { is "$(find "$tmp/scratch" -name '*shearwater-worker.*' | wc -l)" 4; }
check "each keeps its scenes in the scratch folder" eventually 20 four_folders
pid_of() { http "$url/v1/workers" | jq ".workers[] | select(.name == \"$(task_names "$1")\") | .pid"; }
check "one is killed while it holds tiles" kill_holding "$(pid_of 1)"
check "one is cancelled" scancel "${array}_2"
check "one is told that its time ends" scancel --batch --signal=USR1 "${array}_3"
check "the last one stays" eventually 20 workers_are "$(task_names 4)"
check "the job was not done by then" is "$(job_state "$id")" running
check "it finishes" await_state "$id" finished 120
exr "$id" "$tmp/disturbed.exr"
check "the idle worker leaves, and the queue is empty" eventually 30 queue_is_empty
ended_in_order() { grep -q ' leaving' "$1" && ! grep -q ' error ' "$1"; }
log() { echo "$tmp/shearwater-worker-${array}_$1.log"; }
for t in 2 3 4; do check "worker $t left in order" ended_in_order "$(log $t)"; done
check "no scene is left in the scratch folder" [ -z "$(ls "$tmp/scratch")" ]

# The same frame without Slurm.
serve_stop
"$build/shearwater" render "$tmp/job.json" --quiet -o "$tmp/alone.exr"
check "the bytes are those of one machine" cmp "$tmp/alone.exr" "$tmp/disturbed.exr"
tap_done
