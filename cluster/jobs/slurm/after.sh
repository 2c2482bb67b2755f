#!/bin/bash
# What is to be done with finished runs, once all parts of all of them are over:
#     job=$(sbatch --parsable srun.sh)        # or study.sh
#     sbatch --dependency=afterok:$job --kill-on-invalid-dep=yes after.sh out/scene   # of a study: out/study/*
# A run that failed or gave up does not end with 0: then this job is removed from the queue.

#SBATCH --job-name=after
#SBATCH --ntasks=1
#SBATCH --time=01:00:00
#SBATCH --output=%x-%j.log

# module load bulkley             # sets BULKLEY_SHARE
process() {
  xvfb-run -a pvpython "$BULKLEY_SHARE/paraview/render.py" --run "$1" --output "$1/last.png"
}

code=0
for folder in "$@"; do
  process "$folder" || { echo "$folder: exit code $?" >&2; code=1; }
done
exit $code
