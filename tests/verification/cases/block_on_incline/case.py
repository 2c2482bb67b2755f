#!/usr/bin/env python3
"""A block on an incline: it slides by x = v_0 t + g t^2 (sin a - mu cos a) / 2, or sticks if mu > tan a."""

import math

from study import Study

G, ANGLE, START, HEIGHT = 9.81, math.radians(24.0), 0.3, 0.05
SLIDING, STICKING = math.tan(math.radians(15.0)), math.tan(math.radians(30.0))


def rows(run, column):
    history = run.history()
    return history["time_s"], history[column] - history[column][0]


def sets(cell, **more):
    return {"domain.cell_size": cell, "domain.upper": [0.7, cell, 0.1],
            "bodies.block.shape.upper": [0.25, cell, HEIGHT],
            "output.history_interval": 20, **more}


def slid(run):
    """Distance that gravity and friction have added to v_0 t, over its truth, less 1;
    the table begins after the first step."""
    times, path = rows(run, "center_of_mass_x_m")
    pull = G * (math.sin(ANGLE) - SLIDING * math.cos(ANGLE))
    first, time = times[0], times[-1]
    return (path[-1] - START * (time - first)) / (0.5 * pull * (time**2 - first**2)) - 1.0


def main():
    study = Study("block_on_incline", "Block on an incline",
                  "Coulomb friction: `x = v_0 t + g t^2 (sin a - mu cos a)/2`, `a` = 24 degrees, `mu` = tan 15 "
                  "degrees; at rest for "
                  "`mu` = tan 30 degrees")
    cells = (0.0125, 0.00625, 0.003125) if study.long else (0.0125, 0.00625)
    runs = [study.run_on_both(f"sliding_{1e3 * cell:g}mm", sets(cell)) for cell in cells]
    errors = [abs(slid(run)) for run in runs]
    study.expect_convergence("distance slid in 0.5 s", [HEIGHT / cell for cell in cells], errors, 1e-3, 0.8,
                             note="relative to what gravity and friction add to `v_0 t`")
    study.remark("The error in the distance is that of symplectic Euler for a constant force, `dt/t`; the time step "
                 "follows the cells.")
    for cell in cells[:2]:
        stuck = study.run_on_both(f"sticking_{1e3 * cell:g}mm", sets(cell, **{
            "bodies.block.velocity": [0.0, 0.0, 0.0], "boundaries.z_lower.friction": STICKING}))
        late = [x for t, x in zip(*rows(stuck, "center_of_mass_x_m")) if t >= 0.25]
        study.expect_at_most(f"creep of the sticking block from 0.25 s to 0.5 s, cells of {1e3 * cell:g} mm",
                             max(late) - min(late), 1e-8, "m")
    ringing = study.run("ringing", sets(cells[0], **{"transfer.scheme": "apic", "bodies.block.velocity": [0.0, 0.0, 0.0],
                                                     "boundaries.z_lower.friction": STICKING}))
    lift, creep = (rows(ringing, f"center_of_mass_{axis}_m")[1][-1] for axis in "zx")
    study.remark(f"With APIC (cells of {1e3 * cells[0]:g} mm) the sticking block keeps ringing from its first "
                 f"contact. A separating "
                 f"wall stops what comes down and lets go what comes up: ringing lifts the block by {1e3 * lift:.2f} "
                 f"mm in 0.5 s and "
                 f"lets it creep {1e3 * creep:.1f} mm downhill. Let an elastic body settle with PIC or with "
                 f"`affine_damping`.")

    def draw(axes):
        times, path = rows(runs[0], "center_of_mass_x_m")
        pull = G * (math.sin(ANGLE) - SLIDING * math.cos(ANGLE))
        axes.plot(times, 0.5 * pull * (times**2 - times[0]**2) + START * (times - times[0]), "k-", label="truth")
        axes.plot(times[::15], path[::15], ".", label="sliding, PIC")
        axes.plot(*rows(stuck, "center_of_mass_x_m"), label="sticking, PIC")
        axes.plot(*rows(ringing, "center_of_mass_x_m"), label="sticking, APIC")
        axes.set(xlabel="time [s]", ylabel="distance [m]")
        axes.legend()
    study.plot(draw, f"The block's path. Sticking with PIC: cells of {1e3 * cells[1]:g} mm; all else: "
                     f"{1e3 * cells[0]:g} mm.")
    study.finish()


if __name__ == "__main__":
    main()
