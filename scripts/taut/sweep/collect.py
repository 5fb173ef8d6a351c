"""Joins what the runs wrote: a table of summaries, their timing, and chosen columns of the trajectories."""

import csv
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from taut.case_file import plain
from taut.errors import TautError
from taut.files import whole
from taut.results import Array, Run, last_file, read_run, read_table
from taut.sweep.batch import ROWS, read_rows
from taut.sweep.plan import Plan
from taut.sweep.store import FINISHED, RESULTS, TABLE, TIMING, TRAJECTORIES, Store, record_of
from taut.sweep.sweep_file import Quantity, Sweep

# What the timing says of a run besides.
RECORDED = ("host", "start", "end", "attempts")
# Not in the table: the name is the same in every run, and the time is different in each.
APART = ("case", "wall_seconds")
AGAIN = "remove its folder and scripts/sweep run it again"


def collect(plan: Plan, store: Store, partial: bool) -> list[Path]:
    """Writes the tables and returns their paths; runs without results are refused or, if wished, left out."""
    sweep = plan.sweep
    store.scan()
    found = []
    missing = 0
    for run in plan.runs:
        folder = store.folder(run)
        record = record_of(folder, run)
        source = folder / ROWS if sweep.rows_only else last_file(folder / RESULTS)
        if record and record["state"] in FINISHED and source and source.is_file():
            found.append((run, folder, [record[key] for key in RECORDED], source))
        else:
            missing += plan.first(run)
    if missing and not partial:
        raise TautError(
            f"{missing} of {plan.counted(len(plan.different))} have no results; "
            "scripts/sweep run them, or take --partial"
        )
    if not found:
        raise TautError("no run has results; scripts/sweep run them first")
    if sweep.rows_only:
        return _join(plan, store, [(source, times) for _, _, times, source in found])
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
            summary = read_table(source, remedy=AGAIN)
            names = summary.header
            if header is None:
                header = names
                check_names(sweep, names)
                kept = columns_kept(sweep, names)
                table.writerow(["run", *sweep.columns, *kept, *(q.name for q in sweep.quantities)])
                timing.writerow(["run", "method", "wall_seconds", *RECORDED])
            elif names != header:
                raise TautError(f"{source}: the columns are other than those of the runs before")
            parameters = [run.index, *map(plain, run.values)]
            for row in summary.records():
                method = row.get("method", "")
                path = folder / RESULTS / f"{method}.csv"
                numbers = [
                    _extreme(row, quantity)
                    if quantity.of_steps
                    else _number(read_run(path, remedy=AGAIN), quantity)
                    for quantity in sweep.quantities
                ]
                table.writerow([*parameters, *(row[name] for name in kept), *numbers])
                timing.writerow([run.index, method, row.get("wall_seconds", ""), *times])
                if trajectories:
                    for line in _lines(path, sweep.trajectories):
                        trajectories.writerow([*parameters, method, *line])
    return paths


def _join(plan: Plan, store: Store, batches: list[tuple[Path, list[Any]]]) -> list[Path]:
    """Writes the table and the timing of runs that left rows only."""
    paths = [store.root / TABLE, store.root / TIMING]
    with ExitStack() as stack:
        table, timing = (stack.enter_context(_writer(path)) for path in paths)
        header: list[str] | None = None
        for source, times in batches:
            rows = read_rows(source)
            names = next(rows)
            if header is None:
                header = names
                check_names(plan.sweep, names)
                kept = [names.index(name) for name in columns_kept(plan.sweep, names) if name != "run"]
                index, method, seconds = (names.index(name) for name in ("run", "method", "wall_seconds"))
                quantities = plan.sweep.quantities
                table.writerow(
                    ["run", *plan.sweep.columns, *(names[i] for i in kept), *(q.name for q in quantities)]
                )
                timing.writerow(["run", "method", "wall_seconds", *RECORDED])
            elif names != header:
                raise TautError(f"{source}: the columns are other than those of the batches before")
            for row in rows:
                parameters = map(plain, plan.rows[int(row[index]) - 1])
                numbers = [_extreme(dict(zip(names, row, strict=True)), quantity) for quantity in quantities]
                table.writerow([row[index], *parameters, *(row[i] for i in kept), *numbers])
                timing.writerow([row[index], row[method], row[seconds], *times])
    return paths


def columns_kept(sweep: Sweep, names: list[str]) -> list[str]:
    """Returns the columns of a summary that the table has as they are."""
    apart = {*APART, *(name for q in sweep.quantities if q.of_steps for name in q.told.values())}
    return [name for name in names if name not in apart]


def _extreme(row: dict[str, str], quantity: Quantity) -> str:
    """Returns an extreme as text; nothing if the run ended before its window."""
    low, high = row[quantity.told["min"]], row[quantity.told["max"]]
    if not low or not high:
        return ""
    match quantity.take:
        case "min":
            return repr(float(low))
        case "max":
            return repr(float(high))
        case _:
            return repr(max(-float(low), float(high)))


def _number(run: Run, quantity: Quantity) -> str:
    """Returns a quantity as text; nothing if the run ended before its window."""
    t, values = run["t"], run[quantity.column]
    inside = (t >= quantity.start) & (t <= quantity.end)
    t, values = t[inside], values[inside]
    return repr(float(_take(quantity.take, t, values))) if t.size else ""


def _lines(path: Path, columns: list[str]) -> Iterator[tuple[str, ...]]:
    """Returns the rows of chosen columns as they are written, time first."""
    table = read_table(path, remedy=AGAIN)
    return zip(*(table.column(name) for name in ("t", *columns)), strict=True)


def _take(take: str, t: Array, values: Array) -> Any:
    """Returns one number of a column."""
    match take:
        case "max-change":
            return np.abs(values - values[0]).max()
        case "mean":
            # Over time, for steps are of different length.
            return np.trapezoid(values, t) / (t[-1] - t[0]) if t[-1] > t[0] else values.mean()
        case _:
            return values[-1]


def check_names(sweep: Sweep, header: list[str]) -> None:
    """Refuses names that the program's own columns have: a table has each name once."""
    for name in (*sweep.columns, *(quantity.name for quantity in sweep.quantities)):
        if name in header:
            raise TautError(
                f"{sweep.path}: the name '{name}' is that of a column of {sweep.app}; give another"
            )


@contextmanager
def _writer(path: Path) -> Iterator[Any]:
    """Opens a CSV file that gets its name when it is whole."""
    with whole(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        yield csv.writer(file, lineterminator="\n")
