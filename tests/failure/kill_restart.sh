#!/usr/bin/env bash
# Kills runs with SIGKILL at random moments and restarts them; what they leave must equal an undisturbed run (kill_restart.py).
#   tests/failure/kill_restart.sh [--kills N] [--seed S] [--all] [--kills-per-run K] [--keep-files]
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
failure_test kill_restart "$@"
