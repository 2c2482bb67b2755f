"""history.csv as the curves of a report: read once, however long the table is, and thinned to what a page can show."""

import csv
import itertools
import os
import pathlib
from dataclasses import dataclass, field

import numpy as np

N_BINS, MOST_POINTS = 500, 1000
ROWS_AT_ONCE = 20000


@dataclass
class Curve:
    """`x`, `y`: (n,), finite, x ascending; `color`: number of the page's colour."""

    name: str
    color: int
    x: np.ndarray
    y: np.ndarray


@dataclass
class Plot:
    """Curves over time. `unit`: of y, in brackets; `dots`: points without lines between them; `may_be_log`: a logarithmic
    axis if the values allow and need it; `from_zero`: the axis shows zero."""

    title: str
    unit: str
    curves: list[Curve] = field(default_factory=list)
    dots: bool = False
    may_be_log: bool = False
    from_zero: bool = False


@dataclass(frozen=True)
class HistoryPlots:
    """`limiters`: name and share of the rows in per cent, largest first."""

    plots: list[Plot]
    n_rows: int
    limiters: list[tuple[str, float]]


class ThinnedCurve:
    """A curve of any number of points, added by ascending x, kept as about 1000: the smallest and the largest value in each of
    500 equal parts of [0, `end`]. A shorter one is kept as it is."""

    def __init__(self, end: float):
        self.end = end
        self.x, self.y = np.zeros(0), np.zeros(0)
        self.n = 0

    def add(self, x: np.ndarray, y: np.ndarray) -> None:
        """Points that are not finite are left out."""
        finite = np.isfinite(x) & np.isfinite(y)
        self.n += int(finite.sum())
        self.x, self.y = np.concatenate([self.x, x[finite]]), np.concatenate([self.y, y[finite]])
        if self.n > MOST_POINTS:  # the extremes of extremes are those of all points
            kept = extremes(self.x, self.y, self.end)
            self.x, self.y = self.x[kept], self.y[kept]


def extremes(x: np.ndarray, y: np.ndarray, end: float) -> np.ndarray:
    """Indices of the smallest and the largest value in each part of [0, end], ascending; the first of equal ones."""
    part = np.clip(x / end if end > 0.0 else 0.0 * x, 0.0, 1.0)
    bins = np.minimum((part * N_BINS).astype(int), N_BINS - 1)
    kept = []
    for sign in (1.0, -1.0):
        order = np.lexsort((sign * y, bins))
        kept.append(order[np.r_[True, np.diff(bins[order]) > 0]])
    return np.unique(np.concatenate(kept))


@dataclass
class Source:
    """A curve while the table is read: the sum of columns, less that of the first row if it is a change. `unless`: a column;
    rows where it is a number are left out."""

    name: str
    columns: list[str]
    curve: ThinnedCurve
    is_change: bool = False
    unless: str = ""
    skips_first: bool = False
    start: float = 0.0

    def take(self, time: np.ndarray, table: dict[str, np.ndarray], is_first: bool) -> None:
        unknown = np.full(len(time), np.nan)
        value = sum(table.get(column, unknown) for column in self.columns)
        if self.unless:
            value = np.where(np.isfinite(table.get(self.unless, unknown)), np.nan, value)
        if is_first and self.is_change:
            self.start = value[0]
        begin = 1 if is_first and self.skips_first else 0
        self.curve.add(time[begin:], value[begin:] - self.start)


class Sheets:
    """The plots and what their curves are made of."""

    def __init__(self, end: float):
        self.end = end
        self.sheets: list[tuple[Plot, list[Source]]] = []

    def begin(self, title: str, unit: str, **options) -> None:
        self.sheets.append((Plot(title, unit, **options), []))

    def curve(self, name: str, *columns: str, **options) -> None:
        self.sheets[-1][1].append(Source(name, list(columns), ThinnedCurve(self.end), **options))

    def vector(self, name: str, unit: str) -> None:
        for axis in "xyz":
            self.curve(axis, f"{name}_{axis} {unit}")

    def take(self, time: np.ndarray, table: dict[str, np.ndarray], is_first: bool) -> None:
        for _, sources in self.sheets:
            for source in sources:
                source.take(time, table, is_first)

    def plots(self) -> list[Plot]:
        """Curves without a point are left out; the others keep their colours."""
        for plot, sources in self.sheets:
            plot.curves = [Curve(source.name, k, source.curve.x, source.curve.y) for k, source in enumerate(sources)
                           if source.curve.n > 0]
        return [plot for plot, _ in self.sheets]


def lay_out_budget(sheets: Sheets, columns: list[str]) -> None:
    """Where the energy went, and what did work."""
    sheets.begin("Energy lost since the start", "[J]")
    sheets.curve("laws", "dissipated_energy [J]")
    sheets.curve("to the grid", "to_grid_loss [J]")
    sheets.curve("time integration", "time_integration_loss [J]")
    sheets.curve("to the grid, and time integration", "to_grid_and_integration_loss [J]", unless="to_grid_loss [J]")
    sheets.curve("back to the particles", "from_grid_loss [J]")
    sheets.curve("both transfers and time integration", "to_grid_and_integration_loss [J]", "from_grid_loss [J]")
    sheets.curve("removed particles", "removed_energy [J]")
    contacts = [column.removesuffix(".contact_loss [J]") for column in columns if column.endswith(".contact_loss [J]")]
    if contacts:
        sheets.begin("Energy lost at walls and colliders since the start", "[J]")
        for contact in contacts:
            sheets.curve(contact, f"{contact}.contact_loss [J]")
    sheets.begin("Work done on the material since the start", "[J]")
    sheets.curve("gravity", "gravity_work [J]")
    for force in ("acceleration_field", "magnetic_field"):
        if f"{force}_work [J]" in columns:
            sheets.curve(force, f"{force}_work [J]")
    for contact in contacts:
        sheets.curve(contact, f"{contact}.contact_work [J]")


def laid_out(end: float, columns: list[str]) -> Sheets:
    """The plots of a history with these columns."""
    energies = [f"{name}_energy [J]" for name in ("kinetic", "elastic", "gravitational", "dissipated")]
    sheets = Sheets(end)
    sheets.begin("Energies", "[J]")
    for name, column in zip(("kinetic", "elastic", "gravity, change", "dissipated by the laws"), energies):
        sheets.curve(name, column, is_change=name.endswith("change"))
    if "energy_residual [J]" in columns:
        lay_out_budget(sheets, columns)
    else:  # of a version without the budget
        sheets.begin("Energy balance: change of the sum of these four", "[J]", from_zero=True)
        sheets.curve("change of the sum", *energies, is_change=True)
    sheets.begin("Momentum", "[kg m/s]")
    sheets.vector("momentum", "[kg m/s]")
    sheets.begin("Angular momentum about the origin", "[kg m\u00b2/s]")
    sheets.vector("angular_momentum", "[kg m^2/s]")
    sheets.begin("Centre of mass", "[m]")
    sheets.vector("center_of_mass", "[m]")
    sheets.begin("Largest speed", "[m/s]", from_zero=True)
    sheets.curve("largest speed", "max_speed [m/s]")
    sheets.begin("Volume ratio, smallest and largest", "")
    sheets.curve("smallest", "min_volume_ratio")
    sheets.curve("largest", "max_volume_ratio")
    if "volume_error" in columns:
        sheets.begin("Volume error: root mean square of J - 1", "", may_be_log=True)
        sheets.curve("volume error", "volume_error")
    if "pressure_iterations" in columns:
        sheets.begin("Iterations of the implicit pressure in a step, since the row before", "", from_zero=True)
        sheets.curve("mean", "pressure_iterations", skips_first=True)
        sheets.curve("largest", "pressure_iterations_max", skips_first=True)
        sheets.begin("Solutions of the pressure in a step, until walls and free surfaces kept their state", "", from_zero=True)
        sheets.curve("rounds", "contact_rounds", skips_first=True)
    if "viscosity_iterations" in columns:
        sheets.begin("Iterations of implicit viscosity in a step, since the row before", "", from_zero=True)
        sheets.curve("mean", "viscosity_iterations", skips_first=True)
        sheets.curve("largest", "viscosity_iterations_max", skips_first=True)
    sheets.begin("Yielded part of the mass", "", from_zero=True)
    sheets.curve("yielded", "yielded_fraction")
    sheets.begin("Thickness of the thinnest tenth of the material, in cells", "[cells]", from_zero=True)
    sheets.curve("thickness", "thickness_decile [cells]")
    sheets.begin("Imbalance: largest over mean particles of a rank", "")
    sheets.curve("imbalance", "imbalance")
    sheets.begin("Wall time of a step", "[s]", may_be_log=True)
    sheets.curve("wall time", "wall_time_per_step [s]", skips_first=True)  # the first row is written before the first step
    sheets.begin("Rejected steps so far", "", from_zero=True)
    sheets.curve("rejected", "rejected_steps")
    for column in columns:
        for quantity, unit in (("reach", "[m]"), ("pressure", "[Pa]")):
            if column.endswith(f".{quantity} {unit}"):
                name = column.removesuffix(f".{quantity} {unit}")
                sheets.begin(f"{quantity.capitalize()}: {name}", unit)
                sheets.curve(quantity, column)
        for quantity, unit in (("force", "[N]"), ("torque", "[N m]")):
            mark = f".{quantity}_x {unit}"
            if column.endswith(mark):
                collider = column.removesuffix(mark)
                sheets.begin(f"{quantity.capitalize()} on {collider}", unit)
                sheets.vector(f"{collider}.{quantity}", unit)
    return sheets


class TimeSteps:
    """Time steps, one curve a limiter. `limiters`: their names in the order of the colours, so that these stay the same from
    run to run."""

    def __init__(self, end: float, limiters: list[str]):
        self.end, self.order = end, limiters
        self.curves: dict[str, ThinnedCurve] = {}
        self.counts: dict[str, int] = {}

    def take(self, time: np.ndarray, dt: np.ndarray, limiter: np.ndarray) -> None:
        for name in set(limiter) - {"", "start"}:
            mine = limiter == name
            self.curves.setdefault(name, ThinnedCurve(self.end)).add(time[mine], dt[mine])
            self.counts[name] = self.counts.get(name, 0) + int(mine.sum())

    def plot(self) -> Plot:
        def color(name):
            return self.order.index(name) if name in self.order else 0
        curves = [Curve(name, color(name), curve.x, curve.y) for name, curve in sorted(self.curves.items())]
        return Plot("Time step and what limits it", "[s]", curves, dots=True, may_be_log=True)

    def shares(self) -> list[tuple[str, float]]:
        n = sum(self.counts.values())
        return sorted(((name, 100.0 * count / n) for name, count in sorted(self.counts.items())), key=lambda pair: -pair[1])


def tables(path: pathlib.Path):
    """The names of the columns, then parts of the table as dictionaries of arrays: floats, NaN where a cell is no number, but
    text in the column "limiter". Rows with too few or too many cells are left out, and so is a last one without its end."""
    with open(path, newline="", encoding="utf-8", errors="replace") as stream:
        reader = csv.reader(line for line in stream if line.endswith("\n"))
        header = next(reader, [])
        yield header
        while rows := list(itertools.islice(reader, ROWS_AT_ONCE)):
            columns = list(zip(*(row for row in rows if len(row) == len(header))))
            if columns:
                yield {name: np.array(column) if name == "limiter" else numbers(column)
                       for name, column in zip(header, columns)}


def numbers(cells: tuple[str, ...]) -> np.ndarray:
    try:
        return np.array(cells, dtype=float)
    except ValueError:
        return np.array([number(cell) for cell in cells])


def number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan


def history_plots(folder: str | os.PathLike, end: float, limiters: list[str]) -> HistoryPlots:
    """The plots of `folder`/history.csv; of a table that is not there they are empty. Rows beyond the time `end` (s) have
    come since the rest of the page was read, and are left for the next page."""
    path = pathlib.Path(folder) / "history.csv"
    parts = tables(path) if path.is_file() else iter([[]])
    sheets, steps, n_rows = laid_out(end, next(parts)), TimeSteps(end, limiters), 0
    for table in parts:
        time = table.get("time [s]", np.full(len(next(iter(table.values()))), np.nan))
        late = np.flatnonzero(time > end)
        n = int(late[0]) if len(late) else len(time)
        if n > 0:
            table = {name: column[:n] for name, column in table.items()}
            sheets.take(time[:n], table, n_rows == 0)
            steps.take(time[:n], table.get("dt [s]", np.full(n, np.nan)), table.get("limiter", np.full(n, "")))
            n_rows += n
        if len(late):
            break
    plots = sheets.plots()
    plots.insert(2, steps.plot())
    return HistoryPlots(plots, n_rows, steps.shares())
