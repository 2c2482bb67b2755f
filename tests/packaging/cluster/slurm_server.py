"""A Slurm of one node on loopback, with all its state in one folder, for the time of a `with`."""

import contextlib
import ctypes
import getpass
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

CONFIGURATION = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
# A requeued job waits until no credential of its former life is valid; two minutes unless told otherwise.
AuthInfo=socket={sockets}/munge.socket,cred_expire=5
CredType=cred/munge
StateSaveLocation={folder}/controller
SlurmdSpoolDir={sockets}/node
SlurmctldPidFile={folder}/controller.pid
SlurmdPidFile={folder}/node.pid
SlurmctldLogFile={folder}/controller.log
SlurmdLogFile={folder}/node.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=2,batch_sched_delay=0,bf_interval=2,defer_batch=0
# More processors than there may be, so that the jobs of the test run side by side.
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=5
MpiDefault=none
NodeName={host} NodeAddr=127.0.0.1 CPUs=16 RealMemory=1000 State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
"""
TOOLS = ["munged", "mungekey", "slurmctld", "slurmd", "sbatch", "srun", "squeue", "scontrol"]
PATIENCE = 20.0  # s, for a daemon to come up


class CannotRun(Exception):
    """Why there can be no Slurm here."""


def path_with_daemons():
    return os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/sbin"])  # a user's PATH may lack them


def expect_tools():
    missing = [tool for tool in TOOLS if not shutil.which(tool, path=path_with_daemons())]
    if missing:
        raise CannotRun(f"{', '.join(missing)} not found; cluster/install_packages.sh --slurm installs Slurm")


def free_ports(count):
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def end_with_parent():
    """In a new process: it gets SIGTERM if the test dies without a chance to end it, as at a time limit."""
    PR_SET_PDEATHSIG = 1
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


class Slurm:
    """Started on entry, ended on exit, however that comes about."""

    def __init__(self, folder):
        expect_tools()
        self.folder = pathlib.Path(folder)
        self.daemons = []

    def __enter__(self):
        signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by a signal"))  # by way of __exit__
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        for name in ("controller", "munge"):
            (self.folder / name).mkdir(parents=True, mode=0o700)
        # Names of sockets, munge's and those of job steps, may have some hundred characters only, and munged wants no folder that others may write.
        self.sockets = pathlib.Path(tempfile.mkdtemp(prefix="slurm_"))
        self.sockets.chmod(0o711)
        (self.sockets / "node").mkdir(mode=0o700)
        host = socket.gethostname().split(".")[0]
        controller_port, node_port = free_ports(2)
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=host, user=getpass.getuser(), folder=self.folder, sockets=self.sockets, controller_port=controller_port,
            node_port=node_port), encoding="utf-8")
        (self.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\nCgroupAutomount=no\n", encoding="utf-8")
        self.environment = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf"), "PATH": path_with_daemons()}
        self.start_munge()
        self.daemon("slurmctld", "slurmctld", "-D")
        self.daemon("slurmd", "slurmd", "-D", "-N", host)
        self.wait_for("the node", lambda: "idle" in self.call("sinfo", "--noheader", "--format=%T").stdout)

    def start_munge(self):
        folder = self.folder / "munge"
        key = folder / "key"
        subprocess.run(["mungekey", "--create", f"--keyfile={key}"], env=self.environment, check=True)
        munge_socket = self.sockets / "munge.socket"
        # --force: the folders above may be writable for others, as those of a build often are.
        self.daemon("munged", "munged", "--foreground", "--force", f"--key-file={key}", f"--socket={munge_socket}",
                    f"--pid-file={folder}/pid", f"--log-file={folder}/log", f"--seed-file={folder}/seed")
        self.wait_for("munge", munge_socket.exists)

    def daemon(self, name, *command):
        with open(self.folder / f"{name}.out", "w", encoding="utf-8") as output:
            process = subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL, stdout=output,
                                       stderr=subprocess.STDOUT, cwd=self.folder, preexec_fn=end_with_parent)
        self.daemons.append((name, process))

    def wait_for(self, what, met):
        end = time.monotonic() + PATIENCE
        while not met():
            for name, process in self.daemons:
                if process.poll() is not None:
                    raise CannotRun(f"{name} ended at once: {self.last_line(name)}")
            if time.monotonic() > end:
                raise CannotRun(f"{what} did not come up within {PATIENCE:.0f} s: {self.last_line('slurmd')}")
            time.sleep(0.2)

    def last_line(self, name):
        lines = (self.folder / f"{name}.out").read_text(encoding="utf-8", errors="replace").splitlines()
        return lines[-1] if lines else "no word of why"

    def stop(self):
        if self.daemons and hasattr(self, "environment"):
            self.call("scancel", "--user", getpass.getuser())
            self.call("scontrol", "shutdown")
        for _, process in reversed(self.daemons):  # munge last: the others talk through it
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.daemons = []
        if hasattr(self, "sockets"):
            shutil.rmtree(self.sockets, ignore_errors=True)

    def call(self, *command, cwd=None, **environment):
        """What the command printed; a command of Slurm that hangs is ended after ten seconds."""
        try:
            return subprocess.run(command, env={**self.environment, **environment}, cwd=cwd, stdin=subprocess.DEVNULL,
                                  capture_output=True, text=True, timeout=10)
        except subprocess.TimeoutExpired:
            return subprocess.CompletedProcess(command, 124, "", "no answer within 10 s")

    def submit(self, folder, *arguments, **environment):
        """Number of a new job that begins in `folder`."""
        outcome = self.call("sbatch", "--parsable", *arguments, cwd=folder, **environment)
        if outcome.returncode != 0:
            raise RuntimeError(f"sbatch {' '.join(arguments)}: {outcome.stderr}")
        return outcome.stdout.strip()

    def job(self, number):
        """Properties of a job as `scontrol show job` names them; of an array's last task if it is one."""
        words = self.call("scontrol", "--oneliner", "show", "job", number).stdout.split()
        return dict(word.split("=", 1) for word in words if "=" in word)
