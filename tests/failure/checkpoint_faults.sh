#!/usr/bin/env bash
# Damages checkpoints in hundreds of ways; each must be refused in one sentence, or be harmless (checkpoint_faults.py).
#   tests/failure/checkpoint_faults.sh [--all]
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
failure_test checkpoint_faults "$@"
