#!/usr/bin/env python3
"""`bulkley bench` on one and two ranks: its JSON is whole, documented and sensible, and `check` predicts its memory."""

import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from documented_keys import undocumented  # noqa: E402

PARTICLES = 60000


def main():
    program, work = start(parse_arguments(__doc__))

    def bench(ranks, *more):
        """The JSON file of a run, which must be what the run prints."""
        command = ["bench", "--particles", str(PARTICLES), "--steps", "16", "--json", "out/bench.json", *more]
        outcome = program.run(command, ranks, work, 120)
        if outcome.code != 0:
            fail(f"'bulkley {' '.join(command)}' on {ranks} ranks ended with {outcome.code}", outcome)
        result = json.loads((work / "out" / "bench.json").read_text(encoding="utf-8"))
        if json.loads(outcome.text[outcome.text.index("{"):]) != result:
            fail("what is printed is not what is written", outcome)
        if missing := undocumented(result):
            fail(f"docs/performance.md does not explain these keys: {', '.join(missing)}")
        return result

    def expect(result, condition, sentence):
        if not condition:
            fail(f"{sentence}: {json.dumps(result, indent=2)}")

    sanitized = "-fsanitize" in program.run(["--version"], 1, work, 60).text  # sanitizers keep memory of their own

    def expect_memory(result):
        ratio = result["bytes_per_particle"] / result["forecast_bytes_per_particle"]
        expect(result, sanitized or 1.0 / 1.2 < ratio < 1.2, "the memory is not the predicted one within 20 %")

    one = bench(1)
    expect(one, abs(one["particles"] - PARTICLES) < 0.05 * PARTICLES, "not about as many particles as asked for")
    expect(one, one["ranks"] == 1 and one["throughput_ratio"] is None, "one rank is compared with itself")
    expect(one, one["yielded_fraction"] > 0.95, "the sheared cream does not flow")
    expect(one, 0.245 < one["mach_number"] < 0.255, "the fastest particle is not near Mach 0.25")
    whole, phases = one["ns_per_particle_step"], sum(one["phases_ns_per_particle_step"].values())
    expect(one, 0.5 * whole < phases < 1.5 * whole, "the phases do not add up to the step")
    ratio = whole / one["naive_neo_hookean_ns_per_particle_step"]
    expect(one, 0.1 < one["ratio_to_naive"] / ratio < 10.0, "the ratio is not that of the times")
    expect_memory(one)
    expect(one, one["exchange_bytes_per_step"] == 0, "one rank sends nodes to another")

    solid = bench(1, "--material", "neo_hookean", "--no-naive", "--scheme", "blend", "--order", "cubic")
    expect(solid, solid["yielded_fraction"] == 0.0 and solid["ratio_to_naive"] is None, "an elastic solid flows, or N was timed")
    expect(solid, (solid["scheme"], solid["order"]) == ("blend", "cubic"), "other options than asked for")
    expect(solid, 0.245 < solid["mach_number"] < 0.255, "the fastest particle is not near Mach 0.25")

    implicit = bench(1, "--integrator", "imex", "--no-naive")
    expect(implicit, implicit["integrator"] == "imex" and implicit["iterations_per_step"] > 1.0, "no pressure was solved for")
    expect(implicit, 1.0 <= implicit["rounds_per_step"] <= 5.0, "the number of solutions is not that of the rounds")
    expect(implicit, 1.0 < implicit["ratio_to_explicit"] < 100.0, "it was not compared with the explicit step")
    expect(implicit, 0.245 < implicit["mach_number"] < 0.255, "it does not move as the explicit case does")
    expect(implicit, implicit["exchange_bytes_per_iteration"] == 0, "one rank sends pressures to another")
    expect(one, one["ratio_to_explicit"] is None and one["iterations_per_step"] is None, "an explicit step has iterations")
    granular = program.run(["bench", "--material", "sand", "--integrator", "imex"], 1, work, 60)
    expect(granular.text, granular.code == 2 and "--material sand" in granular.text, "sand has no part for imex")

    two = bench(2, "--no-naive")
    expect(two, two["ranks"] == 2 and two["throughput_ratio"] > 0.0, "two ranks are not compared with one")
    expect(two, two["exchange_bytes_per_step"] > 0 and two["exchange_messages_per_step"] in (1, 2), "no nodes are exchanged")
    alone = bench(4, "--integrator", "imex", "--no-naive", "--no-one-rank")  # with cells of other ranks
    expect(alone, alone["throughput_ratio"] is None, "the run on one rank was not left out")
    expect_memory(alone)


if __name__ == "__main__":
    main()
