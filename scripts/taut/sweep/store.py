"""Where a sweep keeps what: one folder a run, found by its hash, and the records and locks in it."""

import fcntl
import filecmp
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from taut.errors import TautError
from taut.files import read_json, whole, write_json
from taut.programs import Program
from taut.sweep.plan import Plan, Run

CASE = "case.nml"
RECORD = "record.json"
LOCK = "lock"
LOG = "stderr.log"
# The program writes its results to a folder of the case's name.
RESULTS = "case"
# What is made of all runs.
TABLE = "table.csv"
TIMING = "timing.csv"
TRAJECTORIES = "trajectories.csv"
CHECKPOINT = f"{RESULTS}/checkpoint.taut"
# An integration that ended early would end there again: its results are as good as any.
ENDED_EARLY = "ended early"
FINISHED = ("done", ENDED_EARLY)
STATES = (*FINISHED, "running", "failed", "killed", "interrupted", "missing")


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

    def check_owner(self, sweep: Path) -> None:
        """Refuses a folder that belongs to another sweep file of the same name."""
        owner = (read_json(self.root / "program.json") or {}).get("sweep")
        # One that is no longer there was moved, and this is it.
        if owner and Path(owner).exists() and not Path(owner).samefile(sweep):
            raise TautError(
                f"{self.root} belongs to {owner}; rename {sweep.name}, or take another folder with --results"
            )

    def prepare(self, plan: Plan, program: Program) -> Program:
        """Makes the sweep's folder and copies the program to it; returns the copy.

        The copy outlives builds that happen while the sweep runs, and the nodes of a cluster find it.
        """
        own = self.root / "bin" / program.path.name
        own.parent.mkdir(parents=True, exist_ok=True)
        self.runs.mkdir(exist_ok=True)
        for name, content in plan.tables.contents.items():
            table = self.root / plan.tables.FOLDER / name
            table.parent.mkdir(exist_ok=True)
            if not table.exists():
                with whole(table) as part:
                    part.write_bytes(content)
        if not own.exists() or not filecmp.cmp(program.path, own, shallow=False):
            with whole(own) as part:
                shutil.copy(program.path, part)
        copied = Program(own.resolve(), program.version)
        facts = {
            "path": str(copied.path),
            "version": copied.version,
            "sweep": str(plan.sweep.path.resolve()),
        }
        if read_json(self.root / "program.json") != facts:
            write_json(self.root / "program.json", facts)
        return copied

    @contextmanager
    def at_work(self, runs: list[Run]) -> Iterator[None]:
        """Makes the folders of some runs, and keeps all folders' names as they are for as long as it lasts.

        The index in a name is that of the latest plan. While another process works on the sweep nothing is
        renamed: its plan may be another one, but both find a run by its hash, whatever its index.
        """
        with _opened(self.root / "folders.lock") as making, _opened(self.root / "work.lock") as working:
            fcntl.flock(making, fcntl.LOCK_EX)
            alone = _locked(working, fcntl.LOCK_EX)
            self.scan()
            for run in runs:
                name = self._names.setdefault(run.id, run.name)
                if alone and name != run.name and self._renamed(name, run.name):
                    self._names[run.id] = run.name
                self.folder(run).mkdir(exist_ok=True)
            fcntl.flock(working, fcntl.LOCK_SH)
            fcntl.flock(making, fcntl.LOCK_UN)
            yield

    def _renamed(self, name: str, new: str) -> bool:
        """Renames a folder unless its program still runs or the name is taken."""
        with lock(self.runs / name) as held:
            if held is None or (self.runs / new).exists():
                return False
            os.rename(self.runs / name, self.runs / new)
            return True

    def scan(self) -> None:
        """Looks once which folders there are, instead of once a run."""
        try:
            names = sorted(entry.name for entry in os.scandir(self.runs))
        except FileNotFoundError:
            names = []
        self._names = {}
        for name in names:
            known = self._names.setdefault(name.rpartition("-")[2], name)
            # Of two of the same hash the one that is further.
            if known != name and self._progress(name) > self._progress(known):
                self._names[name.rpartition("-")[2]] = name

    def _progress(self, name: str) -> int:
        """Returns how far a folder is: finished, running, begun, or not."""
        record = read_json(self.runs / name / RECORD)
        if record and record.get("state") in FINISHED:
            return 3
        return 2 if is_locked(self.runs / name) else int(record is not None)

    def others(self, plan: Plan) -> int:
        """Returns how many folders are of no run of the plan."""
        return len(self._names.keys() - {run.id for run in plan.runs})

    def folder(self, run: Run) -> Path:
        """Returns where a run is or will be."""
        return self.runs / self._names.get(run.id, run.name)


@contextmanager
def _opened(path: Path) -> Iterator[int]:
    """Opens a file to be locked; closing it drops the lock."""
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        yield handle
    finally:
        os.close(handle)


def _locked(handle: int, kind: int) -> bool:
    """Locks an open file if no other process keeps it from that; returns whether it did."""
    try:
        fcntl.flock(handle, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


@contextmanager
def lock(folder: Path) -> Iterator[int | None]:
    """Holds the lock of a run's folder, or gives None if another process does.

    The kernel drops it when the last process that has it open ends: this one and the program it starts.
    """
    with _opened(folder / LOCK) as handle:
        yield handle if _locked(handle, fcntl.LOCK_EX) else None


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
