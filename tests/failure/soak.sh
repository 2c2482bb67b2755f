#!/usr/bin/env bash
# A long run in many parts on changing numbers of ranks: mass, particles, memory, open files and bits (soak.py).
#   tests/failure/soak.sh [--steps 40000] [--parts 40]
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
failure_test soak "$@"
