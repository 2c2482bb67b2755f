"""Runs of the implicit pressure on the scenes of tests/system, for tests that compare their particles."""

import pathlib

from bulkley_program import fail

SCENES = pathlib.Path(__file__).resolve().parents[1] / "system"


class ImexRuns:
    def __init__(self, program, work):
        self.program = program
        self.work = work

    def run(self, out, ranks, steps, scene, overrides, *more):
        """Runs `scene` to step `steps` into the folder `out` of the work folder. Returns the outcome; a run that fails ends the
        test."""
        sets = [word for override in ("time.integrator=imex", "output.history_interval=5", "output.frame_interval=0", *overrides)
                for word in ("--set", override)]
        outcome = self.program.run(["run", str(SCENES / scene), "--out", out, "--max-steps", str(steps), *sets, *more], ranks,
                                   self.work, 200)
        if outcome.code not in (0, 4):
            fail(f"{out} on {ranks} ranks ended with {outcome.code}", outcome)
        return outcome
