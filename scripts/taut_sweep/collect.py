"""Joins what the runs wrote: a table of summaries, their timing, and chosen columns of the trajectories."""

import csv
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from taut_report.data import LAST_FILES, Array

from taut_sweep.case_file import plain
from taut_sweep.files import SweepError, whole
from taut_sweep.plan import Plan
from taut_sweep.store import FINISHED, RESULTS, TABLE, TIMING, TRAJECTORIES, Store, record_of
from taut_sweep.sweep_file import Quantity, Sweep

# What the timing says of a run besides.
RECORDED = ("host", "start", "end", "attempts")
# Not in the table: the name is the same in every run, and the time is different in each.
APART = ("case", "wall_seconds")


def collect(plan: Plan, store: Store, partial: bool) -> list[Path]:
    """Writes the tables and returns their paths; runs without results are refused or, if wished, left out."""
    sweep = plan.sweep
    store.scan()
    found = []
    missing = 0
    for run in plan.runs:
        folder = store.folder(run)
        record = record_of(folder, run)
        if record and record["state"] in FINISHED and (source := last_file(folder / RESULTS)):
            found.append((run, folder, [record[key] for key in RECORDED], source))
        else:
            missing += plan.first(run)
    if missing and not partial:
        raise SweepError(
            f"{missing} of {len(plan.different)} runs have no results; "
            "scripts/sweep run them, or take --partial"
        )
    if not found:
        raise SweepError("no run has results; scripts/sweep run them first")
    with ExitStack() as stack:
        paths = [store.root / TABLE, store.root / TIMING]
        table, timing = (stack.enter_context(_writer(path)) for path in paths)
        trajectories = None
        if sweep.trajectories:
            paths.append(store.root / TRAJECTORIES)
            trajectories = stack.enter_context(_writer(paths[-1]))
            trajectories.writerow(["run", *sweep.columns, "method", "t", *sweep.trajectories])
        header: list[str] | None = None
        for run, folder, times, source in found:
            names, rows = _read(source)
            if header is None:
                header = names
                check_names(sweep, names)
                kept = [name for name in names if name not in APART]
                table.writerow(["run", *sweep.columns, *kept, *(q.name for q in sweep.quantities)])
                timing.writerow(["run", "method", "wall_seconds", *RECORDED])
            elif names != header:
                raise SweepError(f"{source}: the columns are other than those of the runs before")
            parameters = [run.index, *map(plain, run.values)]
            for values in rows:
                row = dict(zip(names, values, strict=True))
                method = row.get("method", "")
                trajectory = Trajectory(folder / RESULTS / f"{method}.csv")
                numbers = [trajectory.quantity(quantity) for quantity in sweep.quantities]
                table.writerow([*parameters, *(row[name] for name in kept), *numbers])
                timing.writerow([run.index, method, row.get("wall_seconds", ""), *times])
                if trajectories:
                    for line in trajectory.rows(sweep.trajectories):
                        trajectories.writerow([*parameters, method, *line])
    return paths


class Trajectory:
    """A method's CSV file."""

    def __init__(self, path: Path) -> None:
        """Knows the path; nothing is read yet."""
        self._path = path
        self._columns: dict[str, Array] = {}

    def quantity(self, quantity: Quantity) -> str:
        """Returns a quantity as text; nothing if the run ended before its window."""
        t, values = self._column("t"), self._column(quantity.column)
        inside = (t >= quantity.start) & (t <= quantity.end)
        t, values = t[inside], values[inside]
        return repr(float(_take(quantity.take, t, values))) if t.size else ""

    def rows(self, columns: list[str]) -> Iterator[list[str]]:
        """Returns chosen columns as they are written, time first."""
        names, rows = _read(self._path)
        chosen = [self._index(names, name) for name in ("t", *columns)]
        for row in rows:
            yield [row[i] for i in chosen]

    def _column(self, name: str) -> Array:
        if name not in self._columns:
            try:
                with self._path.open(encoding="utf-8") as file:
                    names = file.readline().rstrip("\n").split(",")
                    self._columns[name] = np.loadtxt(
                        file, delimiter=",", usecols=self._index(names, name), ndmin=1, comments=None
                    )
            except (OSError, ValueError) as error:
                raise SweepError(f"{self._path}: {getattr(error, 'strerror', error)}") from None
        return self._columns[name]

    def _index(self, names: list[str], name: str) -> int:
        if name not in names:
            raise SweepError(f"{self._path}: no column '{name}'; it has {', '.join(names)}")
        return names.index(name)


def _take(take: str, t: Array, values: Array) -> Any:
    """Returns one number of a column."""
    match take:
        case "max":
            return values.max()
        case "min":
            return values.min()
        case "abs-max":
            return np.abs(values).max()
        case "max-change":
            return np.abs(values - values[0]).max()
        case "mean":
            # Over time, for steps are of different length.
            return np.trapezoid(values, t) / (t[-1] - t[0]) if t[-1] > t[0] else values.mean()
        case _:
            return values[-1]


def last_file(results: Path) -> Path | None:
    """Returns the file with one row a method (or a mode), which the programs write last."""
    paths = [results / name for name in LAST_FILES]
    return next((path for path in paths if path.is_file()), None)


def check_names(sweep: Sweep, header: list[str]) -> None:
    """Refuses names that the program's own columns have: a table has each name once."""
    for name in (*sweep.columns, *(quantity.name for quantity in sweep.quantities)):
        if name in header:
            raise SweepError(
                f"{sweep.path}: the name '{name}' is that of a column of {sweep.app}; give another"
            )


def _read(path: Path) -> tuple[list[str], list[list[str]]]:
    """Returns the header and the rows of a CSV file."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            header, *rows = list(csv.reader(file)) or [[]]
    except OSError as error:
        raise SweepError(f"{path}: {error.strerror}") from None
    if not rows or any(len(row) != len(header) for row in rows):
        raise SweepError(f"{path} is damaged: remove its folder and scripts/sweep run it again")
    return header, rows


@contextmanager
def _writer(path: Path) -> Iterator[Any]:
    """Opens a CSV file that gets its name when it is whole."""
    with whole(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        yield csv.writer(file, lineterminator="\n")
