"""Very many short runs: the program works through a batch of them in one process, and each leaves a row.

A batch is a run of the store: it has a folder, a record and a lock. Its rows come from the program one run
after the other, so that what a killed process leaves is whole up to its last run; the next one goes on there.
"""

import csv
import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from taut.files import write_whole
from taut.programs import last_line
from taut.sweep.execute import COMPLETE, INTERRUPTED, Executor, Work
from taut.sweep.plan import Run
from taut.sweep.store import CASE, ENDED_EARLY, LOG

ROWS = "rows.csv"
LIST = "runs.tsv"
# The rows of a run are never longer.
TAIL = 1 << 20
# The status of a run that took the program with it.
CRASHED = "crashed"


class BatchExecutor(Executor):
    """Runs batches."""

    def _work(self, run: Run, folder: Path, held: int, begun: bool) -> Work:  # noqa: ARG002
        """Gives the program what has no rows yet, until all has."""
        rows, first = folder / ROWS, run.first
        write_whole(folder / CASE, self.plan.blanks, sync=False)
        # What was written last before a power cut may be half of a run's rows.
        done = mend(rows, whole=False)
        code, said, started = 0, "", 0
        while (next_run := (done or first - 1) + 1) < first + run.count:
            write_whole(folder / LIST, self.plan.lines(run, next_run), sync=False)
            with rows.open("ab") as out:
                code, said = self._start(folder, held, [CASE, "--runs", LIST, "--quiet"], out)
            before, done = done, mend(rows)
            started += (done or first - 1) + 1 - next_run
            if code == INTERRUPTED or (code < 0 and self.stop.asked):
                return Work("interrupted", code, runs=started)
            if done == first + run.count - 1:
                break
            if code == 1 or (code == 0 and done == before) or not rows.stat().st_size:
                return Work("failed", code, last_line(said, code), runs=started)
            if code != 0:
                # The run behind the last row is the one that the program did not survive.
                done = (done or first - 1) + 1
                _append(rows, done, last_line(said, code))
                started += 1
        for name in (CASE, LIST, LOG):
            (folder / name).unlink(missing_ok=True)
        early, own = _told(rows)
        return Work(ENDED_EARLY if early else "done", 0, early, own_seconds=own, runs=started)

    def reached(self, run: Run) -> int:
        """Returns how many runs of a batch have rows."""
        try:
            with (self.store.folder(run) / ROWS).open("rb") as file:
                last = _last(_end_of(file))
        except OSError:
            return 0
        return last - run.first + 1 if last else 0


def read_rows(path: Path) -> Iterator[list[str]]:
    """Returns the header and the rows of a batch; each process that worked on it wrote the header anew."""
    header = None
    with path.open(encoding="utf-8", newline="") as file:
        for row in csv.reader(file):
            if row != header:
                yield row
            header = header or row


def mend(path: Path, whole: bool = True) -> int | None:
    """Cuts off a row without an end, and the last run unless all is whole; returns the last that is left."""
    try:
        with path.open("r+b") as file:
            size = file.seek(0, os.SEEK_END)
            tail = _end_of(file)
            kept = tail[: tail.rfind(b"\n") + 1]
            last = _last(kept)
            if not whole and last is not None:
                while _last(kept) == last:
                    kept = kept[: kept.rfind(b"\n", 0, -1) + 1]
                last = _last(kept)
            file.truncate(size - len(tail) + len(kept))
            return last
    except FileNotFoundError:
        return None


def _end_of(file: Any) -> bytes:
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - TAIL))
    return file.read()


def _last(lines: bytes) -> int | None:
    """Returns the run of the last row that is whole; headers do not count."""
    end = lines.rfind(b"\n")
    while end >= 0:
        start = lines.rfind(b"\n", 0, end) + 1
        name = lines[start:end].partition(b",")[0]
        if name.isdigit():
            return int(name)
        end = start - 1
    return None


def _append(path: Path, number: int, message: str) -> None:
    """Writes the row of a run that crashed."""
    header = next(read_rows(path))
    values = {"run": number, "case": Path(CASE).stem, "status": CRASHED, "message": message}
    with path.open("a", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerow([values.get(name, "") for name in header])


def _told(path: Path) -> tuple[str, float]:
    """Returns what is to be said of runs that did not reach their end, and how long all took together [s]."""
    rows = read_rows(path)
    header = next(rows)
    run, status, message, seconds = (
        header.index(name) for name in ("run", "status", "message", "wall_seconds")
    )
    total, early, example = 0.0, Counter[str](), ""
    for row in rows:
        total += float(row[seconds] or 0)
        if row[status] not in COMPLETE:
            early[row[status]] += 1
            example = example or f"run {row[run]}: {row[message]}"
    counts = ", ".join(f"{number} {name}" for name, number in early.items())
    return f"{counts}, as {example}" if early else "", total
