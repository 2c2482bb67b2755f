#!/usr/bin/env python3
"""A run that stops on one number of hosts goes on, on others, to the bits of a run on one rank: from two hosts to four, from there
to one, and from there to three."""

from runs import Runs, checkpoint, enter, fail, hosts

# steps at which a part ends, and its ranks on each host
PARTS = [(20, [2, 1]), (35, [1, 1, 1, 1]), (50, [2]), (60, [1, 2, 2])]


def main():
    _, program, work = enter(__doc__)
    with hosts.Hosts(4, work, program.path, program.mpiexec) as group:
        runs = Runs(program, work, group)
        runs.run([1], "whole", PARTS[-1][0])
        earlier = 0
        for step, layout in PARTS:
            outcome = runs.run(layout, "parts", step, *(["--restart"] if earlier else []))
            if earlier and f"continuing from parts/{checkpoint(earlier)}" not in outcome.text:
                fail(f"the part to step {step} does not go on from step {earlier}", outcome)
            print(f"steps {earlier} to {step} with {layout} ranks on the hosts")
            earlier = step
        runs.expect_same("parts", earlier, "whole")
        print("identical")


if __name__ == "__main__":
    main()
