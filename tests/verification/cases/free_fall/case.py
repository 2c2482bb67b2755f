#!/usr/bin/env python3
"""Free fall: symplectic Euler gives y_n = y_0 + n v_0 dt - g dt^2 n (n + 1) / 2 for every particle and scheme."""

import numpy

from study import Study, scheme_name

G, STEP, VELOCITY = 9.81, 5e-4, (1.0, 0.0, 1.0)


def main():
    study = Study("free_fall", "Free fall", "Symplectic Euler by hand: `y_n = y_0 + n v_0 dt - g dt^2 n (n + 1) / 2`")
    start = study.run("start", {"time.end": STEP}, ranks=1).checkpoint()
    for scheme in ("pic", "flip", "apic", "moment_flip"):
        end = study.run_on_both(scheme, {"transfer.scheme": scheme}).checkpoint()
        error = 0.0
        for axis, gravity in ((0, 0.0), (1, 0.0), (2, G)):
            def position(n):
                return n * VELOCITY[axis] * STEP - 0.5 * gravity * STEP**2 * n * (n + 1)
            n = round(end["time"] / STEP)
            truth = start["position"][:, axis] - position(1) + position(n)
            error = max(error, numpy.abs(end["position"][:, axis] - truth).max())
        study.expect_at_most(f"position of any particle after 400 steps, {scheme_name(scheme)}", error, 1e-12, "m")
    study.finish()


if __name__ == "__main__":
    main()
