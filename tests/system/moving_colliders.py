#!/usr/bin/env python3
"""Obstacles that move: the same bits on any number of ranks and through a restart between two rows of history.csv; forces and
torques that balance the momentum of the material; a time step that respects their speed."""

import csv
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("moving_colliders.toml")
OF_RANKS = {"imbalance", "repartitions", "moved_particles", "migrated_particles", "halo_bytes_largest [B]",
            "halo_bytes_mean [B]", "wall_time_per_step [s]"}


def rows(folder):
    with open(folder / "history.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def vectors(table, name, unit):
    return numpy.array([[float(row[f"{name}_{axis} [{unit}]"]) for axis in "xyz"] for row in table])


def check_balance(table, least_free=21):
    """Change of momentum = weight - forces; change of angular momentum = moment of the weight - torques, both about the origin.
    `least_free`: steps in which the rod touches nothing."""
    times = numpy.array([float(row["time [s]"]) for row in table])
    steps = numpy.diff(times)[:, None]
    mass = float(table[0]["mass [kg]"])
    weight = mass * numpy.array([0.0, 0.0, -10.0])
    middle = vectors(table, "center_of_mass", "m")[:-1]
    forces, torques = numpy.zeros_like(middle), numpy.zeros_like(middle)
    # Where the centres are at the start of each step: half-way through the bounds, moved along.
    turn = numpy.radians(10.0)
    turned = numpy.array([[numpy.cos(turn), -numpy.sin(turn), 0.0], [numpy.sin(turn), numpy.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    paddle = turned @ [0.31, 0.5, 0.45] + numpy.outer(times[:-1], [0.5, 0.0, 0.0])
    for name, center in (("paddle", paddle), ("stone", numpy.array([[0.72, 0.62, 0.45]]))):
        force = vectors(table, f"{name}.force", "N")[1:]
        forces += force
        torques += vectors(table, f"{name}.torque", "N m")[1:] + numpy.cross(numpy.broadcast_to(center, force.shape), force)
        if not numpy.abs(force).max() > 1.0:
            fail(f"the material never pushed {name}")
    rod = vectors(table, "rod.force", "N")[1:]
    momentum, angular = vectors(table, "momentum", "kg m/s"), vectors(table, "angular_momentum", "kg m^2/s")
    error = numpy.diff(momentum, axis=0) - (weight - forces - rod) * steps
    worst = numpy.abs(error).max() / numpy.abs(momentum).max()
    if not worst <= 1e-12:
        fail(f"forces do not balance the momentum: {worst:.3g} of its largest value in one step")
    free = numpy.abs(rod).max(axis=1) == 0.0  # the centre of the rod is not worked out here
    if not free.sum() >= least_free or free.all():
        fail(f"the rod touched the material in {(~free).sum()} of {len(free)} steps; the test wants some, not all")
    error = numpy.diff(angular, axis=0) - (numpy.cross(middle, weight) - torques) * steps
    worst_turn = numpy.abs(error[free]).max() / numpy.abs(angular).max()
    if not worst_turn <= 1e-12:
        fail(f"torques do not balance the angular momentum: {worst_turn:.3g} of its largest value in one step")
    if int(table[-1]["rejected_steps"]) == 0:
        fail("no step was refused; the test wants some, whose forces do not count")
    print(f"momentum balanced to {worst:.2g}, angular momentum to {worst_turn:.2g} of their largest values, in every step")


def main():
    program, work = start(parse_arguments(__doc__))

    def run(out, ranks, *more):
        outcome = program.run(["run", str(SCENE), "--out", out, *more], ranks, work, 120)
        if outcome.code != 0:
            fail(f"the run in {out} on {ranks} ranks ended with {outcome.code}", outcome)

    run("one", 1)
    table = rows(work / "one")
    check_balance(table)

    run("implicit", 1, "--set", "time.integrator=imex", "--set", "materials.fluid.bulk_modulus=2e9")
    check_balance(rows(work / "implicit"), least_free=10)  # its steps are longer

    n_steps = len(table) - 1
    sparse = ["--set", "output.history_interval=7"]
    run("sparse", 2, *sparse)
    run("parted", 5, *sparse, "--max-steps", str(n_steps // 2 // 7 * 7 + 3))
    run("parted", 3, *sparse, "--restart")
    last = f"checkpoint_{n_steps:09d}.h5"
    for out in ("sparse", "parted"):
        compare = program.run(["compare", f"one/{last}", f"{out}/{last}"], 1, work, 60)
        if compare.code != 0 or "identical" not in compare.text:
            fail(f"the run in {out} differs from that on one rank", compare)
    for one, other in zip(rows(work / "sparse"), rows(work / "parted"), strict=True):
        different = [name for name in one if name not in OF_RANKS and one[name] != other[name]]
        if different:
            fail(f"history.csv differs at step {one['step']} in {different}")
    # The mean force of a longer interval is the mean of its parts.
    whole = rows(work / "sparse")[3]
    parts = [row for row in table[1:] if int(rows(work / "sparse")[2]["step"]) < int(row["step"]) <= int(whole["step"])]
    lengths = numpy.diff([float(rows(work / "sparse")[2]["time [s]"])] + [float(row["time [s]"]) for row in parts])
    mean = (vectors(parts, "paddle.force", "N") * lengths[:, None]).sum(axis=0) / lengths.sum()
    if not numpy.allclose(mean, vectors([whole], "paddle.force", "N")[0], rtol=1e-10):
        fail(f"mean force {mean} of the steps is not that of the row, {vectors([whole], 'paddle.force', 'N')[0]}")

    run("fast", 2, "--set", "colliders.paddle.angular_velocity=[0,0,300]", "--set", "time.dt_initial=1e-3",
        "--set", "bodies.ball.shape.center=[0.3, 0.5, 0.8]", "--set", "bodies.ball.velocity=[0,0,0]", "--max-steps", "5")
    fast = rows(work / "fast")
    if not any(row["limiter"] == "collider" for row in fast):
        fail("a paddle whose ends run at 100 m/s never limits the time step")
    longest = max(float(row["dt [s]"]) for row in fast)
    if not longest <= 0.5 * 0.04 / (300.0 * 0.3):
        fail(f"a step of {longest} s, in which the end of the paddle crosses more than half a cell")
    print(f"{n_steps} steps, identical on 1, 2 and 5 + 3 ranks; a fast paddle limits the step to {longest:.3g} s")


if __name__ == "__main__":
    main()
