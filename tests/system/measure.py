#!/usr/bin/env python3
"""The tool `measure` of the Python package: what it finds in made-up runs whose facts are known, and in a real one."""

import math
import pathlib
import subprocess
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

DRIVERS = pathlib.Path(__file__).resolve().parents[2] / "drivers"
PACKAGE = DRIVERS / "python" / "bulkley"
sys.path.insert(0, str(PACKAGE.parent))
from bulkley import DataError, measure  # noqa: E402
from bulkley.pieces import bodies_of, pieces  # noqa: E402
from bulkley.run_folder import EndedRun  # noqa: E402

GRAVITY, CELL, FLOOR = 10.0, 0.01, 0.1


def expect(what, found, wanted, tolerance):
    if not abs(found - wanted) <= tolerance:
        fail(f"{what} is {found:g} and should be {wanted:g}")


class MadeUp:
    """A run without files."""

    def __init__(self, history=None):
        self.folder, self.cell_size, self.floor, self.gravity = pathlib.Path("made_up"), CELL, FLOOR, GRAVITY
        self.history = history


class MadeUpFrame:
    def __init__(self, position, **fields):
        self.time, self.positions, self._fields = 0.0, position, fields
        self.path = "made_up"

    def __contains__(self, name):
        return name in self._fields

    def __getitem__(self, name):
        return self._fields[name]

    @property
    def ids(self):
        return self["id"]


def block(lower, upper):
    """Points of a lattice of half a cell in a box."""
    axes = [np.arange(a + 0.25 * CELL, b, 0.5 * CELL) for a, b in zip(lower, upper)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


# --- made up --------------------------------------------------------------------------------------------------------------

def bounce(restitution, contact):
    """History of a ball that falls 0.45 m, is thrown back by a constant force over `contact` seconds, and flies once."""
    fall = math.sqrt(2 * 0.45 / GRAVITY)
    speed = GRAVITY * fall
    flight = 2 * restitution * speed / GRAVITY
    time = np.arange(0.0, fall + contact + flight + 0.2, 1e-4)
    begin, leave = fall, fall + contact
    velocity = np.select([time < begin, time < leave, time < leave + flight],
                         [-GRAVITY * time, -speed + (1 + restitution) * speed * (time - begin) / contact,
                          restitution * speed - GRAVITY * (time - leave)], 0.0)
    height = np.concatenate([[0.45], 0.45 + np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time))])
    ones = np.ones_like(time)
    return {"time": time, "mass": 2.0 * ones, "momentum_z": 2.0 * velocity, "center_of_mass_z": FLOOR + height,
            "lower_z": FLOOR + np.maximum(height, 0.0), "min_volume_ratio": 0.9 * ones}


def check_rebound():
    facts, jumps = measure.measure_rebound(MadeUp(bounce(0.5, 0.05)))
    found = {name: value for name, value, unit in facts}
    expect("the speed of impact", found["speed of impact"], 3.0, 0.01)
    expect("the time of contact", found["time of contact"], 0.05, 3e-4)
    expect("the restitution", found["speed of leaving over speed of impact"], 0.5, 0.01)
    expect("the number of jumps", len(jumps), 1, 0)
    # The ball sinks in by speed x contact x (1 - restitution) / 2 and leaves from below where it touched.
    sunk = 3.0 * 0.05 * (1 - 0.5) / 2
    expect("the height of the jump", jumps[0][2], 1.5**2 / (2 * GRAVITY) - sunk, 2e-3)
    lying = bounce(0.5, 0.05)
    lying["momentum_z"] = np.where(lying["time"] < 0.3, -20.0 * lying["time"], 0.0)
    facts, jumps = measure.measure_rebound(MadeUp(lying))
    if jumps:
        fail(f"what lies on the floor jumps: {jumps}")


def check_pieces():
    left, right = block((0, 0, 0), (0.1, 0.1, 0.1)), block((0.12, 0, 0), (0.16, 0.1, 0.1))
    apart = MadeUpFrame(np.concatenate([left, right]))
    shares = measure.measure_pieces(MadeUp(), apart)
    expect("the number of pieces", len(shares), 2, 0)
    expect("the share of the larger", shares[0], 100 / 140, 1e-12)
    bridge = MadeUpFrame(np.concatenate([left, right, [[0.105, 0.05, 0.05], [0.115, 0.06, 0.06]]]))
    expect("the number of pieces with a bridge", len(measure.measure_pieces(MadeUp(), bridge)), 1, 0)
    # A long crooked chain takes the search for roots several rounds.
    turn = np.linspace(0.0, 60.0, 40000)
    coil = np.stack([0.2 * np.cos(turn), 0.2 * np.sin(turn), 0.03 * turn / (2 * np.pi)], axis=1)
    label = pieces(np.random.default_rng(1).permutation(coil), CELL)
    expect("the number of pieces of a coil", label.max() + 1, 1, 0)


def check_spread():
    found = measure.measure_spread(MadeUp(), MadeUpFrame(block((0.2, 0.3, FLOOR), (0.4, 0.4, FLOOR + 0.05))))
    expect("the footprint", found["footprint"], 0.2 * 0.1, 1e-9)
    expect("the height", found["height"], 0.05, 0.5 * CELL)
    found = measure.measure_spread(MadeUp(), MadeUpFrame(block((0.2, 0.3, FLOOR + 0.03), (0.4, 0.4, FLOOR + 0.05))))
    expect("the footprint of a block in the air", found["footprint"], 0.0, 0.0)
    expect("the area seen from above", found["seen"], 0.2 * 0.1, 1e-9)


def check_collision():
    left, right = block((0, 0, 0), (0.1, 0.1, 0.1)), block((0, 0.2, 0), (0.1, 0.3, 0.1))
    ids = np.arange(len(left) + len(right))
    velocity = np.where(ids[:, None] < len(left), [0.0, 1.0, -1.0], [0.0, -2.0, -1.0])
    frame = MadeUpFrame(np.concatenate([left, right]), id=ids, velocity=velocity)
    bodies = bodies_of([frame], CELL)
    found = measure.measure_collision(MadeUp(), frame, bodies)
    expect("the distance", found["distance"], 0.2, 1e-9)
    expect("the speed", abs(found["parting"] + 3.0), 0.0, 1e-9)
    met = MadeUpFrame(np.concatenate([left, right - [0.0, 0.1, 0.0]]), id=ids, velocity=velocity)
    expect("the share of joined bodies", measure.measure_collision(MadeUp(), met, bodies)["joined"], 1.0, 1e-12)
    expect("the share of bodies apart", found["joined"], 0.0, 0.0)


def check_spin():
    time = np.linspace(0.0, 1.0, 11)
    # A body of 2 kg whose centre flies by at x = 5 m with 1 m/s along y: 10 kg m^2/s and 1 J that are not its spin.
    zero = 0.0 * time
    history = {"time": time, "mass": zero + 2.0, "kinetic_energy": 5.0 - 2.0 * time, "elastic_energy": time}
    history |= {"center_of_mass_x": zero + 5.0, "center_of_mass_y": time, "center_of_mass_z": zero}
    history |= {name: zero + 1.0 for name in ("upper_x", "upper_y", "upper_z", "max_speed")}
    history |= {name: zero for name in ("lower_x", "lower_y", "lower_z")}
    history |= {"momentum_x": zero, "momentum_y": zero + 2.0, "momentum_z": zero}
    history |= {"angular_momentum_x": zero, "angular_momentum_y": zero, "angular_momentum_z": 13.0 - time}
    found = measure.measure_spin(MadeUp(history))
    expect("the angular momentum at the end", found["momentum"][-1], 2 / 3, 1e-12)
    expect("the energy at the end", found["total"][-1], 0.75, 1e-12)
    history["angular_momentum_z"] = zero + 10.0
    try:
        measure.measure_spin(MadeUp(history))
        fail("a body that does not spin has a spin")
    except DataError:
        pass


# --- a real run -----------------------------------------------------------------------------------------------------------

def told(arguments):
    command = [sys.executable, str(PACKAGE), "measure", *map(str, arguments)]
    found = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    return found.returncode, found.stdout + found.stderr


def check_program(program, work):
    """A ball of rubber, coarse, falls and bounces; then all commands on that run."""
    scene = DRIVERS / "scenes" / "figure_8_colliding_balls.toml"
    out = work / "run"
    arguments = ["run", str(scene), "--out", str(out), "--quiet", "--set", "domain.cell_size=0.025",
                 "--set", "time.end=0.25", "--set", "output.history_interval=1"]
    outcome = program.run(arguments, 1, work, 120)
    if outcome.code != 0:
        fail(outcome.text)
    run = EndedRun(out)
    facts, _ = measure.measure_rebound(run)
    found = {name: value for name, value, unit in facts}
    # The floor is felt at most two cells above it.
    fall = run.history["lower_z"][0] - FLOOR
    slowest, fastest = (math.sqrt(1.0 + 2 * GRAVITY * height) for height in (fall - 2 * run.cell_size, fall))
    expect("the speed of impact", found["speed of impact"], 0.5 * (slowest + fastest), 0.5 * (fastest - slowest) + 0.01)
    for command, words in (("rebound", "speed of impact"), ("spread", "0.250"),
                           ("pieces", "| 0.000 | 2 | 50.3, 49.7 | 0.00 |"),
                           ("collision", "Speed of approach 8 m/s"), ("spin", "| run |")):
        code, text = told([command, out])
        if code != 0 or words not in text or "nan" in text:
            fail(f"measure {command} does not say '{words}': {text}")
    with h5py.File(run.frames[0].path, "r+") as file:
        del file["particles"]["id"]
    code, text = told(["collision", out])
    if code != 2 or "add it to output.fields" not in text:
        fail(f"a frame without ids: {text}")


def main():
    program, work = start(parse_arguments(__doc__))
    check_rebound()
    check_pieces()
    check_spread()
    check_collision()
    check_spin()
    check_program(program, work)
    print("the tool finds what is known of made-up runs, and measures a real one")


if __name__ == "__main__":
    main()
