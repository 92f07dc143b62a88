#!/usr/bin/env bash
# Tests the scripts of `ebts slurm` with a real Slurm: munge, one slurmctld and two slurmd on this machine, in a temporary folder.
# One node is killed during its task and another task gets a time limit warning. Both tasks are queued again, the merge waits for
# them, and its result equals that of a single run.
#   cargo build --workspace && tests/slurm.sh
# Exit codes: 0 passed, 1 failed, 77 not run.
set -euo pipefail
cd "$(dirname "$0")/.."
export PATH=$PATH:/usr/sbin
for program in munged slurmctld slurmd sbatch; do
    command -v "$program" >/dev/null || {
        echo "slurm: NOT RUN: $program is not installed; run apt-get install --no-install-recommends slurmctld slurmd slurm-client munge" >&2
        exit 77
    }
done
ebts=$PWD/target/debug/ebts
work=$(mktemp -d)
export SLURM_CONF=$work/slurm.conf
declare -A pids=()
finish() {
    local status=$?
    # Tasks first: they do not end with their node's daemon.
    scancel --full --signal=KILL --user="$(id -un)" 2>/dev/null || true
    for name in "${!pids[@]}"; do kill "${pids[$name]}" 2>/dev/null || true; done
    wait
    [ "$status" = 0 ] || tail -n 30 "$work"/*.log "$work"/*.out 2>/dev/null || true
    rm -rf "$work"
}
trap finish EXIT
# Runs a check; reports a failure.
check() { "$@" || { echo "slurm: check failed: $*"; exit 1; }; }
# Waits for a condition; reports a timeout.
until_so() {
    local end=$((SECONDS + 300))
    until "$@"; do
        [ $SECONDS -lt $end ] || { echo "slurm: timed out after 300 s: $*"; exit 1; }
        sleep 0.2
    done
}

user=$(id -un) host=$(hostname -s) port=$((20000 + $$ % 20000))
chmod 711 "$work"
mkdir "$work/state"
head -c 1024 /dev/urandom >"$work/munge.key"
chmod 400 "$work/munge.key"
cat >"$SLURM_CONF" <<CONF
ClusterName=ebts
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
# A requeued task waits until its old credentials expire.
AuthInfo=socket=$work/munge.socket,cred_expire=5
StateSaveLocation=$work/state
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd-%n.pid
SlurmdSpoolDir=$work/spool-%n
SlurmdTimeout=10
ReturnToService=2
# No control groups and accounting: one machine without service manager.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
MpiDefault=none
MailProg=/bin/true
NodeName=one NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1
NodeName=two NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1
PartitionName=all Nodes=one,two Default=YES State=UP
CONF
start() {
    local name=$1
    shift
    "$@" >"$work/$name.log" 2>&1 &
    pids[$name]=$!
}
node() { start "$1" slurmd -D -N "$1" -f "$SLURM_CONF"; }
idle() { [ "$(sinfo --noheader --states=idle --format=%D 2>/dev/null)" = 2 ]; }

start munged munged --foreground --force --socket="$work/munge.socket" --key-file="$work/munge.key" \
    --pid-file="$work/munged.pid" --seed-file="$work/munge.seed"
until_so test -S "$work/munge.socket"
start slurmctld slurmctld -D -f "$SLURM_CONF"
node one
node two
until_so idle

experiment=(fig14 --preset N --seeds 80)
"$ebts" slurm --shards 4 --out "$work/sweep" -- "${experiment[@]}"
cd "$work"
bash sweep/submit.sh
job=$(squeue --noheader --name=ebts --format=%F | head -n 1)
running() { [ "$(squeue --noheader --states=running --jobs="${job}_$1" --format=%K)" = "$1" ]; }
has_runs() { running "$1" && [ -s "sweep/shard-$1/runs.jsonl" ]; }
queued_again() { scontrol show job "${job}_$1" | grep -q ' Restarts=[1-9]'; }

# Power failure: kills a node's daemon and all parent processes of its shard at once.
until_so has_runs 1
lost=$(squeue --noheader --jobs="${job}_1" --format=%N)
process=$(pgrep -f -- "--out $work/sweep/shard-1$")
dying=("${pids[$lost]}")
while [ "$process" -gt 1 ] && [ "$process" != "${pids[$lost]}" ]; do
    dying+=("$process")
    process=$(awk '$1 == "PPid:" { print $2 }' "/proc/$process/status")
done
kill -KILL "${dying[@]}"
finished=$(wc -l <sweep/shard-1/runs.jsonl)
head -n "$finished" sweep/shard-1/runs.jsonl >finished.jsonl
echo "node $lost killed with $finished runs of shard 1 finished"

# Time limit warning: the task saves its state and queues itself again.
until_so has_runs 2
# The timeout prevents scancel from sending a second warning while the task is requeued.
timeout 2 scancel --batch --signal=TERM "${job}_2" || true
until_so queued_again 2
echo "shard 2 warned with $(wc -l <sweep/shard-2/runs.jsonl) runs finished, queued again"

until_so queued_again 1
node "$lost"
echo "shard 1 queued again, node $lost is back"
over() { [ -z "$(squeue --noheader --format=%i)" ]; }
until_so over
check test -e sweep/whole/findings.json
check cmp finished.jsonl <(head -n "$finished" sweep/shard-1/runs.jsonl)

"$ebts" experiment "${experiment[@]}" --out one >/dev/null
for file in runs.csv curves.csv findings.json best-{1,2,3,4}.toml fig14.svg; do
    check cmp "one/$file" "sweep/whole/$file"
done
check cmp <(sort one/runs.jsonl) <(sort sweep/whole/runs.jsonl)
echo "slurm: passed: result equals a single run after a node failure and a time limit warning ($(slurmctld -V))"
