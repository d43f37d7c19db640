#!/bin/bash
# A comparison as a Slurm job array: every job makes a part of the fits, the last one puts the parts together.
#
#   sbatch --array=1-8 docs/cluster/slurm.sh RESULTS compare a.csv b.csv --map a.x3p b.x3p
#
# The parts and the results lie in the folder RESULTS, which all nodes see. A job that was ended is submitted again as it was:
# what it has finished is not made again. ASPERITY is the program, `asperity` on the path without it.
#SBATCH --job-name=asperity
#SBATCH --output=%x-%A-%a.log
set -euo pipefail

results=$1
shift
program=${ASPERITY:-asperity}
part=$SLURM_ARRAY_TASK_ID
parts=$SLURM_ARRAY_TASK_COUNT

mkdir -p "$results"
"$program" "$@" --shard "$part/$parts" -o "$results/part$part"
touch "$results/part$part.done"

# whoever is last puts the parts together
exec 9> "$results/.lock"
flock 9
count=$(find "$results" -maxdepth 1 -name 'part*.done' | wc -l)
if [ "$count" -eq "$parts" ] && [ ! -e "$results/all/report.html" ]; then
    "$program" merge "$results"/part*[0-9] -o "$results/all"
    "$program" "$@" -o "$results/all"
fi
