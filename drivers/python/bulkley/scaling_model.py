"""Predicts how runs scale: the cost of a step and of partitioning on ranks that are not available.

    bulkley partition SCENE -n 64,512,4096 --methods bisection --csv scene.csv
    python3 -m bulkley scaling-model scene.csv [more.csv] [--picture PICTURE.png] [constants of the machine]

The tables come in Markdown. What goes into them, and how far it has been checked: docs/scaling.md.
"""

import argparse
import csv
import math
import sys

import numpy as np

from bulkley.markdown import markdown

TILE_NODES = 64
BEYOND_INT = 2**31
ROOTLESS = ("bisection", "hilbert")  # no rank plans for all; the others work on the root

# name, default, unit, what it is: of the machine, of the program, of the scene.
CONSTANTS = [
    ("ranks-per-node", 128, "", "ranks on a node"),
    ("node-memory", 512e9, "B", "memory of a node"),
    ("node-bandwidth", 400e9, "B/s", "of a node's memory, all ranks together"),
    ("network-bandwidth", 25e9, "B/s", "of a node's link, each way"),
    ("inside-bandwidth", 3e9, "B/s", "of messages within a node, each rank"),
    ("latency", 2e-6, "s", "of a message between nodes, sender's and receiver's overhead included"),
    ("inside-latency", 0.6e-6, "s", "of a message within a node"),
    ("off-node", 1.0, "", "part of the halo that leaves the node; 1: ranks are placed without thought"),
    ("stage", 3e-6, "s", "of one of log2(ranks) stages of an all-reduce or a barrier"),
    ("root-receive", 3e-6, "s", "that the root takes for each rank's message when it gathers"),

    ("particle-time", 150e-9, "s", "of a particle and step on a core by itself (bulkley bench; cream, moment FLIP)"),
    ("particle-traffic", 883, "B", "to and from memory for each particle and step (docs/performance.md)"),
    ("particle-bytes", 255, "B", "of memory for each particle, nodes included (docs/performance.md)"),
    ("migrant-bytes", 209, "B", "of a particle that changes rank"),
    ("rebuild-time", 40e-9, "s", "of a rank's rebuild, for each of its particles"),
    ("step-syncs", 1, "", "collective calls of a step: the all-reduce"),
    ("cut-rounds", 3, "", "of histograms in the search for a cut (without a root)"),
    ("histogram-bytes", 12e3, "B", "of a message with the histograms of a region (without a root)"),
    ("cut-trials", 3, "", "trees that an imbalance check tries where the load is uneven (without a root)"),
    ("census-bytes", 24, "B", "that the root gathers for each loaded tile"),
    ("census-time", 10e-9, "s", "of a rank's census before a look, for each of its particles"),
    ("look-time", 5e-6, "s", "that an imbalance check takes on the root, for each loaded tile; 12e-6 if it tries changes"),
    ("root-tile-bytes", 800, "B", "of the root's memory for each loaded tile while METIS works"),
    ("root-box-bytes", 15, "B", "of the root's memory for each tile of the box while maps are made"),
    ("count-time", 35e-9, "s", "to count or seed a particle at the start; three times"),

    ("look-interval", 100, "steps", "smallest interval between imbalance checks (partition.decision_interval)"),
    ("look-share", 0.01, "", "of the time, that imbalance checks may take: expensive ones come less often"),
    ("map-interval", 1000, "steps", "between two complete repartitions"),
    ("particles-per-tile", 480, "", "in a loaded tile on average; 512 where 8 to a cell fill it"),
    ("box-ratio", 8, "", "tiles of the box for each loaded one"),
    ("cells-per-step", 0.1, "", "that the fastest particle crosses in a step"),
]


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", nargs="+", help="tables of bulkley partition --csv")
    parser.add_argument("--method", default="bisection", help="method whose rows are fitted, and whose maps and checks are counted "
                        "(default: bisection, which `auto` is in large runs)")
    parser.add_argument("--least-ranks", type=int, default=512, help="rows of fewer ranks are left out: parts of "
                        "many have less free surface (default: 512)")
    parser.add_argument("--fit-ranks", type=int, default=10**9, help="rows of more ranks are not fitted but predicted")
    parser.add_argument("--run", action="append", default=[], metavar="PARTICLES,RANKS",
                        help="predict this run; may be given several times")
    parser.add_argument("--picture", help="draw weak and strong scaling here (PNG)")
    for name, value, unit, meaning in CONSTANTS:
        parser.add_argument("--" + name, type=float, default=value, metavar=unit or "N",
                            help=f"{meaning} (default: {value:g})")
    return parser.parse_args()


def read_rows(paths, method, least_ranks, fit_ranks):
    """Rows of a method that it made itself, as numbers, and those of `ranges`, for the time that boxes take."""
    fitted, boxes = [], []
    for path in paths:
        with open(path, newline="", encoding="utf-8") as stream:
            for row in csv.DictReader(stream):
                if not row["chosen"] or row["chosen"] != row["method"]:
                    continue
                numbers = {name.split(" [")[0]: float(value) for name, value in row.items()
                           if name not in ("method", "chosen") and value}
                numbers["share"] = numbers["n_tiles"] / numbers["ranks"]
                numbers["file"] = path
                numbers["axis"] = max(numbers[f"cells_{a}"] for a in "xyz") / 4 + 1
                if row["method"] == "ranges":
                    boxes.append(numbers)
                if row["method"] == method and numbers["ranks"] >= least_ranks:
                    fitted.append(numbers)
    if sum(row["ranks"] <= fit_ranks for row in fitted) < 4:
        sys.exit(f"fewer than four rows of '{method}' with {least_ranks:g} to {fit_ranks:g} ranks: nothing to fit")
    return fitted, boxes


def non_negative_fit(matrix, values):
    """Least squares with coefficients >= 0: columns that would be negative are left out, the most negative first."""
    used = list(range(matrix.shape[1]))
    while True:
        found = np.linalg.lstsq(matrix[:, used], values, rcond=None)[0]
        if (found >= 0).all():
            result = np.zeros(matrix.shape[1])
            result[used] = found
            return result
        used.pop(int(np.argmin(found)))


def surface_terms(share):
    share = np.asarray(share, dtype=float)
    return np.stack([share ** (2 / 3), share ** (1 / 3), np.ones_like(share)], axis=-1)


class Laws:
    """What partitions make ranks do, as functions of tiles per rank and of ranks, fitted to counts."""

    def __init__(self, rows, boxes):
        column = {name: np.array([row[name] for row in rows]) for name in
                  ("share", "ranks", "n_tiles", "sent_mean", "sent_max", "neighbours_mean", "messages_mean",
                   "messages_max", "load_max_over_mean", "partition_time")}
        terms = surface_terms(column["share"])
        self.mean = non_negative_fit(terms / column["sent_mean"][:, None], np.ones(len(rows)))
        self.busiest = float(np.median(column["sent_max"] / column["sent_mean"]))
        self.messages_busiest = float(np.median(column["messages_max"]))
        self.messages = float(np.median(column["messages_mean"]))
        self.neighbours = float(np.median(column["neighbours_mean"]))
        uneven = column["load_max_over_mean"] > 1.021
        excess = (column["load_max_over_mean"] - 1) * column["share"]
        self.grain = float(np.median(excess[uneven])) if uneven.any() else 1.0
        boxes_of = {(row["file"], row["ranks"]): row["partition_time"] for row in boxes}
        self.parts_time = self.boxes_time = None
        pairs = [(row, boxes_of[row["file"], row["ranks"]]) for row in rows if (row["file"], row["ranks"]) in boxes_of]
        if len(pairs) >= 4:
            work = np.array([row["n_tiles"] * math.log2(row["ranks"]) for row, _ in pairs])
            ranks = np.array([row["ranks"] for row, _ in pairs])
            time = np.array([max(row["partition_time"] - box, 1e-4) for row, box in pairs])
            self.parts_time = non_negative_fit(np.stack([work, ranks], axis=1) / time[:, None], np.ones(len(pairs)))
            box = np.array([box for _, box in pairs])
            layers = np.array([row["axis"] for row, _ in pairs])
            logs = np.stack([np.ones(len(pairs)), np.log(ranks), np.log(layers)], axis=1)
            self.boxes_time = np.linalg.lstsq(logs, np.log(box), rcond=None)[0]

    def sent(self, share):
        """Mean bytes that a rank sends in a step."""
        return float(surface_terms(share) @ self.mean)

    def imbalance(self, share):
        """Largest over mean load: balancing stops at 1.02, and a tile is not divided."""
        return max(1.02, 1 + self.grain / share)

    def making(self, n_tiles, ranks, axis):
        """Seconds that the root takes for a complete repartition: the boxes and the parts."""
        if self.parts_time is None:
            return math.nan
        parts = self.parts_time @ np.array([n_tiles * math.log2(max(ranks, 2)), ranks])
        return float(parts + math.exp(self.boxes_time @ np.array([1.0, math.log(ranks), math.log(axis)])))


class Run:
    """One run: particles on ranks. Seconds of a step by cause, and bytes."""

    def __init__(self, laws, c, particles, ranks):
        self.particles, self.ranks = particles, ranks
        self.nodes = math.ceil(ranks / c.ranks_per_node)
        self.own = particles / ranks
        self.tiles = particles / c.particles_per_tile
        self.box = self.tiles * c.box_ratio
        axis = self.box ** (1 / 3)
        share = self.tiles / ranks
        on_node = min(ranks, c.ranks_per_node)
        stages = math.log2(ranks) if ranks > 1 else 0.0
        off = c.off_node if self.nodes > 1 else 0.0

        imbalance = laws.imbalance(share) if ranks > 1 else 1.0
        # The slower of a single core and its part of the node's memory bandwidth.
        self.per_particle = max(c.particle_time, c.particle_traffic * on_node / c.node_bandwidth)
        self.compute = self.own * self.per_particle
        self.uneven = self.compute * (imbalance - 1)

        message = off * c.latency + (1 - off) * c.inside_latency
        # What a rank sends in one half of the exchange it receives in the other; links carry both ways at once.
        sent = laws.sent(share) * laws.busiest if ranks > 1 else 0.0
        messages = laws.messages_busiest if ranks > 1 else 0.0
        self.sent = sent
        self.exchange = (2 * sent * ((1 - off) / c.inside_bandwidth) + sent * off * on_node / c.network_bandwidth
                         + messages * message)

        # Particles that cross the face ahead of them, all as fast as the fastest. Every neighbour gets a message, if an empty one.
        width = 4 * share ** (1 / 3)
        migrants = self.own * min(1.0, c.cells_per_step / width) if ranks > 1 else 0.0
        self.migrate = (migrants * c.migrant_bytes * (off * on_node / c.network_bandwidth
                        + 2 * (1 - off) / c.inside_bandwidth)
                        + (laws.neighbours * message if ranks > 1 else 0.0))
        self.sync = c.step_syncs * stages * c.stage
        # Among many ranks the fastest front always finds a new tile; a margin of one cell sets how often. A rank asks its neighbours,
        # and gets their answers.
        self.rebuild = c.cells_per_step * (self.own * c.rebuild_time * self.per_particle / c.particle_time
                                           + (2 * laws.neighbours * message if ranks > 1 else 0.0))

        self.rootless = c.method in ROOTLESS
        if ranks == 1:
            self.gather = self.judging = self.making = self.broadcast = 0.0
            self.map_bytes = 8.0
        elif self.rootless:
            self.together(c, stages, on_node)
        else:
            self.on_root(laws, c, stages, axis)
        look = self.gather + self.judging
        self.look_steps = max(c.look_interval, look / (c.look_share * self.compute))
        self.looks = look / self.look_steps
        self.maps = (self.making + self.broadcast) / c.map_interval

        # Memory: two maps while a new one is taken up; tables of the box around a rank's tiles.
        tables = 32 * share
        self.rank_memory = self.own * imbalance * c.particle_bytes + 2 * self.map_bytes + tables
        planning = 0.0 if self.rootless or ranks == 1 else self.tiles * c.root_tile_bytes + self.box * c.root_box_bytes
        self.root_memory = self.rank_memory + planning
        self.node_memory = on_node * self.rank_memory + planning
        self.count = 3 * self.own * c.count_time

    def on_root(self, laws, c, stages, axis):
        """Checks and maps by the root, for whom the others wait."""
        one_stream = min(c.network_bandwidth, 4 * c.inside_bandwidth)
        self.gather = self.tiles * c.census_bytes / one_stream + self.ranks * c.root_receive
        self.judging = self.tiles * c.look_time + self.own * c.census_time
        self.making = laws.making(self.tiles, self.ranks, axis)
        self.map_bytes = 4 * self.box
        self.broadcast = 2 * self.map_bytes / one_stream + stages * c.latency

    def together(self, c, stages, on_node):
        """Checks and maps by halving regions: stages (stages + 1) / 2 exchanges in each of a cut's rounds, at once on all ranks of a
        node; then all ranks get all cuts."""
        link = c.network_bandwidth / on_node if self.nodes > 1 else c.inside_bandwidth
        halvings = stages * (stages + 1) / 2
        self.gather = 0.0
        self.making = (((3 + c.cut_rounds) * halvings + 2 * stages) * c.stage
                       + c.cut_rounds * halvings * c.histogram_bytes / link)
        self.map_bytes = 8 * self.ranks
        self.broadcast = self.map_bytes / link + stages * c.latency
        self.judging = self.own * c.census_time + c.cut_trials * (self.making + self.broadcast)

    @property
    def stepping(self):
        return self.compute + self.uneven + self.exchange + self.migrate + self.sync + self.rebuild

    @property
    def step(self):
        return self.stepping + self.looks + self.maps


def seconds(value):
    if math.isnan(value):
        return "-"
    for unit, size in (("h", 3600.0), ("min", 60.0), ("s", 1.0), ("ms", 1e-3)):
        if value >= 0.995 * size * (10 if unit in ("h", "min") else 1):
            return f"{value / size:.3g} {unit}"
    return f"{value * 1e6:.3g} us"


def bytes_text(value):
    for unit, size in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if value >= 0.995 * size:
            return f"{value / size:.3g} {unit}"
    return f"{value:.3g} B"


def count_text(value):
    if value < 1000:
        return f"{value:.0f}"
    exponent = math.floor(math.log10(value) + 1e-9)
    factor = value / 10**exponent
    return f"10^{exponent}" if abs(factor - 1) < 0.005 else f"{factor:.2g} x 10^{exponent}"


def table(head, rows):
    print(markdown(head, rows) + "\n")


def print_fit(laws, rows, fit_ranks):
    print(f"Sent by a rank on average: {laws.mean[0]:.0f} w^(2/3) + {laws.mean[1]:.0f} w^(1/3) + {laws.mean[2]:.0f} bytes "
          f"a step, w loaded tiles a rank; the busiest {laws.busiest:.2f} times that, in {laws.messages_busiest:.0f} "
          f"messages. {laws.neighbours:.0f} neighbours. Largest over mean load max(1.02, 1 + {laws.grain:.2f} / w).\n")
    table(["file", "ranks", "tiles a rank", "sent, counted", "law", "law / counted", "fitted"],
          [[row["file"].rsplit("/", 1)[-1], f"{row['ranks']:.0f}", f"{row['share']:.3g}", bytes_text(row["sent_mean"]),
            bytes_text(laws.sent(row["share"])), f"{laws.sent(row['share']) / row['sent_mean']:.2f}",
            "yes" if row["ranks"] <= fit_ranks else "predicted"] for row in rows])
    if laws.parts_time is not None:
        table(["file", "ranks", "complete map, measured", "law", "law / measured", "fitted"],
              [[row["file"].rsplit("/", 1)[-1], f"{row['ranks']:.0f}", seconds(row["partition_time"]),
                seconds(laws.making(row["n_tiles"], row["ranks"], row["axis"])),
                f"{laws.making(row['n_tiles'], row['ranks'], row['axis']) / row['partition_time']:.2f}",
                "yes" if row["ranks"] <= fit_ranks else "predicted"] for row in rows])


PARTS = ["compute", "uneven", "exchange", "migrate", "sync", "rebuild", "looks", "maps"]


def print_runs(title, runs, efficiency):
    print(f"{title}\n")
    head = ["ranks", "particles", "a rank", *PARTS, "step", "efficiency", "of the steps alone"]
    lines = []
    for run in runs:
        all_in, without = efficiency(run)
        lines.append([count_text(run.ranks), count_text(run.particles), count_text(run.own),
                      *[seconds(getattr(run, part)) for part in PARTS], seconds(run.step),
                      f"{all_in:.2f}", f"{without:.2f}"])
    table(head, lines)


def print_division(runs):
    print("Time and memory of one imbalance check and one complete repartition.\n")
    table(["ranks", "particles", "loaded tiles", "gather", "decision", "steps between checks", "new map", "its broadcast",
           "map on each rank", "memory, rank", "root", "root's node", "count at start"],
          [[count_text(run.ranks), count_text(run.particles), count_text(run.tiles), seconds(run.gather),
            seconds(run.judging), count_text(run.look_steps), seconds(run.making), seconds(run.broadcast),
            bytes_text(run.map_bytes), bytes_text(run.rank_memory), bytes_text(run.root_memory),
            bytes_text(run.node_memory), seconds(run.count)] for run in runs])


def first_particles(holds_not, low=1e5, high=1e16):
    """The number of particles from which `holds_not` is true; it stays so."""
    if not holds_not(high):
        return math.inf
    for _ in range(100):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if holds_not(middle) else (middle, high)
    return high


def print_limits(laws, c, own):
    """Sizes at which something breaks, with a fixed number of particles a rank, smallest first."""
    def at(particles):
        return Run(laws, c, particles, max(2, particles / own))

    def of_step(seconds_of, part):
        return lambda n: seconds_of(at(n)) > part * at(n).stepping

    neighbours = 26.0
    limits = [
        ("checks are rarer than every 1000 steps", lambda n: at(n).look_steps > 1000),
        ("checks are rarer than every 10^4 steps", lambda n: at(n).look_steps > 10000),
        ("complete repartitions cost 10 % of the steps between them", of_step(lambda r: r.maps, 0.1)),
        ("a complete repartition takes 10 min", lambda n: at(n).making > 600),
        ("the map is half of what a rank has", lambda n: 2 * at(n).map_bytes > 0.5 * c.node_memory / c.ranks_per_node),
        ("a rank's memory is more than its part of the node",
         lambda n: at(n).rank_memory > c.node_memory / c.ranks_per_node),
        ("the root's node overflows", lambda n: at(n).node_memory > c.node_memory),
        ("the all-reduce is 10 % of a step", of_step(lambda r: r.sync, 0.1)),
        ("DMDA of 32-bit PETSc (grid frames only)", lambda n: at(n).box * TILE_NODES * 4 >= BEYOND_INT),
        ("METIS: neighbours of tiles in 32 bits", lambda n: not at(n).rootless and at(n).tiles * neighbours >= BEYOND_INT),
        ("TileIndex: tiles of the box in 32 bits", lambda n: at(n).box >= BEYOND_INT),
        ("ids: 64 for each cell and body in 63 bits, 100 bodies",
         lambda n: 100 * 64 * at(n).box * TILE_NODES >= 2.0**63),
    ]
    found = sorted((first_particles(test), name) for name, test in limits)
    print(f"{count_text(own)} particles a rank:\n")
    table(["particles", "ranks", "what breaks"],
          [["none up to 10^16", "", name] if math.isinf(n) else [count_text(n), count_text(max(2, n / own)), name]
           for n, name in found])


def draw(path, laws, c, weak, strong):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    ranks = np.logspace(0, 6, 121)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.4), dpi=110)
    styles = (("-", lambda run: run.stepping), ("--", lambda run: run.stepping + run.looks), (":", lambda run: run.step))
    for own, color in zip(weak, ("tab:blue", "tab:red")):
        base = Run(laws, c, own * c.ranks_per_node, c.ranks_per_node).stepping
        runs = [Run(laws, c, own * r, r) for r in ranks if r >= c.ranks_per_node]
        for style, time in styles:
            left.plot([run.ranks for run in runs], [base / time(run) for run in runs], style, color=color)
        left.plot([], [], color=color, label=f"{count_text(own)} particles a rank")
    left.set(xscale="log", xlabel="ranks", ylabel="weak efficiency, against the steps of one full node", ylim=(0, 1.05))
    for particles, color in zip(strong, ("tab:purple", "tab:orange", "tab:green")):
        runs = [Run(laws, c, particles, r) for r in ranks if 2e3 <= particles / r <= 3e7]
        for style, time in styles:
            right.plot([run.ranks for run in runs], [time(run) for run in runs], style, color=color)
        right.plot([run.ranks for run in runs], [run.compute for run in runs], color="0.7", linewidth=0.8, zorder=0)
        right.plot([], [], color=color, label=f"{count_text(particles)} particles")
    right.set(xscale="log", yscale="log", xlabel="ranks", ylabel="seconds a step", ylim=(1e-4, 1e2))
    right.plot([], [], color="0.7", linewidth=0.8, label="particles alone, evenly divided")
    for axes in (left, right):
        for style, text in (("-", "steps alone"), ("--", "and looks"),
                            (":", f"and a complete repartition every {c.map_interval:g}")):
            axes.plot([], [], style, color="0.3", label=text)
    for axes, place in ((left, "center right"), (right, "lower left")):
        axes.grid(which="major", color="0.9")
        axes.legend(fontsize=8, loc=place)
        axes.set_axisbelow(True)
    figure.tight_layout()
    figure.savefig(path)


def main():
    c = parse_arguments()
    rows, boxes = read_rows(c.csv, c.method, c.least_ranks, c.fit_ranks)
    laws = Laws([row for row in rows if row["ranks"] <= c.fit_ranks], [row for row in boxes if row["ranks"] <= c.fit_ranks])
    print(f"## What `{c.method}` makes ranks do\n")
    print_fit(laws, rows, c.fit_ranks)

    weak, strong = (1e5, 1e6), (1e8, 1e9, 1e11)
    if c.run:
        runs = [Run(laws, c, *map(float, text.split(","))) for text in c.run]
        print_runs("## Requested runs", runs, lambda run: (run.compute / run.step, run.compute / run.stepping))
        print_division(runs)
    print("## Weak scaling\n")
    for own in weak:
        one = Run(laws, c, own * c.ranks_per_node, c.ranks_per_node)
        runs = [Run(laws, c, own * r, r) for r in (c.ranks_per_node, 1e3, 1e4, 1e5, 1e6)]
        print_runs(f"{count_text(own)} particles a rank; efficiency against one full node.", runs,
                   lambda run, one=one: (one.stepping / run.step, one.stepping / run.stepping))
        print_division(runs)
    print("## Strong scaling\n")
    for particles in strong:
        runs = [Run(laws, c, particles, r) for r in (1e2, 1e3, 1e4, 1e5, 1e6) if 1e3 <= particles / r <= 2e8]
        print_runs(f"{count_text(particles)} particles; efficiency against the particles alone, evenly divided.", runs,
                   lambda run: (run.compute / run.step, run.compute / run.stepping))
    print("## What breaks, and where\n")
    for own in weak:
        print_limits(laws, c, own)
    if c.picture:
        draw(c.picture, laws, c, weak, strong)


if __name__ == "__main__":
    main()
