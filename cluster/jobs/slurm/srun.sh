#!/bin/bash
# One run through as many jobs as it needs, ranks started by srun: sbatch srun.sh
# Copy it, change the settings, submit it once. docs/clusters.md describes the rest.

#SBATCH --job-name=bulkley
#SBATCH --nodes=1
#SBATCH --ntasks-per-node=64
#SBATCH --time=24:00:00
#SBATCH --output=%x-%j.log
#SBATCH --open-mode=append        # all parts of the run write to one log
#SBATCH --requeue                 # may start again: requested by this script, or by Slurm when a node was lost
#SBATCH --signal=USR1@180         # 3 min before the limit, should --max-walltime have misjudged: the ranks save and stop

scene=scene.toml
folder=out/scene
options=()                        # further options of bulkley run, such as: --set materials.cream.yield_stress=30
reserve=300                       # s of --time not for bulkley: more than --signal, which may come a minute early
max_walltime=                     # set it ("1h55m") to end parts sooner than the limit would
program=bulkley

# module load bulkley             # sets BULKLEY_SCRIPTS and PATH
. "${BULKLEY_SCRIPTS:?is not set: load the module bulkley, or name the folder that holds job_functions.sh}/job_functions.sh"

begin_part slurm
launch srun --mpi=pmix "$program" run "$scene" --out "$folder" "${part_options[@]}" "${options[@]}"
end_part $?
