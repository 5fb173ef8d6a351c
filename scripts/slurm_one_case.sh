#!/bin/bash
# One long case on a cluster, from the folder that is to have results/:
#
#   sbatch --time=1-00:00 --partition=... scripts/slurm_one_case.sh swing cases/swing/1b_long.nml
#
# The program writes a checkpoint every ten minutes, and two minutes before the time limit, where the job is queued
# again; it goes on from its checkpoint after that, after the death of a node, and when submitted again.
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:USR1@120
app=$1
case=$2
checkpoint=results/$(basename "$case" .nml)/checkpoint.taut
restart=()
if [ -e "$checkpoint" ]; then restart=(--restart "$checkpoint"); fi

export OPENBLAS_NUM_THREADS=1
"$app" "$case" --quiet --checkpoint 600 "${restart[@]}" &
program=$!

again=
trap 'again=yes; kill -USR1 $program' USR1
trap : TERM # canceled or preempted: Slurm itself tells the program, which is waited for
while kill -0 $program 2>/dev/null; do wait $program; done
wait $program
code=$?
# 75: interrupted, with a checkpoint to go on from.
if [ "$again" ] && [ $code = 75 ]; then scontrol requeue "$SLURM_JOB_ID"; fi
exit $code
