"""One sentence and exit code 2 for whatever the caller can put right."""

import sys


def fail(sentence):
    print(f"render.py: {sentence}", file=sys.stderr)
    sys.stderr.flush()
    sys.exit(2)


def note(sentence):
    print(f"render.py: {sentence}", file=sys.stderr)
