#!/usr/bin/env python3
"""No rank and no launcher connects to an X server: hwloc's GL plugin would, and a server that ends at that moment ends the
process. A listening socket stands for the server and counts who connects."""

import os
import pathlib
import socket
import struct
import subprocess
import sys
import threading

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SKIPPED = 77


class Display:
    """Listens where an X server of a free number would, and hangs up on everyone. Counts processes of this test only: other
    programs of the machine may connect, too."""

    def __init__(self):
        for number in range(10):  # those that hwloc tries
            self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                self.socket.bind(f"\0/tmp/.X11-unix/X{number}")  # an abstract address: there is no file
                break
            except OSError:
                self.socket.close()
        else:
            print("SKIPPED: all displays are taken")
            sys.exit(SKIPPED)
        self.number = number
        self.mark = f"BULKLEY_X_SERVER_TEST={os.getpid()}"  # a variable of all that this test starts
        self.connections = 0
        self.socket.listen(64)
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            connection, _ = self.socket.accept()
            if self.is_ours(connection):
                self.connections += 1
            connection.close()  # not before: the other side waits for an answer

    def is_ours(self, connection):
        pid, _, _ = struct.unpack("3i", connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))
        try:
            return self.mark.encode() in pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
        except OSError:
            return False


def main():
    arguments = parse_arguments(__doc__, lambda parser: parser.add_argument("--source", required=True))
    program, work = start(arguments)
    display = Display()
    base = {name: value for name, value in os.environ.items() if name != "HWLOC_COMPONENTS"}
    base["DISPLAY"] = f":{display.number}"
    base.update([display.mark.split("=")])

    def connections(command, **variables):
        before = display.connections
        run = subprocess.run(command, cwd=work, env={**base, **variables}, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, text=True, timeout=60)
        if run.returncode != 0:
            print(run.stdout)
            fail(f"{command} ended with {run.returncode}")
        return display.connections - before

    presets = [program.path, "presets"]
    # What the user has set stays; this also tells whether such connections would be seen.
    if connections(presets, HWLOC_COMPONENTS="gl,x86") == 0:
        print("SKIPPED: this hwloc has no GL plugin, or does not use it")
        sys.exit(SKIPPED)

    n = connections(presets)
    if n > 0:
        fail(f"the program connected {n} times to the X server :{display.number}")
    on_two = [program.mpiexec, "-n", "2", *presets]
    n = connections(on_two, HWLOC_COMPONENTS=os.environ.get("HWLOC_COMPONENTS", ""))
    if n > 0:
        fail(f"under the tests' environment, {n} connections to the X server :{display.number}")
    for script in ("environment.sh", "jobs/job_functions.sh"):
        sourced = ["bash", "-c", '. "$1"; shift; "$@"', "bash", f"{arguments.source}/cluster/{script}", *on_two]
        n = connections(sourced)
        if n > 0:
            fail(f"under cluster/{script}, {n} connections to the X server :{display.number}")
    print(f"nothing connected to :{display.number}")


if __name__ == "__main__":
    main()
