# Shell functions of the job scripts in cluster/jobs/slurm and cluster/jobs/pbs: whether a part of a run starts or continues, how long
# it may take, and whether another part must follow. To be sourced by bash, not run. docs/clusters.md describes them.
#
# A job script sets
#   folder        output folder of the run (bulkley run --out)
#   reserve       s of the job's time limit that are kept for starting, stopping and the batch system's coarse clock
#   max_walltime  optional: the bound of a part as bulkley takes it ("1h55m"), instead of the time limit less the reserve
#   after, script for PBS: what to submit when the run is finished, and what to submit for the next part
# and then calls
#   begin_part slurm          # or pbs; ends the job if nothing can or need be done, else sets the array part_options
#   launch srun ... bulkley run SCENE --out "$folder" "${part_options[@]}"      # or mpirun
#   end_part $?               # ends the job, after requesting the next part if one must follow
#
# The job's exit code is 0 if and only if the run is finished, so that --dependency=afterok works.

# hwloc must not look for GPUs through X servers: one that ends at that moment takes the launcher or a rank with it.
export HWLOC_COMPONENTS="${HWLOC_COMPONENTS:--gl}"
# Open MPI's daemons notice a host that is gone within two minutes, not eight. Once they have sent it something they notice
# nothing for a quarter of an hour, so this should be less than time.step_timeout.
export OMPI_MCA_oob_tcp_keepalive_time="${OMPI_MCA_oob_tcp_keepalive_time:-60}"
export OMPI_MCA_oob_tcp_keepalive_intvl="${OMPI_MCA_oob_tcp_keepalive_intvl:-10}"
export OMPI_MCA_oob_tcp_keepalive_probes="${OMPI_MCA_oob_tcp_keepalive_probes:-6}"

say() { echo "$(date '+%F %T') job ${job_id:-?}: $*"; }

# The job ends without another part.
give_up() {
  local code="$1"
  shift
  say "$*" >&2
  exit "$code"
}

# --- state of the output folder ---------------------------------------------------------------------------------------

# Value of a key of status.json, which holds one key a line; nothing if there is none. Compute nodes need not have Python.
status_value() {
  [[ ! -f "$folder/status.json" ]] || sed -n "s/^ *\"$1\": *//p" "$folder/status.json" | sed 's/,$//; s/^"//; s/"$//'
}

# Step of the newest checkpoint or stop; 0 if there is none.
status_step() {
  local step
  step="$(status_value step)"
  if [[ "$step" =~ ^[0-9]+$ ]]; then echo "$step"; else echo 0; fi
}

# The run failed, but only because a rank or a node did not answer: it can go on from its checkpoint.
is_unresponsive() { [[ "$(status_value state)" == failed && "$(status_value unresponsive)" == true ]]; }

has_checkpoint() { compgen -G "$folder/checkpoint_*.h5" >/dev/null; }

# parts.txt in the output folder has a line "DATE TIME chain C job J step S" for every part that began. A chain is what one
# submission leads to; Slurm's requeued jobs keep their id, PBS jobs that submit themselves hand the first id on.
last_job() { [[ ! -f "$folder/parts.txt" ]] || awk 'END {print $6}' "$folder/parts.txt"; }
of_chain() { [[ ! -f "$folder/parts.txt" ]] || awk -v chain="$chain" '$4 == chain' "$folder/parts.txt"; }
n_parts() { of_chain | wc -l; }

# How many parts of this chain, counted back from the last, began at the present step $1 or later: without progress.
n_fruitless() { of_chain | awk -v now="$1" '{n = ($8 >= now) ? n + 1 : 0} END {print n + 0}'; }

# One part may be lost with its node before its first checkpoint; two in a row have another cause.
expect_progress() {
  (($(n_fruitless "$1") < 2)) || give_up 1 "two parts in a row were ended and got no further than step $1: no third one"
}

# --- the batch system -------------------------------------------------------------------------------------------------

# Seconds of [DAYS-][HOURS:]MINUTES:SECONDS; nothing for words such as UNLIMITED.
seconds_of() {
  local days=0 clock="$1" part total=0
  [[ "$clock" =~ ^([0-9]+-)?[0-9]+(:[0-9]+)*$ ]] || return 0
  if [[ "$clock" == *-* ]]; then days="${clock%%-*}" clock="${clock#*-}"; fi
  for part in ${clock//:/ }; do total=$((total * 60 + 10#$part)); done
  echo $((total + 10#$days * 86400))
}

slurm_seconds_left() { seconds_of "$(squeue --noheader --jobs "$job_id" --format %L | tr -d ' ')"; }
slurm_is_running() { [[ "$(squeue --noheader --jobs "$1" --format %T 2>/dev/null)" == RUNNING ]]; }
# Under the same id, so that dependent jobs continue to wait. Slurm ends this script, and starts it again about two
# minutes later.
slurm_next_part() { scontrol requeue "$job_id"; }

# Torque and OpenPBS report the limit, but not reliably the time left; this script has begun with the job, or nearly.
pbs_seconds_left() {
  local limit
  limit="$(seconds_of "$(qstat -f "$job_id" | sed -n 's/^ *Resource_List.walltime = //p')")"
  [[ -z "$limit" ]] || echo $((limit - SECONDS))
}
pbs_is_running() { qstat -f "$1" 2>/dev/null | grep -q 'job_state = R'; }
# A job may not rerun itself (qrerun is for operators); a new one waits until this one is over.
pbs_next_part() { qsub -W depend=afterany:"$job_id" -v BULKLEY_CHAIN="$chain,BULKLEY_SCRIPTS=$BULKLEY_SCRIPTS" "$script"; }

# --- studies ----------------------------------------------------------------------------------------------------------

# Sets set_options to "--set WORD" for each word of line $2 of file $1; empty lines and lines that begin with # do not count.
set_options_of_line() {
  local words word
  [[ -f "$1" ]] || give_up 2 "there is no file $1"
  words="$(sed -E '/^[[:space:]]*(#|$)/d' "$1" | sed -n "$2p")"
  [[ -n "$words" ]] || give_up 2 "$1 has no line $2: --array asks for more runs than it has lines"
  set_options=()
  read -ra words <<<"$words"
  for word in "${words[@]}"; do set_options+=(--set "$word"); done
}

# --- the two ends of a part -------------------------------------------------------------------------------------------

# Sets part_options to --restart, --overwrite or neither.
choose_start() {
  part_options=()
  if has_checkpoint; then
    part_options=(--restart)
  elif [[ -f "$folder/parts.txt" && ( -f "$folder/status.json" || -f "$folder/history.csv" ) ]]; then
    case "$(status_value state)" in
      finished) say "the run in $folder is finished and has left no checkpoint: nothing to do"; exit 0 ;;
      # Ended before its first checkpoint, and begun by such a job: nothing in there can be continued.
      running | "") part_options=(--overwrite) ;;
      failed) if is_unresponsive; then part_options=(--overwrite); fi ;;
    esac
  fi  # else bulkley refuses a folder that is in use, and prints what can be done
}

# Adds --max-walltime to part_options.
choose_walltime() {
  local left
  if [[ -n "${max_walltime:-}" ]]; then
    part_options+=(--max-walltime "$max_walltime")
    return
  fi
  left="$("${batch}_seconds_left")"
  [[ -n "$left" ]] || { say "the job has no time limit that $batch would tell: no --max-walltime"; return; }
  ((left > reserve)) || give_up 2 "$left s are left of the time limit, of which $reserve s (reserve) are to be kept"
  part_options+=(--max-walltime "$((left - reserve))s")
}

begin_part() {
  batch="$1"
  if [[ "$batch" == slurm ]]; then
    # The last task of an array has the number of the whole array, which must not be queued again with it.
    job_id="${SLURM_ARRAY_JOB_ID:+${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}}"
    job_id="${job_id:-$SLURM_JOB_ID}" chain="$job_id"
  fi
  if [[ "$batch" == pbs ]]; then job_id="$PBS_JOBID" chain="${BULKLEY_CHAIN:-$PBS_JOBID}"; fi
  trap : USR1  # a signal that comes before or after the run must not end this script
  local earlier
  earlier="$(last_job)"
  if [[ -n "$earlier" && "$earlier" != "$job_id" ]] && "${batch}_is_running" "$earlier"; then
    give_up 1 "job $earlier is running in $folder: two at once would corrupt it"
  fi
  start_step="$(status_step)"
  if (($(n_parts) > 0)) && [[ "$(status_value state)" == failed ]] && ! is_unresponsive; then
    give_up 3 "the run in $folder has failed: $(status_value reason)"
  fi
  expect_progress "$start_step"
  choose_start
  choose_walltime
  mkdir -p "$folder" || give_up 2 "the output folder $folder cannot be made"
  echo "$(date '+%F %T') chain $chain job $job_id step $start_step" >>"$folder/parts.txt"
  say "part $(n_parts) of the run in $folder, from step $start_step: ${part_options[*]}"
}

# mpirun may wait for a node that is gone when all ranks it can reach have ended, and srun waits for a rank that neither runs nor ends.
# Watches process $1, and kills it a while after this part of the run has said that a rank does not answer.
end_if_unresponsive() {
  while sleep "${launcher_patience:-60}" && kill -0 "$1"; do
    if [[ ! "$folder/status.json" -nt "$folder/parts.txt" ]] || ! is_unresponsive; then continue; fi
    sleep "${launcher_patience:-60}"
    kill -KILL "$1"
  done
}

# Runs mpirun or srun, and ends it where a rank does not answer. Forwards SIGUSR1, which the batch system sends to the script where the
# ranks are mpirun's, also one that comes while the command is being started. Returns the command's exit code.
launch() {
  local pid="" signalled="" code guard
  trap 'signalled=yes; [[ -z "$pid" ]] || kill -USR1 "$pid" 2>/dev/null' USR1
  "$@" &
  pid=$!
  end_if_unresponsive "$pid" >/dev/null 2>&1 &
  guard=$!
  [[ -z "$signalled" ]] || kill -USR1 "$pid" 2>/dev/null
  wait "$pid"
  code=$?
  while kill -0 "$pid" 2>/dev/null; do  # it was the trap that ended the wait
    wait "$pid"
    code=$?
  done
  kill "$guard" 2>/dev/null
  trap : USR1
  return "$code"
}

forward_signal() { launch "$@"; }  # its name in scripts of earlier versions

finish() {
  say "finished at step $1"
  if [[ -n "${after:-}" ]]; then qsub "$after" || give_up 1 "$after could not be submitted"; fi  # PBS alone
  exit 0
}

next_part() {
  "${batch}_next_part" || give_up 1 "$batch refused; submit this script again to continue"
  exit 4
}

end_part() {
  local code="$1" state step
  state="$(status_value state)"
  step="$(status_step)"
  ((code != 2)) || give_up 2 "bulkley refused its input (exit code 2): no further part"
  if is_unresponsive; then
    # Its last step may be older than that of its checkpoint: what counts is whether parts begin further on.
    expect_progress "$step"
    say "$(status_value reason): another part is to follow"
    next_part
  fi
  ((code != 3)) || give_up 3 "the run failed (exit code 3): no further part"
  case "$state" in
    finished)
      # An old status.json has the same state if a prolonged run was killed at once.
      if ((code == 0 || step > start_step)); then finish "$step"; fi
      ;;
    failed) give_up 3 "the run failed at step $step: no further part" ;;
    stopped)
      ((step > start_step)) || give_up 1 "this part stopped at step $step, where it had begun: no further part"
      [[ "$(status_value reason)" != "by the file "* ]] ||
        give_up 4 "stopped at step $step by the file STOP: no further part; submit this script again to continue"
      ;;
  esac
  # Also with exit code 0: srun ends so when a node was lost.
  expect_progress "$step"
  say "exit code $code, status.json says '$state', step $start_step -> $step: another part is to follow"
  next_part
}
