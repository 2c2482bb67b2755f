#!/bin/bash
# A study of parameters: one run a line of study.txt, each through as many jobs as it needs: sbatch --array=1-6 study.sh
# A line holds what --set takes, separated by blanks:
#     materials.cream.yield_stress=20 bodies.ball.velocity=[0,0,-2]
# Line N is the run in out/study/N. Empty lines and lines that begin with # do not count.

#SBATCH --job-name=study
#SBATCH --nodes=1
#SBATCH --ntasks-per-node=16
#SBATCH --time=04:00:00
#SBATCH --output=%x-%A_%a.log
#SBATCH --open-mode=append        # all parts of a run write to one log
#SBATCH --requeue                 # may start again: requested by this script, or by Slurm when a node was lost
#SBATCH --signal=USR1@180         # for mpirun: B:USR1@180, and the last lines of mpirun.sh

scene=scene.toml
study=study.txt
folder=out/study/$SLURM_ARRAY_TASK_ID
options=()                        # further options that all runs have
reserve=300                       # s of --time not for bulkley: more than --signal, which may come a minute early
max_walltime=                     # set it ("1h55m") to end parts sooner than the limit would
program=bulkley

# module load bulkley             # sets BULKLEY_SCRIPTS and PATH
. "${BULKLEY_SCRIPTS:?is not set: load the module bulkley, or name the folder that holds job_functions.sh}/job_functions.sh"

set_options_of_line "$study" "$SLURM_ARRAY_TASK_ID"
begin_part slurm
launch srun --mpi=pmix "$program" run "$scene" --out "$folder" "${part_options[@]}" "${options[@]}" "${set_options[@]}"
end_part $?
