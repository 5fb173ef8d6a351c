"""A real Slurm of one node on the loopback address, in a folder of its own, from Debian's packages."""

import contextlib
import os
import pwd
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import debian
from debian import PATH

# Seconds. Slurm looks for what it may have missed once a minute, and the machine may be busy.
PATIENCE = 180
PACKAGES = ("slurm-wlm", "munge")
PROGRAMS = ("munged", "mungekey", "slurmctld", "slurmd", "sbatch", "scancel", "scontrol", "sinfo", "squeue")

# No cgroups, no accounting, and none of a real cluster's patience: a container has no service manager, and
# the tests have no time. cred_expire is also how long a requeued job waits before it may start again.
CONFIGURATION = """\
ClusterName=taut
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control_port}
SlurmdPort={node_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc={folder}/jobs.txt
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=bf_interval=1,sched_interval=1,batch_sched_delay=0
SlurmdParameters=config_overrides
PropagateResourceLimits=NONE
MaxArraySize={array_size}
MaxJobCount=10000
JobRequeue=1
ReturnToService=2
SlurmdTimeout=30
MessageTimeout=5
KillWait=2
InactiveLimit=0
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class NoSlurmError(Exception):
    """Slurm cannot be had on this machine; says why."""


class Cluster:
    """A running Slurm; `environment` is what its commands need."""

    def __init__(self, folder: Path, array_size: int = 1001, cpus: int = 2) -> None:
        self.folder = folder
        self.environment = os.environ | {"PATH": PATH, "SLURM_CONF": str(folder / "slurm.conf")}
        self.host = socket.gethostname().split(".")[0]
        self._daemons: dict[str, subprocess.Popen[bytes]] = {}
        for name in ("state", "spool"):
            (folder / name).mkdir()
        self.ports = free_ports(2)
        (folder / "slurm.conf").write_text(
            CONFIGURATION.format(
                host=self.host,
                user=pwd.getpwuid(os.getuid()).pw_name,
                folder=folder,
                control_port=self.ports[0],
                node_port=self.ports[1],
                array_size=array_size,
                cpus=cpus,
            ),
            encoding="utf-8",
        )
        (folder / "cgroup.conf").write_text(f"CgroupPlugin={cgroup_plugin()}\n", encoding="utf-8")

    def start(self) -> None:
        """Starts the daemons and waits until the node takes jobs."""
        folder = self.folder
        self.command("mungekey", "--create", f"--keyfile={folder}/munge.key")
        # Without an origin, munged would ask for the address of a host name that may have none.
        names = {
            "key-file": "key",
            "socket": "socket",
            "pid-file": "pid",
            "log-file": "log",
            "seed-file": "seed",
        }
        files = [f"--{option}={folder}/munge.{name}" for option, name in names.items()]
        self._start("munged", "--foreground", "--force", "--origin=127.0.0.1", *files)
        self._wait("munged", (folder / "munge.socket").exists)
        self._start("slurmctld", "-D")
        self.start_node()

    def start_node(self) -> None:
        """Starts the node's daemon, also after it died, and waits until the node takes jobs."""
        self._start("slurmd", "-D")
        self._wait("slurmd", self._takes_jobs)

    def kill_node(self) -> None:
        """Kills the node's daemon and all that runs under it, as a power cut does."""
        self._end("slurmd", signal.SIGKILL)
        self._kill_jobs()
        # What Slurm does by itself after SlurmdTimeout; it requeues the jobs.
        self.command("scontrol", "update", f"NodeName={self.host}", "State=DOWN", "Reason=died")

    def processes(self) -> list[int]:
        """Returns the ids of the processes that jobs run, without Slurm's own."""
        marks = (f"SLURM_CONF={self.folder}/slurm.conf\0".encode(), b"\0SLURM_JOB_ID=")
        found = []
        for path in Path("/proc").glob("[0-9]*/environ"):
            with contextlib.suppress(OSError):
                if all(mark in path.read_bytes() for mark in marks):
                    found.append(int(path.parent.name))
        return found

    def _kill_jobs(self) -> None:
        # Those who would report the death of a job first: nobody tells Slurm of a power cut.
        for pid in [*self._step_daemons(), *self.processes()]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)

    def _step_daemons(self) -> list[int]:
        """Returns the ids of Slurm's own processes beside each job, which outlive the node's daemon."""
        found = []
        for path in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                ours = (path / "cwd").readlink() == self.folder
                if ours and (path / "exe").readlink().name.startswith("slurmstepd"):
                    found.append(int(path.name))
        return found

    def command(self, *words: str) -> str:
        """Runs one of Slurm's commands and returns what it says."""
        done = subprocess.run(
            words, env=self.environment, capture_output=True, text=True, check=False, timeout=60
        )
        if done.returncode:
            raise NoSlurmError(f"{words[0]} says: {done.stderr.strip() or done.stdout.strip()}")
        return done.stdout

    def empty(self) -> None:
        """Cancels all jobs and waits until they are gone."""
        if self.command("squeue", "--noheader"):
            self.command("scancel", "--full", "--signal=KILL", f"--user={os.getuid()}")
            self.command("scancel", f"--user={os.getuid()}")
            wait(lambda: not self.command("squeue", "--noheader"))

    def stop(self) -> None:
        """Cancels all jobs and ends the daemons; nothing is left running."""
        if "slurmctld" in self._daemons:
            with contextlib.suppress(NoSlurmError, subprocess.TimeoutExpired, AssertionError):
                self.empty()
        self._kill_jobs()
        for name in ("slurmd", "slurmctld", "munged"):
            self._end(name, signal.SIGTERM)

    def _start(self, name: str, *arguments: str) -> None:
        # The kernel ends the daemons even when the tests are killed.
        words = ["setpriv", "--pdeathsig", "KILL", name, *arguments]
        with (self.folder / f"{name}.out").open("ab") as out:
            self._daemons[name] = subprocess.Popen(
                words, env=self.environment, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=out, stderr=out
            )

    def _end(self, name: str, number: signal.Signals) -> None:
        if not (daemon := self._daemons.pop(name, None)):
            return
        daemon.send_signal(number)
        try:
            daemon.wait(10)
        except subprocess.TimeoutExpired:
            daemon.kill()
            daemon.wait()

    def _wait(self, name: str, ready: Callable[[], bool]) -> None:
        """Waits for something that a daemon does; tells its last words when it does not come."""

        def or_dead() -> bool:
            return self._daemons[name].poll() is not None or ready()

        try:
            wait(or_dead)
            if self._daemons[name].poll() is None:
                return
        except AssertionError:
            pass
        said = [(self.folder / f"{name}.{end}") for end in ("out", "log")]
        lines = [
            line for path in said if path.exists() for line in path.read_text(errors="replace").splitlines()
        ]
        raise NoSlurmError(f"{name} does not start: " + " | ".join(lines[-5:]))

    def _takes_jobs(self) -> bool:
        try:
            state = self.command("sinfo", "--noheader", "--format=%t").strip()
        except NoSlurmError:
            return False
        return state in ("idle", "mix", "alloc")


@contextlib.contextmanager
def running_cluster(array_size: int = 1001, cpus: int = 2) -> Iterator[Cluster]:
    """A cluster that is started, and stopped whatever happens."""
    install()
    # Not pytest's folder: the name of a socket is at most 107 characters.
    folder = Path(tempfile.mkdtemp(prefix="taut-slurm-", dir="/tmp"))
    cluster = Cluster(folder, array_size, cpus)
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()
        shutil.rmtree(folder, ignore_errors=True)


def wait(ready: Callable[[], bool], every: float = 0.1) -> None:
    """Waits until something is so; gives up when even a machine under load would be done."""
    end = time.monotonic() + PATIENCE
    while not ready():
        assert time.monotonic() < end, f"waited {PATIENCE} s in vain"
        time.sleep(every)


def cgroup_plugin() -> str:
    """Returns what keeps this version from using cgroups: the old plugin does nothing until asked."""
    said = subprocess.run(
        ["slurmd", "-V"], env=os.environ | {"PATH": PATH}, capture_output=True, text=True, check=False
    )
    version = tuple(map(int, said.stdout.split()[-1].split(".")[:2]))
    return "disabled" if version >= (23, 11) else "cgroup/v1"


def free_ports(number: int) -> list[int]:
    """Returns ports that nobody listens at."""
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(number)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


def install() -> None:
    """Installs Slurm where it is missing, and starts none of its services."""
    if not missing():
        return
    try:
        with no_services():
            debian.install(*PACKAGES)
    except debian.NoPackageError as why:
        raise NoSlurmError(f"there is no {missing()[0]}: {why}") from None
    if missing():
        raise NoSlurmError(f"there is no {missing()[0]} in {' and '.join(PACKAGES)}")


def missing() -> list[str]:
    """Returns the programs that are not there."""
    return [name for name in PROGRAMS if not shutil.which(name, path=PATH)]


@contextlib.contextmanager
def no_services() -> Iterator[None]:
    """Tells Debian not to start what it installs; a policy of the machine's own is left alone."""
    policy = Path("/usr/sbin/policy-rc.d")
    if policy.exists() or os.getuid() != 0:
        yield
        return
    policy.write_text("#!/bin/sh\nexit 101\n")
    policy.chmod(0o755)
    try:
        yield
    finally:
        policy.unlink(missing_ok=True)
