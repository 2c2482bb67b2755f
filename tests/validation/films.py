"""Filmed dam breaks: the scene of a box, the reach of a run as the film's camera would see it, and its comparison with a
film."""

import math
from dataclasses import replace

import h5py
import numpy

from comparison import Plan, frames, measured, rounded, whole_cells

WALLS = 0.04         # m, between the side walls
FRAMES = 24.0        # per second, of the films
SHIFTS = numpy.arange(-0.010, 0.0301, 0.001)  # s, shifts of time that are allowed
MARGIN = 0.035       # s, that runs go on after the film's last frame
SOFTEST = 2.5e4      # Pa, bulk modulus of a box 2 cm high; in proportion to the height, which keeps the Mach number
SAVED = 120.0        # frames of a run per second
RATES = ("plastic_shear_rate", "volume_ratio", "reference_volume")  # fields that tell at which rates the law dissipates
# The gate of the films, where their frames show it: pulled up by hand at a nearly constant acceleration.
GATE_ACCELERATION = 40.0  # m/s^2
GATE_THICKNESS = 0.004    # m, of the collider: two cells of 2 mm
GATE_LIFT = 0.09          # m, then it stays
GATE_FRAMES = 12
# m, of the gate's lower edge at time 0, where a film shows it; that is half the height of the fluid by the rule of the films of 2023.
GATE_HEIGHTS = {"okonomiyaki_sauce_H46_W63": 0.005}


class Film:
    """A measured front."""

    def __init__(self, name):
        self.name = name
        columns, header = measured(name)
        self.time, self.reach, self.sigma = (columns[key] for key in ("time_s", "reach_m", "reach_sigma_m"))
        self.near_edge = columns["near_edge_m"]
        self.width, self.height = (float(header[key].split()[0]) for key in ("width", "height"))
        self.density = float(header["density"].split()[0])
        self.eye = numpy.array([float(word) for word in header["eye"].split()[:3]])
        self.gate_height = GATE_HEIGHTS.get(name, 0.5 * self.height)
        # The gates look at frames 3 to 8, the last of the films of 2023; for longer films the last frame is their own.
        self.judged = (self.time > 2.5 / FRAMES) & (self.time < 8.5 / FRAMES)

    @property
    def title(self):
        fluid, height, width = self.name.rsplit("_", 2)
        return f"{fluid.replace('_', ' ')} {height} {width}"


def plan(film, flow, cell, stiffness=1.0, transfer="", key=None):
    """The run of a film's box. `flow`: (yield stress, consistency, index); `cell`: m; `stiffness`: over the reference."""
    bulk = SOFTEST * film.height / 0.02 * stiffness
    wall = max(2.0 * cell, 0.0022)
    sets = {"domain.cell_size": cell,
            "domain.upper": [whole_cells(film.width + 1.3 * film.reach[-1] + 0.01, cell), 0.02, whole_cells(film.height + 0.01, cell)],
            "time.end": float(film.time[-1]) + MARGIN,
            "materials.sauce.density": film.density, "materials.sauce.bulk_modulus": bulk,
            "materials.sauce.shear_modulus": 0.1 * bulk, "materials.sauce.yield_stress": flow[0],
            "materials.sauce.consistency": flow[1], "materials.sauce.flow_index": flow[2],
            "bodies.fluid.shape.upper": [film.width, 0.02, film.height],
            "colliders.wall.shape.lower": [-0.01, -wall, -0.01],
            "colliders.wall.shape.upper": [film.width, 0.0, film.height + 0.02],
            "output.frame_interval": 1.0 / SAVED}
    facts = {"film": film.name, "cell": cell, "bulk_modulus": bulk, "flow": list(flow)}
    return Plan(key or f"{film.name}, {1e3 * cell:g} mm, kappa {bulk:g}", sets, facts, transfer)


def behind_gate(plan, film):
    """The run of `plan` behind a gate that is pulled up as the films' was, and to which the fluid sticks as to the other walls: the
    run begins when the gate leaves the floor. The gate leaves the domain, and takes along what it carries."""
    early = math.sqrt(2.0 * film.gate_height / GATE_ACCELERATION)
    lifted = math.sqrt(2.0 * GATE_LIFT / GATE_ACCELERATION)
    wall = -plan.sets["colliders.wall.shape.lower"][1]
    lines = ["", "[[colliders]]", 'name = "gate"', 'contact = "sticky"',
             f'shape = {{ type = "box", lower = [{film.width}, {-wall}, 0.0], '
             f"upper = [{film.width + GATE_THICKNESS}, 0.03, {film.height + 0.02}] }}"]
    for step in range(GATE_FRAMES + 1):
        time = lifted * step / GATE_FRAMES
        lines += ["[[colliders.key_frames]]", f"time = {time!r}",
                  f"translation = [0.0, 0.0, {0.5 * GATE_ACCELERATION * time**2!r}]"]
    sets = {**plan.sets, "time.end": plan.sets["time.end"] + early}
    return replace(plan, key=f"{plan.key}, gate", sets=sets, facts={**plan.facts, "gate": "sticky", "start": rounded(-early)},
                   addition="\n".join(lines) + "\n")


def shadow(points, eye):
    """Where the rays from `eye` (3,) through `points` (n, 3) meet the floor z = 0: (n, 2), m."""
    return points[:, :2] + (points[:, :2] - eye[:2]) * (points[:, 2] / (eye[2] - points[:, 2]))[:, None]


def front(run, film, cell, start=0.0):
    """Reach and near edge of every frame of `run` by the film's rules, m, with half the particle spacing for the surface.
    `start`: s, the film's time when the run begins."""
    half = 0.25 * cell
    found = {"time": [], "reach": [], "near_edge": []}
    for time, points in frames(run):
        mirrored = points * [1.0, -1.0, 1.0] + [0.0, WALLS, 0.0]
        thrown = shadow(numpy.concatenate([points, mirrored]), film.eye)
        beyond = thrown[:, 0] > film.width + 0.002
        found["time"].append(time + start)
        found["reach"].append(thrown[:, 0].max() + half - film.width)
        found["near_edge"].append(thrown[beyond, 1].max() + half - WALLS if beyond.any() else -WALLS)
    return found


def dissipated_above(run, flow, rate):
    """Part of the law's dissipation at shear rates above `rate`, 1/s, by the frames of `run`, whose fields are RATES."""
    yield_stress, consistency, index = flow
    power = {False: 0.0, True: 0.0}  # W times the number of frames
    for file in sorted(run.folder.glob("frame_*.h5")):
        with h5py.File(file, "r") as data:
            shear_rate, ratio, volume = (data["particles"][name][()].astype(float) for name in RATES)
        of_particles = ratio * volume * (yield_stress + consistency * shear_rate**index) * shear_rate
        for above in power:
            power[above] += float(of_particles[(shear_rate > rate) == above].sum())
    return power[True] / (power[True] + power[False])


def simulated(film, record, shift=0.0, of="reach"):
    """Reach, or the near edge, of a record at the film's times, `shift` later in the run, m."""
    return numpy.interp(film.time + shift, record["time"], record[of])


def best_shift(film, record):
    """The shift of time within SHIFTS that brings a record nearest to the film in units of its sigma."""
    costs = [numpy.sum(((simulated(film, record, shift) - film.reach) / film.sigma)**2) for shift in SHIFTS]
    return float(SHIFTS[int(numpy.argmin(costs))])


def errors(film, record, shift=0.0):
    """Largest error over frames 3 to 8, and the signed error of the last of them, over the film's reach then."""
    miss = (simulated(film, record, shift) - film.reach)[film.judged]
    scale = film.reach[film.judged][-1]
    return float(numpy.abs(miss).max() / scale), float(miss[-1] / scale)


def draw(axes, film, curves, title=""):
    """The film with bands of 1 and 2 sigma; `curves`: (record, label, style)."""
    for n, color in ((2, "0.92"), (1, "0.82")):
        axes.fill_between(film.time, 100 * (film.reach - n * film.sigma), 100 * (film.reach + n * film.sigma), color=color,
                          lw=0)
    axes.plot(film.time, 100 * film.reach, "ko", ms=4, label="film")
    for record, label, style in curves:
        axes.plot(record["time"], 100 * numpy.array(record["reach"]), label=label, **style)
    axes.set(xlabel="time [s]", ylabel="reach [cm]", title=title or film.title, xlim=(0, film.time[-1] + 0.03),
             ylim=(0, None))
    axes.legend(frameon=False, fontsize="small", loc="lower right")
