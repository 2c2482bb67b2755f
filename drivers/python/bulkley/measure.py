"""Measures what a finished run did: rebound, spreading, pieces, collision, spin.

    python3 -m bulkley measure rebound RUN                 fall, contact, jumps, from history.csv
    python3 -m bulkley measure spread RUN                  height and footprint over time, from the frames
    python3 -m bulkley measure pieces RUN                  how many pieces there are, and their masses
    python3 -m bulkley measure collision RUN               two bodies: distance, speed of separation, whether they joined
    python3 -m bulkley measure spin RUN... --plot FILE.png angular momentum and energies of several runs of one body

RUN is a run's output folder. Tables come in Markdown. What is measured, and how: docs/gallery/README.md, "How it is
measured". Needs numpy and h5py; --plot needs matplotlib.
"""

import argparse
import pathlib
import sys

import numpy as np

from bulkley.faults import DataError
from bulkley.markdown import markdown
from bulkley.pieces import bodies_of, cells_of, mass_share, nearest, pieces
from bulkley.run_folder import EndedRun

FREE = 0.1  # a body whose floor bears less than this part of its weight is in flight
WORTH_TELLING = 0.01  # of the mass: smaller pieces are counted as crumbs
TOP_SHARE = 0.995  # fraction of the particles below the reported height, which ignores flying drops
LAYERS = 1.5  # cells above the floor: what is lower touches it


# --- rebound --------------------------------------------------------------------------------------------------------------

def floor_force(history, gravity):
    """Force of the floor over the weight between two rows of the history, and the times between rows."""
    time, momentum, mass = history["time"], history["momentum_z"], history["mass"]
    weight = mass[:-1] * gravity
    return np.diff(momentum) / np.diff(time) / weight + 1.0, time


def stretches(free, time):
    """(free?, first row, last row) of stretches of intervals that are all free or all not."""
    ends = np.flatnonzero(np.diff(free.astype(int))) + 1
    edges = [0, *ends, len(free)]
    return [(bool(free[a]), a, b) for a, b in zip(edges, edges[1:])]


def flights_of(force, time, shortest):
    """(first row, last row) of stretches without contact that last at least `shortest`, those that begin or end the run
    included."""
    return [(a, b) for free, a, b in stretches(force < FREE, time) if free and time[b] - time[a] >= shortest]


def measure_rebound(run):
    """Facts of a drop as (name, number, unit), and the jumps as (start, duration, rise of the lowest point)."""
    if run.gravity <= 0.0:
        raise DataError(f"in '{run.folder}' gravity does not act downwards: nothing rebounds")
    history = run.history
    speed = history["momentum_z"] / history["mass"]
    height = history["center_of_mass_z"]
    force, time = floor_force(history, run.gravity)
    # A flight that lifts the body by less than a cell cannot be distinguished from oscillations at rest.
    shortest = 2.0 * np.sqrt(2.0 * run.cell_size / run.gravity)
    touching = np.flatnonzero(force >= FREE)
    if len(touching) == 0:
        raise DataError(f"in '{run.folder}' nothing touches the floor")
    impact = touching[0]
    facts = [("time of impact", time[impact], "s"), ("speed of impact", -speed[impact], "m/s"),
             ("largest force of the floor over the weight", force.max(), "")]
    flights = [flight for flight in flights_of(force, time, shortest) if flight[0] > impact]
    jumps = [(time[a], time[b] - time[a], history["lower_z"][a:b + 1].max() - run.floor) for a, b in flights]
    if flights:
        leave = flights[0][0]
        facts += [("time of contact", time[leave] - time[impact], "s"),
                  ("speed of leaving the floor", speed[leave], "m/s"),
                  ("speed of leaving over speed of impact", -speed[leave] / speed[impact], "")]
    low = impact + np.argmin(height[impact:(flights[0][1] if flights else len(height) - 1) + 1])
    facts += [("jumps", float(len(jumps)), ""),
              ("rebound: highest position of the lowest point above the floor",
               max((jump[2] for jump in jumps), default=0.0), "m"),
              ("rise of the centre of mass after its lowest position", height[low:].max() - height[low], "m"),
              ("height of the centre of mass above the floor at the end", height[-1] - run.floor, "m"),
              ("smallest volume ratio", history["min_volume_ratio"].min(), "")]
    return facts, jumps


def print_rebound(options):
    facts, jumps = measure_rebound(EndedRun(options.runs[0]))
    print(markdown(["fact", "value"], [[name, f"{value:.3g} {unit}".rstrip()] for name, value, unit in facts]))
    if jumps:
        print("\n" + markdown(["jump", "begins [s]", "lasts [s]", "lowest point up to [m]"],
                              [[str(n + 1), *(f"{value:.3f}" for value in jump)] for n, jump in enumerate(jumps)]))


# --- spread ---------------------------------------------------------------------------------------------------------------

def columns_area(position, size):
    """Area of the floor's columns of width `size` that hold a point."""
    return len(np.unique(cells_of(position[:, :2], size), axis=0)) * size**2


def measure_spread(run, frame):
    """Height of nearly all particles, area that touches the floor, area seen from above, width along x and y."""
    position = frame.positions
    above = position[:, 2] - run.floor
    touching = position[above < LAYERS * run.cell_size]
    return {"height": np.quantile(above, TOP_SHARE), "footprint": columns_area(touching, run.cell_size),
            "seen": columns_area(position, run.cell_size), "width": np.ptp(position[:, :2], axis=0)}


def print_spread(options):
    run = EndedRun(options.runs[0])
    rows = []
    for frame in nearest(run.frames, options.times or spaced(run)):
        found = measure_spread(run, frame)
        rows.append([f"{frame.time:.3f}", f"{found['height']:.4f}", f"{found['footprint'] * 1e4:.1f}",
                     f"{found['seen'] * 1e4:.1f}", f"{found['width'][0]:.3f} x {found['width'][1]:.3f}"])
    print(markdown(["time [s]", "height [m]", "on the floor [cm^2]", "seen from above [cm^2]", "width [m]"], rows))


def spaced(run):
    """Nine times over the run."""
    return np.linspace(0.0, run.frames[-1].time, 9)


# --- pieces ---------------------------------------------------------------------------------------------------------------

def measure_pieces(run, frame):
    """Shares of the mass of the pieces, largest first."""
    shares = np.bincount(pieces(frame.positions, run.cell_size), weights=mass_share(frame))
    return np.sort(shares)[::-1]


def print_pieces(options):
    run = EndedRun(options.runs[0])
    rows = []
    for frame in nearest(run.frames, options.times or spaced(run)):
        shares = measure_pieces(run, frame)
        large = shares[shares >= WORTH_TELLING]
        rows.append([f"{frame.time:.3f}", str(len(large)), ", ".join(f"{100 * share:.1f}" for share in large[:6]),
                     f"{100 * abs(1 - large.sum()):.2f}"])
    print(markdown(["time [s]", "pieces", "their fractions of the mass [%]", "crumbs [%]"], rows))


# --- collision ------------------------------------------------------------------------------------------------------------

def measure_collision(run, frame, bodies):
    """Distance of the two bodies' centres of mass, the speed at which it grows, and the fraction of each that is in the largest
    piece."""
    position, velocity = frame.positions, frame["velocity"].astype(float)
    ids, share, label = frame.ids, mass_share(frame), pieces(frame.positions, run.cell_size)
    centers, speeds, in_largest = [], [], []
    for body in bodies:
        own = np.isin(ids, body)
        weights = share[own] / share[own].sum()
        centers.append(weights @ position[own])
        speeds.append(weights @ velocity[own])
        in_largest.append(weights[label[own] == 0].sum())
    apart = centers[1] - centers[0]
    distance = np.linalg.norm(apart)
    return {"time": frame.time, "distance": distance, "parting": (speeds[1] - speeds[0]) @ apart / distance,
            "joined": min(in_largest)}


def print_collision(options):
    run = EndedRun(options.runs[0])
    frames = run.frames
    bodies = bodies_of(frames, run.cell_size)[:2]
    if len(bodies) < 2:
        raise DataError(f"in '{run.folder}' there are no two bodies apart from each other in the first frame")
    found = [measure_collision(run, frame, bodies) for frame in frames]
    closest = min(range(len(found)), key=lambda n: found[n]["distance"])
    approach, parting = -found[0]["parting"], max(state["parting"] for state in found[closest:])
    print(f"Speed of approach {approach:.3g} m/s, largest speed of separation afterwards {parting:.3g} m/s: "
          f"restitution {parting / approach:.3f}. Smallest distance of the centres {found[closest]['distance']:.4f} m "
          f"at {found[closest]['time']:.3f} s.\n")
    chosen = {frame.time for frame in nearest(frames, options.times or spaced(run))}
    rows = [[f"{state['time']:.3f}", f"{state['distance']:.4f}", f"{state['parting']:+.3f}", f"{100 * state['joined']:.1f}"]
            for state in found if state["time"] in chosen]
    print(markdown(["time [s]", "distance of the centres [m]", "growing at [m/s]", "of each body in one piece [%]"], rows))


# --- spin -----------------------------------------------------------------------------------------------------------------

def measure_spin(run):
    """Time; angular momentum about the centre of mass, along its first direction and over its first value; kinetic, elastic
    and total energy over the first kinetic one, without the motion of the centre of mass."""
    history = run.history
    center, linear, about_origin = (np.stack([history[f"{name}_{axis}"] for axis in "xyz"], axis=1)
                                    for name in ("center_of_mass", "momentum", "angular_momentum"))
    momentum = about_origin - np.cross(center, linear)
    start = momentum[0]
    scale = history["mass"][0] * max(history[f"upper_{axis}"][0] - history[f"lower_{axis}"][0] for axis in "xyz")
    if np.linalg.norm(start) <= 1e-9 * scale * history["max_speed"][0]:
        raise DataError(f"in '{run.folder}' nothing spins at the start")
    kinetic = history["kinetic_energy"] - 0.5 * (linear**2).sum(axis=1) / history["mass"]
    kinetic, elastic = kinetic / kinetic[0], history["elastic_energy"] / kinetic[0]
    return {"time": history["time"], "momentum": momentum @ start / (start @ start), "kinetic": kinetic, "elastic": elastic,
            "total": kinetic + elastic}


def print_spin(options):
    curves = {pathlib.Path(folder).name: measure_spin(EndedRun(folder)) for folder in options.runs}
    rows = []
    for name, curve in curves.items():
        lost = np.flatnonzero(curve["momentum"] < 0.5)
        rows.append([name, f"{curve['momentum'][-1] - 1.0:+.2e}", f"{curve['time'][lost[0]]:.3f}" if len(lost) else "never",
                     f"{curve['kinetic'][-1]:.4f}", f"{curve['total'].max():.4f}", f"{curve['total'][-1]:.4f}"])
    print(markdown(["run", "change of angular momentum", "half of it lost at [s]", "kinetic energy at the end",
                    "largest total energy", "total energy at the end"], rows))
    if options.plot:
        plot_spin(curves, options.plot)


def plot_spin(curves, path):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 3.6), constrained_layout=True)
    for name, curve in curves.items():
        left.plot(curve["time"], curve["momentum"], label=name)
        right.plot(curve["time"], curve["total"], label=name)
    left.set(xlabel="time [s]", ylabel="angular momentum over its first value", ylim=(0, None))
    right.set(xlabel="time [s]", ylabel="kinetic + elastic energy over the first", ylim=(0, None))
    left.legend(frameon=False)
    figure.savefig(path, dpi=100)


# --- command line ---------------------------------------------------------------------------------------------------------

COMMANDS = {"rebound": print_rebound, "spread": print_spread, "pieces": print_pieces, "collision": print_collision,
            "spin": print_spin}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=COMMANDS)
    parser.add_argument("runs", nargs="+", metavar="RUN", help="output folder of a run")
    parser.add_argument("--times", type=lambda text: [float(part) for part in text.split(",")], default=None,
                        help="times in s, separated by commas; default: nine over the run")
    parser.add_argument("--plot", type=pathlib.Path, help="picture to write (spin only)")
    options = parser.parse_args()
    if len(options.runs) > 1 and options.command != "spin":
        parser.error(f"{options.command} takes one run")
    return options


def main():
    options = parse_arguments()
    try:
        COMMANDS[options.command](options)
    except DataError as missing:
        print(f"measure: {missing}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
