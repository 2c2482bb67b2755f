#!/usr/bin/env python3
"""Between hosts that reach each other by TCP alone, particles have the bits of a run on one rank: on 2 to 4 hosts, evenly and
unevenly filled, with new maps of tiles, and with the implicit pressure. Ranks that follow each other and share a host send
less to other hosts than the same ranks dealt out to the hosts in turn, with the same bits, which is warned of; and less with
cuts between the hosts first than without."""

from runs import Runs, enter, fail, hosts

STEPS = 60
LEAST_TRAFFIC = 1e5  # bytes: what no start of ranks needs, and any exchange does
REMADE = ("partition.method=bisection", "partition.remake_interval=7")
CASES = [
    ("two hosts", [2, 2], REMADE),
    ("three hosts", [1, 2, 1], ("partition.method=hilbert", "partition.remake_interval=3")),
    ("four hosts", [1, 1, 1, 1], ("partition.method=auto", "partition.decision_interval=5")),
]
IMPLICIT = ("time.integrator=imex", "materials.cream.bulk_modulus=2e9")
DEALT_OUT = "ranks that follow each other are on different nodes"
MOST_SHARE = 0.8  # of the bytes between hosts with ranks dealt out that neighbours on one host may still send


def main():
    _, program, work = enter(__doc__)
    with hosts.Hosts(4, work, program.path, program.mpiexec) as group:
        runs = Runs(program, work, group)

        def traffic(layout, out, *settings, placement="slot", whole="whole", steps=STEPS):
            before, _ = group.sent_bytes()
            outcome = runs.run(layout, out, steps, *settings, placement=placement)
            sent = group.sent_bytes()[0] - before
            runs.expect_same(out, steps, whole)
            if (DEALT_OUT in outcome.text) != (placement == "node" and max(layout) > 1):
                fail(f"{out}: ranks placed by {placement}, and the warning says otherwise", outcome)
            if any("remake_interval" in word for word in settings) and "\n0 new maps" in outcome.text:
                fail(f"{out}: no new map of tiles", outcome)
            return sent

        runs.run([1], "whole", STEPS)
        for name, layout, settings in CASES:
            sent = traffic(layout, name.replace(" ", "_"), *settings)
            if sent < LEAST_TRAFFIC:
                fail(f"{name}: only {sent} bytes between hosts: the ranks do not talk by TCP")
            print(f"{name}, {layout} ranks: identical; {sent / 1e6:.1f} MB between hosts")

        runs.run([1], "implicit_whole", STEPS // 2, *IMPLICIT)
        traffic([1, 1, 1], "implicit", *IMPLICIT, whole="implicit_whole", steps=STEPS // 2)
        print("three hosts, implicit pressure: identical")

        sent = {way: traffic([2, 2], f"by_{way}", *REMADE, placement=way) for way in ("slot", "node")}
        print(f"neighbours share a host: {sent['slot'] / 1e6:.1f} MB between hosts; dealt out in turn: {sent['node'] / 1e6:.1f} MB")
        if sent["slot"] > MOST_SHARE * sent["node"]:
            fail("ranks that follow each other on a host do not save traffic between hosts")

        sent = {n: traffic([2, 2, 2], f"halves_{n}", *REMADE, f"partition.ranks_per_node={n}") for n in (0, 1)}
        print(f"three hosts of two: {sent[0] / 1e6:.1f} MB between hosts; halved without regard to hosts: {sent[1] / 1e6:.1f} MB")
        if sent[0] >= sent[1]:
            fail("cuts between hosts first do not save traffic between hosts")


if __name__ == "__main__":
    main()
