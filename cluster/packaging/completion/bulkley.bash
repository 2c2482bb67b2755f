# Completion of bulkley for bash; made by `bulkley command-reference --format bash`.
# Where nothing is offered bash completes names of files.
_bulkley() {
  local word="${COMP_WORDS[COMP_CWORD]}" previous="${COMP_WORDS[COMP_CWORD - 1]}" command="${COMP_WORDS[1]}" words=""
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    words="run check partition info compare convert status report rheometer bench input-reference command-reference presets --help --version"
  else
    case "$command $previous" in
      "rheometer --mode") words="shear extension planar startup relaxation creep oscillation thixotropy magnetic" ;;
      "bench --scheme") words="pic flip blend apic moment_flip" ;;
      "bench --order") words="quadratic cubic" ;;
      "bench --gradient") words="mls bspline" ;;
      "bench --dilation") words="auto particle cell" ;;
      "bench --integrator") words="explicit imex" ;;
      "bench --only") words="floor cases sizes domain memory ranks cores imex field" ;;
      "command-reference --format") words="markdown man bash zsh" ;;
    esac
  fi
  if [[ -z "$words" && "$word" == -* ]]; then
    case "$command" in
      run) words="--set --out --restart --changed-scene --max-steps --max-walltime --overwrite --quiet --help" ;;
      check) words="--set -n --ranks --help" ;;
      partition) words="--set -n --ranks --methods --frame --before --ranks-per-node --csv --help" ;;
      info) words="--help" ;;
      compare) words="--tolerance --full --help" ;;
      convert) words="--to --out --fields --region --every --frames --help" ;;
      status) words="--watch --patience --json --help" ;;
      report) words="--out --help" ;;
      rheometer) words="--material --preset --set --mode --rates --stresses --amplitudes --frequencies --strain --duration --durations --pressure --field --fields --strain-per-step --largest-strain --tolerance --points --out --plot --fit --weights --fix --range --name --density --speed --help" ;;
      bench) words="--json --io --particles --material --steps --scheme --order --gradient --dilation --integrator --no-naive --no-one-rank --suite --small --only --help" ;;
      input-reference) words="--help" ;;
      command-reference) words="--format --help" ;;
      presets) words="--markdown --help" ;;
    esac
  fi
  if [[ -n "$words" ]]; then mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word"); fi
}
complete -o bashdefault -o default -F _bulkley bulkley
