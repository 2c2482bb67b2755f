#!/usr/bin/env python3
"""A free ball as heavy as the fluid in a shear flow of 1/s: it spins at half that and goes nowhere."""

import numpy

from study import Study

RADIUS = 0.01


def main():
    study = Study("rigid_shear", "Free ball in shear flow", "Spin of a sphere in a slow shear flow: half of its rate, without walls")
    levels = (4, 6) if study.long else (4,)
    spins = []
    for cells in levels:
        history = study.run(f"cells_{cells}", {"domain.cell_size": RADIUS / cells}).history()
        late = history["time_s"] > 0.08
        spins.append(history["ballspin_y_rads"][late].mean())
        drift = max(numpy.abs(history[f"ballvelocity_{axis}_ms"][late]).max() for axis in "xyz")
        study.expect(f"spin, {cells} cells a radius", spins[-1], 0.5, 0.03, "rad/s", note="plates 5 radii away")
        study.expect_at_most(f"speed of the ball, {cells} cells a radius", drift / RADIUS, 0.02, note="over radius times rate")
    study.finish()


if __name__ == "__main__":
    main()
