"""Hosts on one machine: each has a network, a /dev/shm, a /run, a /sys, a name and System V shared memory of its own, and reaches
the others by TCP through a switch alone. Their disk is the machine's, unless `own_disk` hides a part of it.

A test begins with `enter()`, which starts it again as process 1 of namespaces of its own: whatever ends it, the kernel ends
every process and removes every network that it has made. It needs root, or user namespaces, but no setting of the machine."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import Outcome  # noqa: E402

SKIPPED = 77
INSIDE = "BULKLEY_INSIDE_NAMESPACES"
TOOLS = ["ip", "unshare", "nsenter", "mount"]
OWN = ["--net", "--mount", "--uts", "--ipc"]  # what each host has of its own
SUBNET = "10.77.0"

# In place of ssh: mpirun starts its daemon on another host with it.
AGENT = """#!/bin/sh
while [ "${{1#-}}" != "$1" ]; do shift; done
host=$1
shift
exec nsenter --target "$(cat {folder}/$host)" {own} -- setsid sh -c "$*"
"""


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIPPED)


def enter():
    """Goes on as process 1 of new namespaces; ends the test with 77 and the reason where there can be none."""
    os.environ["PATH"] = os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/sbin"])
    if os.environ.get(INSIDE):
        prepare()
        return
    missing = [tool for tool in TOOLS if not shutil.which(tool)]
    if missing:
        skip(f"{', '.join(missing)} not found; the packages are iproute2 and util-linux")
    new = ["unshare", *([] if os.geteuid() == 0 else ["--user", "--map-root-user"]), *OWN, "--pid", "--fork", "--kill-child",
           "--mount-proc"]
    probe = "mount -t sysfs sysfs /sys && ip link add name switch type bridge && ip link add name one type veth peer name two"
    tried = subprocess.run([*new, "sh", "-c", probe], capture_output=True, text=True)
    if tried.returncode != 0:
        skip(f"no namespaces with networks here: {tried.stderr.strip()}")
    os.environ[INSIDE] = "1"
    sys.stdout.flush()
    os.execvp(new[0], [*new, sys.executable, *sys.argv])


def prepare():
    """Once inside. Process 1 gets only signals that it has asked for; its numbers of processes are not those outside, so that
    what Open MPI keeps in files under such names needs a folder of its own."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda number, _: sys.exit(f"ended by signal {number}"))
    check("mount", "-t", "sysfs", "sysfs", "/sys")
    check("mount", "-t", "tmpfs", "tmpfs", "/run")
    os.environ["TMPDIR"] = "/run"
    check("ip", "link", "set", "lo", "up")
    check("ip", "link", "add", "name", "switch", "type", "bridge")
    check("ip", "link", "set", "switch", "up")


def check(*command):
    subprocess.run(command, check=True, stdin=subprocess.DEVNULL)


def is_alive(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


class Host:
    """One host; `link` is its port on the switch."""

    def __init__(self, number):
        self.name = self.link = f"node{number}"
        self.address = f"{SUBNET}.{number}"
        mounts = ["tmpfs /dev/shm", "tmpfs /run", "sysfs /sys"]
        script = " && ".join([f"hostname {self.name}", *(f"mount -t {each.split()[0]} {each}" for each in mounts), "echo up",
                              "exec sleep inf"])
        self.holder = subprocess.Popen(["unshare", *OWN, "sh", "-c", script], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                       text=True)
        if self.holder.stdout.readline() != "up\n":
            raise RuntimeError(f"{self.name} did not come up")
        check("ip", "link", "add", "name", self.link, "type", "veth", "peer", "name", "eth0", "netns", str(self.holder.pid))
        check("ip", "link", "set", self.link, "master", "switch", "up")
        self.check("ip", "link", "set", "lo", "up")
        self.check("ip", "address", "add", f"{self.address}/24", "dev", "eth0")
        self.check("ip", "link", "set", "eth0", "up")
        self.network = os.stat(f"/proc/{self.holder.pid}/ns/net").st_ino

    def command(self, words, folder):
        """What runs `words` here, in `folder`; it is looked up here, where another disk may be mounted."""
        there = ["sh", "-c", 'cd "$0" && exec "$@"', str(folder)]
        return ["nsenter", "--target", str(self.holder.pid), *OWN, "--", *there, *words]

    def check(self, *words):
        check(*self.command(words, "/"))

    def start(self, words, folder, **options):
        """A process in the background; its output is one text."""
        return subprocess.Popen(self.command(words, folder), **{
            "stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True,
            "errors": "replace", **options})

    def run(self, words, folder, limit):
        """As `Program.run`. At the limit all processes of this host are killed."""
        before = time.monotonic()
        process = self.start(words, folder)
        try:
            text, _ = process.communicate(timeout=limit)
            code = process.returncode
        except subprocess.TimeoutExpired:
            self.kill()
            text, _ = process.communicate()
            code = None
        return Outcome(code, text, time.monotonic() - before)

    def processes(self, name=None):
        """Numbers of the processes that live here; `name`: of those whose program is called so."""
        found = []
        for entry in pathlib.Path("/proc").iterdir():
            try:
                if (entry.name.isdigit() and int(entry.name) != self.holder.pid
                        and os.stat(entry / "ns" / "net").st_ino == self.network and is_alive(entry.name)
                        and name in (None, (entry / "comm").read_text(encoding="utf-8").strip())):
                    found.append(int(entry.name))
            except OSError:
                continue  # it has just ended
        return found

    def kill(self):
        """All processes at once: they are stopped first, so that none can act on the end of another."""
        for number in (signal.SIGSTOP, signal.SIGSTOP, signal.SIGKILL):
            for pid in self.processes():
                try:
                    os.kill(pid, number)
                except ProcessLookupError:
                    pass

    def cut(self):
        """Takes the link down, as by pulling its cable at the switch: nobody is told."""
        check("ip", "link", "set", self.link, "down")

    def restore(self):
        """Puts the link up again. Returns when both of its ends send, up to a second later, and this host has forgotten whom it
        could not reach: what starts at once then finds the others."""
        check("ip", "link", "set", self.link, "up")
        end = time.monotonic() + 10.0
        outer = pathlib.Path(f"/sys/class/net/{self.link}/operstate")
        inner = ["grep", "-qx", "up", "/sys/class/net/eth0/operstate"]
        while (outer.read_text(encoding="utf-8") != "up\n"
               or subprocess.run(self.command(inner, "/"), stdin=subprocess.DEVNULL).returncode != 0):
            if time.monotonic() > end:
                raise RuntimeError(f"{self.name}: the link does not come up")
            time.sleep(0.02)
        self.check("ip", "neigh", "flush", "all")

    def own_disk(self, folder):
        """From now on what is under `folder` is another disk here, an empty one."""
        self.check("mount", "-t", "tmpfs", "tmpfs", str(folder))

    def sent_bytes(self):
        """Bytes that have left through the link since it was made, with headers from Ethernet up; and its frames."""
        text = subprocess.run(["ip", "-j", "-s", "link", "show", "dev", self.link], check=True, capture_output=True, text=True).stdout
        received = json.loads(text)[0]["stats64"]["rx"]  # by the switch
        return received["bytes"], received["packets"]


class Hosts:
    """`n` hosts for the time of a `with`; `folder` takes their names and the agent, and must be one that all of them see."""

    def __init__(self, n, folder, program, mpiexec):
        self.program, self.mpiexec = program, mpiexec
        self.folder = pathlib.Path(folder).resolve() / "hosts"
        self.folder.mkdir(parents=True)
        self.names = self.folder / "names"
        self.names.write_text("127.0.0.1 localhost\n" + "".join(f"{SUBNET}.{k} node{k}\n" for k in range(1, n + 1)),
                              encoding="utf-8")
        check("mount", "--bind", str(self.names), "/etc/hosts")
        self.hosts = []
        for number in range(1, n + 1):
            host = Host(number)
            self.hosts.append(host)
            (self.folder / host.name).write_text(str(host.holder.pid), encoding="utf-8")
        self.agent = self.folder / "agent"
        self.agent.write_text(AGENT.format(folder=self.folder, own=" ".join(OWN)), encoding="utf-8")
        self.agent.chmod(0o755)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for host in self.hosts:
            host.kill()
            check("ip", "link", "delete", host.link)  # the kernel takes its time to do so after the end of a network
            host.holder.kill()
            host.holder.wait()
        check("umount", "/etc/hosts")

    def __getitem__(self, k):
        """Host `k`, counted from 0."""
        return self.hosts[k]

    def __iter__(self):
        return iter(self.hosts)

    def mpirun(self, layout, arguments, placement="slot", launcher=()):
        """The command, for the first host, that runs `bulkley arguments` with layout[k] ranks on host k. Ranks that follow each
        other share a host with the placement `slot`, and are dealt out to the hosts in turn with `node`. `launcher`: options of mpirun."""
        places = ",".join(f"{host.name}:{n}" for host, n in zip(self.hosts, layout) if n > 0)
        return [self.mpiexec, *launcher, "--mca", "plm", "rsh", "--mca", "plm_rsh_agent", str(self.agent), "--host", places, "-n",
                str(sum(layout)), "--map-by", placement, self.program, *arguments]

    def run(self, layout, arguments, folder, limit, placement="slot"):
        """Runs to its end, started on the first host."""
        return self[0].run(self.mpirun(layout, arguments, placement), folder, limit)

    def sent_bytes(self):
        """Bytes that have left all hosts, and frames."""
        bytes_and_frames = [host.sent_bytes() for host in self.hosts]
        return tuple(sum(numbers) for numbers in zip(*bytes_and_frames))
