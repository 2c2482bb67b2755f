"""One message and exit code 2 for errors of the caller."""

import os
import sys

PROGRAM = os.path.basename(sys.argv[0]) if sys.argv and sys.argv[0].endswith(".py") else "open_run.py"


def fail(sentence):
    print(f"{PROGRAM}: {sentence}", file=sys.stderr)
    sys.stderr.flush()
    sys.exit(2)


def note(sentence):
    print(f"{PROGRAM}: {sentence}", file=sys.stderr)
