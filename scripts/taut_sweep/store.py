"""Where a sweep keeps what: one folder a run, found by its hash, and the records and locks in it."""

import fcntl
import filecmp
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from taut_sweep.files import read_json, whole, write_json
from taut_sweep.plan import Plan, Run
from taut_sweep.program import Program

CASE = "case.nml"
RECORD = "record.json"
LOCK = "lock"
LOG = "stderr.log"
# The program writes its results to a folder of the case's name.
RESULTS = "case"
CHECKPOINT = f"{RESULTS}/checkpoint.taut"
STATES = ("done", "running", "failed", "killed", "interrupted", "missing")


class Store:
    """The folder of a sweep: results/sweeps/<name>."""

    def __init__(self, results: Path, name: str) -> None:
        """Knows the folder; nothing is written yet."""
        self.root = results / "sweeps" / name
        self.runs = self.root / "runs"
        self._names: dict[str, str] = {}

    def program(self) -> Program | None:
        """Returns the program that the runs were made with; None before the first."""
        said = read_json(self.root / "program.json")
        return Program(Path(said["path"]), said["version"]) if said else None

    def prepare(self, plan: Plan, program: Program) -> Program:
        """Makes the folders, copies the program and puts folders of earlier plans in order; returns the copy.

        The copy outlives builds that happen while the sweep runs, and the nodes of a cluster find it.
        """
        own = self.root / "bin" / program.path.name
        own.parent.mkdir(parents=True, exist_ok=True)
        self.runs.mkdir(exist_ok=True)
        if not own.exists() or not filecmp.cmp(program.path, own, shallow=False):
            with whole(own) as part:
                shutil.copy(program.path, part)
        copied = Program(own.resolve(), program.version)
        if self.program() != copied:
            write_json(self.root / "program.json", {"path": str(copied.path), "version": copied.version})
        self.scan()
        for run in plan.runs:
            name = self._names.get(run.id)
            if name and name != run.name:
                with lock(self.runs / name) as held:
                    if held is not None:
                        os.rename(self.runs / name, self.runs / run.name)
                        self._names[run.id] = run.name
        return copied

    def scan(self) -> None:
        """Looks once which folders there are, instead of once a run."""
        try:
            names = sorted(entry.name for entry in os.scandir(self.runs))
        except FileNotFoundError:
            names = []
        self._names = {name.rpartition("-")[2]: name for name in names}

    def others(self, plan: Plan) -> int:
        """Returns how many folders are of no run of the plan."""
        return len(self._names.keys() - {run.id for run in plan.runs})

    def folder(self, run: Run) -> Path:
        """Returns where a run is or will be."""
        return self.runs / self._names.get(run.id, run.name)


@contextmanager
def lock(folder: Path) -> Iterator[int | None]:
    """Holds the lock of a run's folder, or gives None if another process does.

    The kernel drops it when the last process that has it open ends: this one and the program it starts.
    """
    handle = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield None
        else:
            yield handle
    finally:
        os.close(handle)


def is_locked(folder: Path) -> bool:
    """Returns whether a process holds the lock of a run's folder."""
    try:
        handle = os.open(folder / LOCK, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(handle)
    return False


def record_of(folder: Path, run: Run) -> dict[str, Any] | None:
    """Returns the record of a run; None if there is none, or one of other inputs."""
    record = read_json(folder / RECORD)
    return record if record and record.get("hash") == run.hash else None


def state_of(folder: Path, run: Run) -> str:
    """Returns the state of a run, from its record and its lock alone."""
    record = record_of(folder, run)
    if record is None:
        return "missing"
    if record["state"] == "running":
        return "running" if is_locked(folder) else "killed"
    return record["state"]
