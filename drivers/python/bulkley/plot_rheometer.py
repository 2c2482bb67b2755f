"""Draws a table of `bulkley rheometer`, which calls this for --plot.

    python3 -m bulkley plot-rheometer --kind MODE --title TEXT TABLE.csv PICTURE.png

MODE is a mode of the rheometer, or "fit". "-" instead of a file is standard input or output.
"""

import argparse
import csv
import io
import logging
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # what it says of its caches is of no use to readers

MEASURED = {"linestyle": "none", "marker": "o", "markersize": 5, "markerfacecolor": "none", "markeredgewidth": 1.2}
THEORY = {"color": "0.25", "linewidth": 1.2, "linestyle": "--", "zorder": 1}


class Table:
    """Columns of numbers by name."""

    def __init__(self, path):
        with io.TextIOWrapper(sys.stdin.buffer, "utf-8") if path == "-" else open(path, newline="", encoding="utf-8") as stream:
            self.rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(stream)]
        if not self.rows:
            sys.exit(f"{path}: holds no rows")

    def has(self, name):
        return name in self.rows[0]

    def __getitem__(self, name):
        return [row[name] for row in self.rows]

    def groups(self, name):
        """(value, table of the rows that have it), in the order of the file."""
        found = {}
        for row in self.rows:
            found.setdefault(row[name], []).append(row)
        for value, rows in found.items():
            part = Table.__new__(Table)
            part.rows = rows
            yield value, part


def logarithmic(values):
    """Whether a logarithmic axis suits the values: all above 0, and not all equal."""
    return min(values) > 0 and max(values) > 3 * min(values)


def scale(axis, x, y):
    """Logarithmic axes where all values allow it."""
    axis.set_xscale("log" if logarithmic(x) else "linear")
    axis.set_yscale("log" if logarithmic(y) else "linear")
    if not logarithmic(y) and min(y) >= 0:
        axis.set_ylim(0, 1.1 * max(y) or 1)


def theory_behind(axis, table, x, columns):
    for column, label, style in columns:
        if table.has(column):
            axis.plot(table[x], table[column], label=label, **{**THEORY, **style})


def draw_steady(table, figure, rate, rate_label, stress, stress_label, viscosity, viscosity_label):
    left, right = figure.subplots(1, 2)
    left.plot(table[rate], table[stress], label="kernel", **MEASURED)
    theory_behind(left, table, rate, [("analytic_stress", "analytic, finite elastic strain", {}),
                                      ("small_strain_stress", "small elastic strain", {"linestyle": ":"})])
    unsteady = [row for row in table.rows if row["steady"] == 0]
    if unsteady:
        left.plot([row[rate] for row in unsteady], [row[stress] for row in unsteady], "x", color="C3", label="not steady")
    second = []
    if table.has("first_normal_stress_difference") and min(table["first_normal_stress_difference"]) > 0:
        second = table["first_normal_stress_difference"]
        left.plot(table[rate], second, label="$N_1$", color="C1", **{**MEASURED, "marker": "s"})
    scale(left, table[rate], table[stress] + second)
    left.set(xlabel=rate_label, ylabel=stress_label.replace(" [", ", $N_1$ [") if second else stress_label)
    left.legend(frameon=False, fontsize="small")
    right.plot(table[rate], table[viscosity], color="C2", **MEASURED)
    if table.has("analytic_stress"):
        right.plot(table[rate], [s / r for s, r in zip(table["analytic_stress"], table[rate])], **THEORY)
    scale(right, table[rate], table[viscosity])
    right.set(xlabel=rate_label, ylabel=viscosity_label)
    return [left, right]


def draw_shear(table, figure):
    return draw_steady(table, figure, "shear_rate", "shear rate [1/s]", "shear_stress", "shear stress [Pa]", "viscosity",
                       "viscosity [Pa s]")


def draw_curves(table, figure, rate, stress, stress_label, strain_label):
    """Stress over strain, one curve a rate."""
    axis = figure.subplots()
    normal = "first_normal_stress_difference"
    for k, (value, part) in enumerate(table.groups(rate)):
        axis.plot(part["strain"], part[stress], color=f"C{k % 10}", label=f"{value:g} 1/s")
        if part.has(normal):
            axis.plot(part["strain"], part[normal], color=f"C{k % 10}", linewidth=1, linestyle="-.",
                      label="$N_1$" if k == 0 else None)
        theory_behind(axis, part, "strain", [("analytic_stress", "analytic" if k == 0 else None, {"zorder": 3})])
    axis.set(xlabel=strain_label, ylabel=stress_label)
    axis.legend(frameon=False, fontsize="small")
    return [axis]


def draw_extension(table, figure):
    if not table.has("steady"):
        return draw_curves(table, figure, "extension_rate", "tensile_stress", "tensile stress [Pa]", "Hencky strain")
    return draw_steady(table, figure, "extension_rate", "extension rate [1/s]", "tensile_stress", "tensile stress [Pa]",
                       "extensional_viscosity", "extensional viscosity [Pa s]")


def draw_startup(table, figure):
    return draw_curves(table, figure, "shear_rate", "shear_stress", "stress [Pa]", "shear strain")


def draw_relaxation(table, figure):
    axis = figure.subplots()
    axis.plot(table["time"], table["relaxation_modulus"], label="kernel", **{**MEASURED, "markersize": 3})
    if table.has("analytic_stress"):
        modulus = [s / g for s, g in zip(table["analytic_stress"], table["strain"])]
        axis.plot(table["time"], modulus, label="analytic", **THEORY)
    scale(axis, table["time"], table["relaxation_modulus"])
    if axis.get_yscale() == "log":
        top = max(table["relaxation_modulus"])
        axis.set_ylim(max(0.5 * min(table["relaxation_modulus"]), 1e-6 * top), 2 * top)
    axis.set(xlabel="time after the step [s]", ylabel="relaxation modulus [Pa]")
    axis.legend(frameon=False, fontsize="small")
    return [axis]


def draw_creep(table, figure):
    left, right = figure.subplots(1, 2)
    smallest_rate = 1e-12  # 1/s; a specimen at rest has rates of rounding only
    for k, (stress, part) in enumerate(table.groups("shear_stress")):
        left.plot(part["time"], part["strain"], color=f"C{k % 10}", label=f"{stress:g} Pa")
        theory_behind(left, part, "time", [("analytic_strain", None, {"zorder": 3})])
        moving = [(row["time"], row["shear_rate"]) for row in part.rows if row["shear_rate"] > smallest_rate]
        if moving:
            right.plot(*zip(*moving), color=f"C{k % 10}", label=f"{stress:g} Pa")
        if part.has("analytic_steady_rate") and part["analytic_steady_rate"][0] > 0:
            right.axhline(part["analytic_steady_rate"][0], **THEORY)
    if table.has("analytic_strain"):
        left.plot([], [], label="analytic", **THEORY)
    left.set(xlabel="time [s]", ylabel="shear strain", xscale="log")
    left.set_yscale("log" if logarithmic(table["strain"]) else "linear")
    right.set(xlabel="time [s]", ylabel="shear rate [1/s]", xscale="log", xlim=left.get_xlim())
    if left.get_yscale() == "linear":
        left.set_ylim(bottom=0)
    left.legend(frameon=False, fontsize="small")
    if any(rate > smallest_rate for rate in table["shear_rate"]):
        right.set_yscale("log")
        if table.has("analytic_steady_rate"):
            right.plot([], [], label="steady, analytic", **THEORY)
        right.legend(frameon=False, fontsize="small")
    else:
        right.set(ylim=(-1, 1), yticks=[0])
        right.text(0.5, 0.6, "at rest", ha="center", transform=right.transAxes)
    return [left, right]


def draw_oscillation(table, figure):
    amplitudes = list(table.groups("strain_amplitude"))
    sweeps_amplitude = len(amplitudes) > len(list(table.groups("angular_frequency")))
    x, by, x_label, legend = (("strain_amplitude", "angular_frequency", "strain amplitude", "{:g} rad/s") if sweeps_amplitude
                              else ("angular_frequency", "strain_amplitude", "angular frequency [rad/s]", "amplitude {:g}"))
    left, right = figure.subplots(1, 2)
    largest = max(table["storage_modulus"] + table["loss_modulus"])
    for k, (value, part) in enumerate(table.groups(by)):
        color = f"C{k % 10}"
        for column, symbol, marker in (("storage_modulus", "$G'$", "o"), ("loss_modulus", "$G''$", "s")):
            points = [(a, b) for a, b in zip(part[x], part[column]) if b > 1e-9 * largest]
            if points:
                label = f"{symbol}, {legend.format(value)}"
                left.plot(*zip(*points), color=color, label=label, **{**MEASURED, "marker": marker})
            if part.has("analytic_" + column) and max(part["analytic_" + column]) > 0:
                left.plot(part[x], part["analytic_" + column], **THEORY)
        right.plot(part[x], part["third_harmonic"], color=color, marker="o", label=legend.format(value))
    left.set(xscale="log", yscale="log", xlabel=x_label, ylabel="storage and loss modulus [Pa]")
    right.set(xscale="log", xlabel=x_label, ylabel="third harmonic of the stress over its first")
    right.set_ylim(bottom=0, top=max(0.02, 1.1 * max(table["third_harmonic"])))
    for axis in (left, right):
        axis.legend(frameon=False, fontsize="small")
    return [left, right]


def draw_thixotropy(table, figure):
    panels = figure.subplots(2 if table.has("structure") else 1, 1, sharex=True, squeeze=False)[:, 0]
    panels[0].plot(table["time"], table["shear_stress"], label="shear stress")
    theory_behind(panels[0], table, "time", [("analytic_steady_stress", "steady flow, analytic", {})])
    panels[0].set_ylabel("shear stress [Pa]")
    if table.has("structure"):
        panels[1].plot(table["time"], table["structure"], color="C2")
        panels[1].set(ylabel="structure", ylim=(0, 1.05))
    for axis in panels:
        for _, part in list(table.groups("interval"))[:-1]:
            axis.axvline(part["time"][-1], color="0.7", linewidth=0.8)
    top = panels[0].get_ylim()[1]
    panels[0].set_ylim(bottom=min(0, panels[0].get_ylim()[0]), top=1.1 * top)
    for _, part in table.groups("interval"):
        middle = 0.5 * (part["time"][0] + part["time"][-1])
        panels[0].text(middle, 1.04 * top, f"{part['shear_rate'][0]:g} 1/s", ha="center", fontsize="small")
    panels[0].legend(frameon=False, fontsize="small")
    panels[-1].set_xlabel("time [s]")
    return list(panels)


def draw_magnetic(table, figure):
    left, right = figure.subplots(1, 2)
    field = [0.001 * h for h in table["magnetic_field_strength"]]
    rate = table["shear_rate"][0]
    left.plot(field, table["shear_stress"], label=f"kernel, {rate:g} 1/s", **MEASURED)
    if table.has("yield_stress"):
        left.plot(field, table["yield_stress"], label="yield stress", **THEORY)
    left.legend(frameon=False, fontsize="small")
    right.plot(field, [0.001 * m for m in table["magnetisation"]], color="C1")
    for axis, label in ((left, "shear stress [Pa]"), (right, "magnetisation [kA/m]")):
        axis.set(xlabel="magnetic field strength H [kA/m]", ylabel=label)
    left.set_ylim(bottom=0)
    right.set_ylim(bottom=0)
    return [left, right]


def draw_fit(table, figure):
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
    points = sorted(table.rows, key=lambda row: row["shear_rate"])
    rates = [row["shear_rate"] for row in points]
    upper.loglog(rates, [row["stress"] for row in points], label="measured", **MEASURED)
    upper.loglog(rates, [row["fitted_stress"] for row in points], label="fit", **{**THEORY, "linestyle": "-"})
    upper.set_ylabel("shear stress [Pa]")
    upper.legend(frameon=False)
    lower.axhline(0, color="0.25", linewidth=1)
    lower.plot(rates, [100 * row["relative_residual"] for row in points], color="C1", **MEASURED)
    lower.set(xlabel="shear rate [1/s]", ylabel="residual [%]")
    return [upper, lower]


DRAWERS = {"shear": draw_shear, "extension": draw_extension, "planar": draw_extension, "startup": draw_startup,
           "relaxation": draw_relaxation, "creep": draw_creep, "oscillation": draw_oscillation,
           "thixotropy": draw_thixotropy, "magnetic": draw_magnetic, "fit": draw_fit}
TWO_PANELS = {"shear", "creep", "oscillation", "magnetic"}
NAMES = {"shear": "flow curve", "extension": "uniaxial extension", "planar": "planar extension",
         "startup": "start-up of shear", "relaxation": "stress relaxation", "creep": "creep",
         "oscillation": "oscillatory shear", "thixotropy": "three intervals of shear rate",
         "magnetic": "in a magnetic field"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", required=True, choices=DRAWERS)
    parser.add_argument("--title", default="")
    parser.add_argument("table")
    parser.add_argument("picture")
    arguments = parser.parse_args()

    table = Table(arguments.table)
    wide = arguments.kind in TWO_PANELS or (arguments.kind in ("extension", "planar") and table.has("steady"))
    figure = plt.figure(figsize=(10, 4.4) if wide else (6.4, 4.8), layout="constrained")
    for axis in DRAWERS[arguments.kind](table, figure):
        axis.grid(True, which="major", color="0.9", linewidth=0.8)
        axis.set_axisbelow(True)
    name = NAMES.get(arguments.kind)
    figure.suptitle(f"{arguments.title}: {name}" if name else arguments.title, fontsize="medium")
    try:
        figure.savefig(sys.stdout.buffer if arguments.picture == "-" else arguments.picture, dpi=150, format="png")
    except OSError as error:
        sys.exit(f"{arguments.picture}: {error.strerror}")


if __name__ == "__main__":
    main()
