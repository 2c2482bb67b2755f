"""What the implicit pressure costs and changes: every figure with the explicit step and with `imex`, as a table in Markdown.

    python3 -m bulkley imex-gain [--figures 1,8-pie] [--size small|default] [--ranks 2] [--finer] [--out DIR]

Each figure runs in turn with the explicit step as the scene has it, with the implicit pressure and the scene's bulk modulus, and
with the implicit pressure and a real one, 2e9 Pa. What an explicit run with the real one would take follows from the speed
of its waves. `--finer` adds runs on cells of half the width: an explicit one, for both runs with the scene's modulus, and an
implicit one with the real modulus. Processor times are given over that of the explicit run: other work on the machine changes
them less than wall times, and a ratio means the same on other machines. Use one rank, because ranks that wait count. Runs
that are in --out already are not repeated. What the table means: docs/adaptive-step.md. Needs numpy and h5py.
"""

import math

from bulkley.adaptive_gain import Study, center_difference, parse_arguments
from bulkley.markdown import markdown
from bulkley.run_folder import EndedRun

REAL_MODULUS = 2e9  # Pa
IMEX = ["time.integrator=imex"]
# Volume ratios are the extremes over the rows: nearly every step has one, as in the scenes.
ROWS = ["output.history_interval=2"]


class TimedRun(EndedRun):
    """A run that has ended, and the processor time that it took, s."""
    processor_time = math.nan


def study_figure(figure, options):
    """All runs of a figure; the rows of its table. A run that fails has its fault in the place of numbers."""
    study = Study(figure, options)
    scene = ended(study, "explicit", [])
    softened = ended(study, "imex", IMEX)
    material = next(iter(scene.scene["materials"])) if scene else "fluid"
    real = [*IMEX, f"materials.{material}.bulk_modulus={REAL_MODULUS:g}"]
    stiff = ended(study, "imex_real", real)
    if options.dry_run:
        return None
    finer = [f"domain.cell_size={study.number('domain', 'cell_size') / 2:.6g}"]
    finer_scene = ended(study, "finer_explicit", finer) if options.finer else None
    finer_stiff = ended(study, "finer_imex_real", [*finer, *real]) if options.finer else None
    modulus = f"{scene.scene['materials'][material]['bulk_modulus']:.3g}"
    real_modulus = f"{REAL_MODULUS:.3g}"
    return {"figure": figure, "rows": [describe("explicit", modulus, scene, scene, finer_scene), describe("imex", modulus, softened, scene, finer_scene),
                     describe("imex", real_modulus, stiff, scene, finer_stiff),
                     estimate("explicit, estimated", real_modulus, scene, material)]}


def ended(study, name, settings):
    """The run, which must reach its end; None in a dry run."""
    outcome = study.run(name, [*ROWS, *settings])
    if outcome is None:
        return None
    run = TimedRun(outcome.folder)
    run.processor_time = outcome.processor_time
    if run.status["state"] != "finished":
        raise SystemExit(f"imex-gain: figure {study.figure}, {name}: {outcome.fault}")
    return run


def describe(name, modulus, run, explicit, finer):
    """One row: `explicit` is the run that processor times are over, `finer` the run on finer cells or None."""
    history = run.history
    implicit = "pressure_iterations" in history
    return {"run": name, "modulus": modulus, "steps": int(history["step"][-1]), "time": run.processor_time / explicit.processor_time,
            "iterations": mean_iterations(history) if implicit else None, "rejected": int(history["rejected_steps"][-1]),
            "smallest": float(history["min_volume_ratio"].min()), "volume_error": float(history["volume_error"].max()),
            "finer": center_difference(run, finer) if finer else None, "explicit": center_difference(run, explicit)}


def mean_iterations(history):
    """Iterations a step over the whole run."""
    steps = history["step"][1:] - history["step"][:-1]
    return float((history["pressure_iterations"][1:] * steps).sum() / steps.sum())


def estimate(name, modulus, run, material):
    """The row of the explicit run with the real modulus: its waves at rest limit every step."""
    time, law = run.scene["time"], run.scene["materials"][material]
    speed = math.sqrt((REAL_MODULUS + 4.0 / 3.0 * law["shear_modulus"]) / law["density"])
    steps = time["end"] * speed / (time["elastic_cfl"] * run.cell_size)
    return {"run": name, "modulus": modulus, "steps": round(steps), "time": steps / run.history["step"][-1]}


def table(studies):
    """One row a run; the difference from finer cells only where such runs were made."""
    header = ["figure", "run", "bulk modulus [Pa]", "steps", "processor time over the explicit run's", "iterations a step",
              "rejected steps", "smallest volume ratio", "largest rms volume error", "centre of mass off from the explicit run [%]"]
    compared = any(row.get("finer") is not None for study in studies for row in study["rows"])
    rows = []
    for study in studies:
        for row in study["rows"]:
            cells = [study["figure"], row["run"], row["modulus"], str(row["steps"]),
                     f"{row['time']:.2f}" if row["time"] < 10 else f"{row['time']:.0f}"]
            if "smallest" in row:
                cells += ["-" if row["iterations"] is None else f"{row['iterations']:.1f}", str(row["rejected"]),
                          f"{row['smallest']:.2f}", f"{row['volume_error']:.1e}", f"{row['explicit']:.1f}",
                          "-" if row["finer"] is None else f"{row['finer']:.1f}"]
            else:
                cells += ["-"] * 6
            rows.append(cells if compared else cells[:-1])
    return markdown([*header, "and from finer cells [%]"] if compared else header, rows)


def main():
    options = parse_arguments(__doc__)
    studies = [study_figure(figure, options) for figure in options.figures]
    if not options.dry_run:
        print(table(studies))


if __name__ == "__main__":
    main()
