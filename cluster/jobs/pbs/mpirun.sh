#!/bin/bash
# One run through as many jobs as it needs, under OpenPBS (or Torque: nodes=1:ppn=64 in place of select): qsub mpirun.sh
# Copy it, change the settings, submit it once. docs/clusters.md describes the rest. Each part submits the next one,
# which needs qsub on the compute nodes; where that is forbidden the job prints a message, and is submitted again by hand.

#PBS -N bulkley
#PBS -l select=1:ncpus=64:mpiprocs=64
#PBS -l walltime=24:00:00
#PBS -j oe
#PBS -r y                         # may start again when a node was lost

# PBS gives no warning before the limit: only --max-walltime ends a part in time.
script=mpirun.sh                  # this file, which the next part is submitted with; from the folder of the first qsub
scene=scene.toml
folder=out/scene
options=()                        # further options of bulkley run, such as: --set materials.cream.yield_stress=30
reserve=300                       # s of walltime that bulkley may not use
max_walltime=                     # set it ("1h55m") to end parts sooner than the limit would
after=                            # script to submit when the run is finished, because no job can wait for the whole chain
program=bulkley

cd "$PBS_O_WORKDIR" || exit 2
# module load bulkley             # sets BULKLEY_SCRIPTS and PATH
. "${BULKLEY_SCRIPTS:?is not set: load the module bulkley, or name the folder that holds job_functions.sh}/job_functions.sh"

begin_part pbs
# An Open MPI that was built for PBS finds the hosts itself. `qsig -s USR1` ends a part now.
ranks="$(wc -l <"$PBS_NODEFILE")"
launch mpirun -n "$ranks" "$program" run "$scene" --out "$folder" "${part_options[@]}" "${options[@]}"
end_part $?
