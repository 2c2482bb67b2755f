"""What the tests of several hosts share: a scene, runs of it on hosts, and comparisons with the run on one rank."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
import hosts  # noqa: E402
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().parents[2] / "system" / "splash.toml"
LIMIT = 120.0  # s, for a run of a few seconds on a busy machine


def enter(description, add=lambda parser: None):
    """In namespaces: the arguments of the command line, the program, and an empty folder."""
    arguments = parse_arguments(description, add)
    hosts.enter()
    return (arguments, *start(arguments))


def checkpoint(step):
    return f"checkpoint_{step:09d}.h5"


class Runs:
    """Runs of the splash on `group`, a `Hosts`."""

    def __init__(self, program, work, group):
        self.program, self.work, self.group = program, work, group

    def run(self, layout, out, steps, *more, placement="slot"):
        """To step `steps` with layout[k] ranks on host k; `more`: words of the command line, or "key=value" for --set."""
        words = [part for word in more for part in (["--set", word] if "=" in word else [word])]
        arguments = ["run", str(SCENE), "--out", out, "--max-steps", str(steps), *words]
        outcome = self.group.run(layout, arguments, self.work, LIMIT, placement)
        if outcome.code != 0:
            fail(f"{out}: the run with {layout} ranks on the hosts ended with {outcome.code}", outcome)
        if f"{sum(layout)} ranks" not in outcome.text:
            fail(f"{out}: the run has not {sum(layout)} ranks", outcome)
        return outcome

    def expect_same(self, out, step, whole):
        """The particles of both runs at `step` are the same, bit for bit."""
        outcome = self.program.run(["compare", f"{whole}/{checkpoint(step)}", f"{out}/{checkpoint(step)}"], 1, self.work, LIMIT)
        if outcome.code != 0 or "identical" not in outcome.text:
            fail(f"{out} has not the bits of {whole}", outcome)
