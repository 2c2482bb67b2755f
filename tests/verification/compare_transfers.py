#!/usr/bin/env python3
"""What transfers do to motions whose answer is known, with the step and with a half and a quarter of it.

    tests/verification/compare_transfers.py --program build/bulkley [--only NAME] [--work DIR]

Prints the table of docs/transfers.md, "Where the answer is known". Needs numpy and h5py; takes five minutes on one core.
"""

import argparse
import pathlib
import subprocess
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "cases"))
from study import Run  # noqa: E402

SCHEMES = ("moment_flip", "apic", "flip")
FACTORS = (0.4, 0.2, 0.1)  # elastic_cfl

RUBBER = """
[materials.material]
law = "neo_hookean"
density = 1000.0
bulk_modulus = 1e5
shear_modulus = 3e4
"""
CREAM = """
[materials.material]
preset = "cream"
bulk_modulus = 1e5
"""

# A bar between periodic sides, fixed at one end, in its first mode: ten periods of 4 L / c.
WAVE = """
gravity = [0.0, 0.0, 0.0]
domain = { lower = [0.0, 0.0, 0.0], upper = [30.0, 5.0, 5.0], cell_size = 1.25 }
time = { end = 100.0 }
[materials.material]
law = "neo_hookean"
density = 1.0
bulk_modulus = 40.0
shear_modulus = 45.0
[[bodies]]
name = "bar"
material = "material"
shape = { type = "box", lower = [0.0, 0.0, 0.0], upper = [25.0, 5.0, 5.0] }
velocity_field = ["0.1*sin(pi*x/50)", "0", "0"]
[boundaries]
x_lower = "slip"
x_upper = "open"
y_lower = "periodic"
y_upper = "periodic"
z_lower = "periodic"
z_upper = "periodic"
[output]
history_interval = 10
"""

# A disk of rubber turns twice.
SPIN = """
gravity = [0.0, 0.0, 0.0]
domain = { lower = [0.0, 0.0, 0.0], upper = [0.32, 0.32, 0.04], cell_size = 0.01 }
time = { end = 0.628 }
[[bodies]]
name = "disk"
material = "material"
shape = { type = "cylinder", start = [0.16, 0.16, 0.0], end = [0.16, 0.16, 0.04], radius = 0.1 }
angular_velocity = [0.0, 0.0, 20.0]
[boundaries]
x_lower = "open"
x_upper = "open"
y_lower = "open"
y_upper = "open"
z_lower = "periodic"
z_upper = "periodic"
[output]
history_interval = 10
""" + RUBBER

# A ball of rubber, eight cells a radius, meets a smooth floor at a fifth of its wave speed.
BOUNCE = """
gravity = [0.0, 0.0, 0.0]
domain = { lower = [0.0, 0.0, 0.0], upper = [0.2, 0.2, 0.2], cell_size = 0.00625 }
time = { end = 0.06 }
[[bodies]]
name = "ball"
material = "material"
shape = { type = "sphere", center = [0.1, 0.1, 0.065], radius = 0.05 }
velocity = [0.0, 0.0, -2.0]
[boundaries]
z_lower = { type = "separating", friction = 0.0 }
z_upper = "open"
[output]
history_interval = 10
""" + RUBBER

# Two such balls meet off their centres in free space.
COLLISION = """
gravity = [0.0, 0.0, 0.0]
domain = { lower = [0.0, 0.0, 0.0], upper = [0.3, 0.3, 0.2], cell_size = 0.00625 }
time = { end = 0.06 }
[[bodies]]
name = "left"
material = "material"
shape = { type = "sphere", center = [0.09, 0.13, 0.1], radius = 0.05 }
velocity = [1.0, 0.0, 0.0]
[[bodies]]
name = "right"
material = "material"
shape = { type = "sphere", center = [0.21, 0.17, 0.1], radius = 0.05 }
velocity = [-1.0, 0.0, 0.0]
[boundaries]
x_lower = "open"
x_upper = "open"
y_lower = "open"
y_upper = "open"
z_lower = "open"
z_upper = "open"
[output]
history_interval = 10
""" + RUBBER

# A layer between periodic sides; its weight comes in the first second and stays for five.
DEPTH, WIDTH, CELL, WEIGHT = 0.5, 0.2, 0.05, 9.81
REST = f"""
gravity = [0.0, 0.0, 0.0]
acceleration_field = ["0", "0", "-{WEIGHT}*min(t, 1)"]
domain = {{ lower = [0.0, 0.0, 0.0], upper = [{WIDTH}, {WIDTH}, 0.6], cell_size = {CELL} }}
time = {{ end = 6.0 }}
[[bodies]]
name = "layer"
material = "material"
shape = {{ type = "box", lower = [0.0, 0.0, 0.0], upper = [{WIDTH}, {WIDTH}, {DEPTH}] }}
lattice = "jittered"
[boundaries]
x_lower = "periodic"
x_upper = "periodic"
y_lower = "periodic"
y_upper = "periodic"
z_lower = "slip"
z_upper = "open"
[output]
frame_interval = 1.0
fields = ["velocity", "cauchy_stress", "id"]
"""


def energy_left(run):
    table = run.history()
    energy = table["kinetic_energy_J"] + table["elastic_energy_J"]
    return energy[-1] / energy[0]


def energy_and_spin(run):
    spin = run.history()["angular_momentum_z_kg_m2s"]
    return f"{energy_left(run):.4f}, {abs(spin[-1] / spin[0] - 1.0):.0e}"


def speed_left(run):
    momentum = run.history()["momentum_z_kg_ms"]
    return f"{-momentum[-1] / momentum[0]:.3f}"


def noise(run):
    """rms speed, mm/s; rms error of the vertical stress, % of that on the floor; rms way sideways in the last five seconds, cells."""
    frames = list(run.frames())
    loaded, end = frames[1], frames[-1]
    on_floor = WEIGHT * run.history()["mass_kg"][0] / WIDTH**2
    above = numpy.argsort(numpy.argsort(-end["position"][:, 2]))  # particles, alike in mass
    error = end["cauchy_stress"][:, 2, 2] / on_floor + (above + 0.5) / len(above)
    way = end["position"][:, :2] - loaded["position"][:, :2]
    way -= WIDTH * numpy.round(way / WIDTH)
    return f"{1e3 * rms(end['velocity']):.2g}, {100 * rms(error[:, None]):.2g}, {rms(way) / CELL:.2g}"


def rms(vectors):
    return numpy.sqrt(numpy.mean(numpy.sum(vectors**2, axis=1)))


CASES = {
    "Standing wave, 20 cells in a quarter of its length: energy left after ten periods": (WAVE, lambda run: f"{energy_left(run):.3f}"),
    "Disk of rubber after two turns: energy left, change of angular momentum": (SPIN, energy_and_spin),
    "Rubber ball on a smooth floor: speed of its centre after over before": (BOUNCE, speed_left),
    "Two rubber balls, off centre: energy left, change of angular momentum": (COLLISION, energy_and_spin),
    "Layer of rubber, five seconds at rest: rms speed in mm/s, error of the vertical stress in % of that on the floor, way sideways in cells":
        (REST + RUBBER, noise),
    "The same of cream": (REST + CREAM, noise),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, type=pathlib.Path, help="the program bulkley")
    parser.add_argument("--work", default="out/transfers", type=pathlib.Path, help="folder for the runs (default: out/transfers)")
    parser.add_argument("--only", default="", help="cases whose name contains this")
    arguments = parser.parse_args()
    chosen = {name: case for name, case in CASES.items() if arguments.only in name}
    if not chosen:
        sys.exit(f"no case contains '{arguments.only}'")
    arguments.work.mkdir(parents=True, exist_ok=True)
    for number, (name, (scene, measure)) in enumerate(chosen.items()):
        print(f"\n{name}\n\n| `elastic_cfl` | {' | '.join(map(str, FACTORS))} |\n|---|---|---|---|", flush=True)
        path = arguments.work / f"case_{number}.toml"
        path.write_text(f'title = "{name[:40]}"\n{scene}', encoding="utf-8")
        for scheme in SCHEMES:
            cells = []
            for factor in FACTORS:
                folder = arguments.work / f"{number}_{scheme}_{factor}"
                outcome = subprocess.run([arguments.program, "run", path, "--out", folder, "--overwrite", "--quiet", "--set",
                                          f"transfer.scheme={scheme}", "--set", f"time.elastic_cfl={factor}"],
                                         capture_output=True, text=True, check=False)
                if outcome.returncode != 0:
                    sys.exit(f"{name}, {scheme}, {factor}: {outcome.stdout}{outcome.stderr}")
                cells.append(measure(Run(folder, None)))
            print(f"| {scheme} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
