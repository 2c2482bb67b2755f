#!/usr/bin/env python3
"""An elastic ball of 2 GPa bounces off a floor that can only push, with the implicit pressure; and a cylinder, which is plane."""

import numpy

from study import Study

CELL = 0.0125
REACH = 1.5 * CELL  # m, at which a particle feels the floor
CYLINDER = {
    "domain.upper": [0.35, 4 * CELL, 0.35], "boundaries.y_lower": "periodic", "boundaries.y_upper": "periodic",
    "bodies.ball.shape": {"type": "cylinder", "start": [0.175, 0.0, 0.125], "end": [0.175, 4 * CELL, 0.125], "radius": 0.1}}


def bounce(study, name, sets):
    history = study.run_on_both(name, sets).history()
    speed = history["momentum_z_kg_ms"] / history["mass_kg"]
    impact = speed.argmin()
    leap = impact + speed[impact:].argmax()
    clear = history["lower_z_m"][leap:].max()
    study.expect_at_most(f"{name}: floor's reach over the largest height of the lowest particle afterwards", REACH / clear, 0.99,
                         note="below 1 it has left the floor")
    study.expect_at_most(f"{name}: speed that is lost, over that of the impact", 1.0 + speed[leap] / speed[impact], 0.4)
    study.expect_at_most(f"{name}: speed that is gained, over that of the impact", max(0.0, -speed[leap] / speed[impact] - 1.0), 0.0)
    push = history["floorpressure_Pa"][1:]
    study.expect_at_most(f"{name}: largest pull of the floor over its largest push", max(0.0, -push.min()) / push.max(), 1e-12)
    study.remark(f"The {name} falls at {-speed[impact]:.3f} m/s and leaves at {speed[leap]:.3f} m/s, in {history['step'][-1]} "
                 f"steps with at most {history['contact_rounds'].max():g} and on average "
                 f"{history['contact_rounds'][1:].mean():.2f} solutions each; the mean volume ratio moves by "
                 f"{numpy.nanmax(history['volume_error']):.1e} at most.")


def main():
    study = Study("imex_bounce", "Bounce with an implicit pressure",
                  "An elastic ball leaves the floor with more than 0.6 of the speed of its impact; the plane prototype of the "
                  "method: 1.43 of 2.07 m/s")
    bounce(study, "ball", {})
    bounce(study, "cylinder", CYLINDER)
    study.finish()


if __name__ == "__main__":
    main()
