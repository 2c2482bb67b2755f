#!/usr/bin/env python3
"""A folder that hosts share by a network file system (GlusterFS in user space, served by the first host): ranks on all hosts write
a checkpoint, others read it back, and the run goes on to the bits of a run on one rank. A host that remembers that a file is not
there, when it is there by now, refuses the restart or takes an older checkpoint, with a sentence; its bits are never wrong.
Needs the Debian packages glusterfs-server and glusterfs-client, and FUSE."""

import os
import shutil
import time

from runs import LIMIT, SCENE, Runs, checkpoint, enter, fail, hosts

SERVER = """
volume brick
  type storage/posix
  option directory {folder}/brick
end-volume
volume locks
  type features/locks
  subvolumes brick
end-volume
volume server
  type protocol/server
  option transport-type tcp
  option transport.socket.bind-address {address}
  option transport.socket.listen-port 24007
  option auth.addr.locks.allow *
  subvolumes locks
end-volume
"""
CLIENT = """
volume client
  type protocol/client
  option transport-type tcp
  option remote-host {address}
  option remote-port 24007
  option remote-subvolume locks
  option ping-timeout 5
end-volume
"""
PARTS = (20, 30, 40)  # steps that parts end at
FORGETFUL, STALE = 0, 600  # s, that a host trusts what it knows of names


class Folder:
    """work/shared on all hosts of `group`."""

    def __init__(self, work, group):
        self.work, self.group = work, group
        for name in ("brick", "shared"):
            (work / name).mkdir()
        address = group[0].address
        (work / "server.vol").write_text(SERVER.format(folder=work.resolve(), address=address), encoding="utf-8")
        (work / "client.vol").write_text(CLIENT.format(address=address), encoding="utf-8")
        self.server = group[0].start(["glusterfsd", "-N", "-f", "server.vol", "-l", "/run/server.log", "-p", "/run/server.pid"],
                                     work.resolve())
        for host in group:
            self.mount(host, STALE if host is group[1] else FORGETFUL)

    def mount(self, host, trust):
        timeouts = [f"--{what}-timeout={trust}" for what in ("entry", "attribute", "negative")]
        end = time.monotonic() + 20.0
        while True:  # the server takes its time to come up
            host.run(["glusterfs", *timeouts, "-f", "client.vol", "-l", "/run/client.log", str(self.work / "shared")], self.work, 20)
            if host.run(["stat", "-f", "-c", "%T", "shared"], self.work, 20).text.strip() == "fuseblk":
                return
            if time.monotonic() > end:
                hosts.skip(f"GlusterFS does not mount here: {host.run(['tail', '-n', '1', '/run/client.log'], self.work, 5).text}")
            host.run(["umount", "shared"], self.work, 5)
            time.sleep(0.5)

    def sees(self, host, path):
        return self.group[host].run(["stat", str(path)], self.work, 20).code == 0


def main():
    _, program, work = enter(__doc__)
    missing = [tool for tool in ("glusterfsd", "glusterfs") if not shutil.which(tool)]
    if missing or not os.access("/dev/fuse", os.R_OK | os.W_OK):
        hosts.skip(f"{', '.join(missing) or '/dev/fuse'} not there; the packages are glusterfs-server and glusterfs-client")
    with hosts.Hosts(3, work, program.path, program.mpiexec) as group:
        runs = Runs(program, work, group)
        runs.run([1], "whole", PARTS[-1], f"checkpoint.steps={PARTS[0]}", "checkpoint.keep=9")
        folder = Folder(work, group)

        def same(host, step):
            words = [program.path, "compare", f"whole/{checkpoint(step)}", f"shared/run/{checkpoint(step)}"]
            outcome = group[host].run(words, work, LIMIT)
            if outcome.code != 0 or "identical" not in outcome.text:
                fail(f"host {host} does not read the bits of step {step}", outcome)

        runs.run([1, 1, 1], "shared/run", PARTS[0], "checkpoint.keep=9")
        for host in range(3):
            same(host, PARTS[0])
        print("a checkpoint written by three hosts: each reads back its bits")

        # The second host learns that the next checkpoint is not there, and goes on believing so.
        if folder.sees(1, f"shared/run/{checkpoint(PARTS[1])}"):
            fail("there is a checkpoint too early")
        runs.run([1], "shared/run", PARTS[1], "--restart", "checkpoint.keep=9")
        stale = not folder.sees(1, f"shared/run/{checkpoint(PARTS[1])}")
        arguments = ["run", str(SCENE), "--out", "shared/run", "--restart", "--max-steps", str(PARTS[2]), "--set", "checkpoint.keep=9"]
        outcome = group.run([1, 1], arguments, work, LIMIT)
        if outcome.code == 0:
            same(2, PARTS[2])
            known = [line for line in outcome.text.splitlines() if line.startswith(("warning", "continuing"))]
            print(f"a host whose names are {'stale' if stale else 'fresh'}: {'; '.join(known)}; identical")
        elif outcome.code in (2, 3) and "checkpoint" in outcome.text:
            print(f"a host whose names are stale: refused\n{outcome.text}")
        else:
            fail(f"with stale names the run ended with {outcome.code}", outcome)
        if not stale:
            fail("the second host has found the new name: nothing was stale")


if __name__ == "__main__":
    main()
