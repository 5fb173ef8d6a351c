"""Runs case files, several at a time: the program of cases/<name>/*.nml is <name>."""

import os
import subprocess
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from taut.errors import TautError
from taut.programs import ONE_THREAD, last_line
from taut.report.methods.measures import CASES as SIDE_BY_SIDE

# What takes longest, explicit steps of fine meshes, begins first: all else is done beside it.
LONGEST = ("mesh64", "mesh32")
# Cases whose runs may end before their time: how each one ended is a result, which the report reads.
ENDS_ARE_RESULTS = frozenset(SIDE_BY_SIDE)


@dataclass(frozen=True)
class Job:
    """A case file and the program that runs it."""

    program: Path
    case: Path

    @property
    def name(self) -> str:
        """The case as messages name it, such as pendulum/figure1."""
        return f"{self.case.parent.name}/{self.case.stem}"


def find(folder: Path, programs: Path) -> list[Job]:
    """Returns the jobs for all case files below a folder; those that take longest come first."""
    paths = sorted(folder.glob("*/*.nml"), reverse=True)
    paths.sort(key=lambda path: LONGEST.index(path.stem) if path.stem in LONGEST else len(LONGEST))
    jobs = [Job(programs / path.parent.name, path) for path in paths]
    if not jobs:
        raise TautError(f"{folder} has no case files (*/*.nml)")
    seen: dict[str, Job] = {}
    for job in jobs:
        if not os.access(job.program, os.X_OK):
            raise TautError(f"{job.case} needs the program {job.program}, which has not been built")
        # Results go to <out>/<case>, whatever the program.
        other = seen.setdefault(job.case.stem, job)
        if other is not job:
            raise TautError(f"{other.case} and {job.case} would write to the same folder: rename one")
    return jobs


def run_all(jobs: Sequence[Job], out: Path, workers: int, tell: Callable[[int, Job], None]) -> None:
    """Runs the jobs, tells after each one how many are done, and stops at the first that fails."""
    with ThreadPoolExecutor(max_workers=workers) as pool:
        futures = {pool.submit(_run, job, out): job for job in jobs}
        try:
            for done, future in enumerate(as_completed(futures), start=1):
                future.result()
                tell(done, futures[future])
        except BaseException:
            # What runs already is waited for, the rest is not begun.
            pool.shutdown(cancel_futures=True)
            raise


def _run(job: Job, out: Path) -> None:
    """Runs one case; its error is the program's last line, or its exit code if it says nothing."""
    command = [str(job.program.resolve()), str(job.case), "--out", str(out), "--quiet"]
    environment = os.environ | ONE_THREAD
    begun = time.time_ns()
    ended = subprocess.run(
        command, capture_output=True, text=True, errors="replace", env=environment, check=False
    )
    if ended.returncode != 0 and not _has_told(job, out, begun):
        said = last_line(ended.stderr.strip() or ended.stdout, ended.returncode)
        raise TautError(f"{job.case} failed: {said}")


def _has_told(job: Job, out: Path, begun: int) -> bool:
    """Returns whether a case that may end early has written, since, how each of its methods ended."""
    summary = out / job.case.stem / "summary.csv"
    return job.case.stem in ENDS_ARE_RESULTS and summary.is_file() and summary.stat().st_mtime_ns >= begun
