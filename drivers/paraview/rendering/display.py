"""An X server where there is none: Debian's ParaView cannot draw without."""

import ctypes
import os
import shutil
import subprocess
import sys

from rendering.faults import fail

UNDER_XVFB = "BULKLEY_RENDER_UNDER_XVFB"


def leave(status):
    """Ends the program at once: ParaView closes its window after the X connection and then reports an error of its own making.
    Printed text is in C's buffers, which pvpython's streams do not flush."""
    sys.stdout.flush()
    sys.stderr.flush()
    ctypes.CDLL(None).fflush(None)
    os._exit(status)


def restart_under_xvfb(size):
    """Does nothing where there is a display; else does the work in another process that has one, and ends."""
    if os.environ.get("DISPLAY"):
        return
    if UNDER_XVFB in os.environ:
        fail("Xvfb gave no display")
    for program in ("Xvfb", "pvpython"):
        if not shutil.which(program):
            fail(f"there is no display, and {program} is not installed (Debian: apt-get install xvfb paraview)")
    # The server chooses a free display and reports its number when it is ready.
    reading, writing = os.pipe()
    screen = f"{max(size[0], 640)}x{max(size[1], 480)}x24"
    server = subprocess.Popen(["Xvfb", "-displayfd", str(writing), "-screen", "0", screen, "-nolisten", "tcp", "-noreset"],
                              pass_fds=[writing], stderr=subprocess.DEVNULL)
    os.close(writing)
    try:
        with os.fdopen(reading) as channel:
            number = channel.readline().strip()
        if not number:
            fail("Xvfb did not start")
        environment = {**os.environ, UNDER_XVFB: "1", "DISPLAY": f":{number}"}
        environment.pop("XAUTHORITY", None)
        command = ["pvpython", os.path.abspath(sys.argv[0]), *sys.argv[1:]]
        status = subprocess.run(command, env=environment).returncode
    finally:
        server.terminate()
        server.wait()
    sys.exit(status)
