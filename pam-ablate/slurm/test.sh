#!/usr/bin/env bash
# Runs a sweep as a job array of a real Slurm: munged, slurmctld and slurmd on this machine, in a folder and on
# ports of their own, so that nothing installed is touched.
#
#   apt-get install slurm-wlm
#   cargo build --release -p pam-cli
#   pam-ablate/slurm/test.sh [FOLDER]         # as root; about five minutes
#
# What must hold:
# 1. two tasks of one array share the cells of one folder; none is run twice;
# 2. a task whose time is over is signalled, saves its cells, queues itself again and goes on;
# 3. a task that is cancelled saves its cells, and does not come back;
# 4. the merged table has every cell, with the numbers of a run without Slurm.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
pam=${PAM:-$here/../../target/release/pam}
for program in munged slurmctld slurmd sbatch srun scontrol squeue; do
    command -v "$program" >/dev/null || { echo "$program is missing: apt-get install slurm-wlm" >&2; exit 1; }
done
[ "$(id -u)" = 0 ] || { echo "the daemons need root" >&2; exit 1; }
work=${1:-$(mktemp -d)}
mkdir -p "$work"
work=$(cd "$work" && pwd)
chmod 755 "$work"
host=$(hostname -s)
daemons=()
stop_daemons() {
    for pid in "${daemons[@]}"; do kill "$pid" 2>/dev/null || true; done
    wait 2>/dev/null || true
}
trap stop_daemons EXIT

mkdir -p "$work"/{state,spool,munge}
chmod 700 "$work/munge"
dd if=/dev/urandom of="$work/munge/key" bs=128 count=1 status=none
chmod 600 "$work/munge/key"
socket=$work/munge.socket
munged --foreground --force --key-file="$work/munge/key" --socket="$socket" --seed-file="$work/munge/seed" \
    --pid-file="$work/munge/pid" --log-file="$work/munge/log" >"$work/munged.out" 2>&1 &
daemons+=($!)
cat >"$work/slurm.conf" <<EOF
ClusterName=pamtest
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=26817
SlurmdPort=26818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$socket,cred_expire=5
CredType=cred/munge
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
ReturnToService=2
KillWait=20
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=test Nodes=$host Default=YES MaxTime=INFINITE State=UP
EOF
export SLURM_CONF=$work/slurm.conf
for _ in $(seq 50); do [ -S "$socket" ] && break; sleep 0.1; done
slurmctld -D >"$work/slurmctld.out" 2>&1 &
daemons+=($!)
slurmd -D >"$work/slurmd.out" 2>&1 &
daemons+=($!)
for _ in $(seq 100); do sinfo -h -o %T 2>/dev/null | grep -q idle && break; sleep 0.3; done
sinfo -h -o %T | grep -q idle || { echo "no idle node; see $work/slurm*.log" >&2; exit 1; }
echo "$(slurmctld -V): controller and daemon on $host"

cat >"$work/protocol.toml" <<'EOF'
name = "short"
conditions = [[30, 60], [60, 30], [45, 45], [80, 80], [55, 40]]
[[current]]
kind = "sine"
amplitude_a = 1.5
frequency_hz = 0.5
duration_s = 4.0
EOF
"$pam" rig record --ideal all --no-truth --quiet --protocol "$work/protocol.toml" --out "$work/logs"
cat >"$work/sweep.toml" <<EOF
name = "slurm"
seeds = 2
metrics = ["held_out_r2_x"]
[experiment]
recordings = ["logs"]
[set]
"stage.1.matching.steps" = 300
"stage.2.epochs" = ${EPOCHS:-600}
"model.hidden" = [32, 32]
[[axis]]
key = "model.activation"
values = ["silu", "tanh", "softplus"]
EOF
"$pam" ablate template >"$work/ablate.sbatch"
cd "$work"
settled() { # waits until the queue is empty, at most some seconds
    for _ in $(seq "$1"); do [ -z "$(squeue -h)" ] && return 0; sleep 1; done
    squeue; scontrol show job; echo "jobs are still queued" >&2; return 1
}
submit() { PAM=$pam sbatch --parsable --array=1-2 --cpus-per-task=1 --chdir="$work" "$@"; }
events() { cat "$1"/cells/*/claim 2>/dev/null | grep -c "\"$2\"" || true; }

echo "1 and 2: two tasks of a minute each, signalled 20 s before; they come back until all is done"
begun=$(date +%s)
job=$(submit --time=00:01:00 --signal=TERM@20 ablate.sbatch sweep.toml out --checkpoint-s 5)
settled 900
echo "   job $job took $(($(date +%s) - begun)) s; queued again: $(cat pam-ablate-"$job"_*.log | grep -c 'queued again' || true)"
[ "$(events out over)" = 6 ] || { echo "not all cells are over" >&2; exit 1; }
stopped=$(events out stopped)
[ "$stopped" -gt 0 ] || { echo "no cell was ever stopped by the scheduler; set EPOCHS higher" >&2; exit 1; }
[ "$(events out began)" = $((6 + stopped)) ] || { echo "a cell was begun without need" >&2; exit 1; }
echo "   6 cells, begun $(events out began) times, stopped by the signal $stopped times, ended 6 times"

echo "3: a cancelled array saves and does not come back"
job=$(submit --time=01:00:00 ablate.sbatch sweep.toml cancelled --checkpoint-s 3600)
for _ in $(seq 300); do [ "$(ls cancelled/cells/*/work/checkpoint.json 2>/dev/null | wc -l)" -ge 2 ] && break; sleep 0.2; done
sleep 3
scancel "$job"
settled 120
[ "$(events cancelled stopped)" -ge 1 ] || { echo "nothing was saved" >&2; exit 1; }
grep -l 'queued again' pam-ablate-"$job"_*.log && { echo "a cancelled task queued itself again" >&2; exit 1; }
echo "   stopped and saved: $(events cancelled stopped); over: $(events cancelled over)"

echo "4: the same numbers as without Slurm"
"$pam" ablate merge out --quiet
"$pam" ablate sweep.toml --out plain --quiet
cmp out/results.csv plain/results.csv
cmp out/results.parquet plain/results.parquet
"$pam" ablate sweep.toml --out cancelled --quiet
cmp cancelled/results.csv plain/results.csv
echo "all of it holds"
