"""What is known before the runs: whether the program takes the case, and which columns will come of it."""

import math
import os
import subprocess
import tempfile
from pathlib import Path

import f90nml

from taut.case_file import parse
from taut.errors import TautError
from taut.programs import ONE_THREAD, Program, check_case, help_of
from taut.results import last_file, read_table
from taut.sweep.collect import check_names, columns_kept
from taut.sweep.plan import Plan
from taut.sweep.store import CASE, RESULTS
from taut.sweep.sweep_file import Sweep

# A trial that takes longer is given up [s].
TRIAL = 30.0


def check(plan: Plan, program: Program) -> None:
    """Refuses what the program has against the first case, and columns that its results will not have.

    So a misspelt entry is said once and not by each run, and a misspelt column before all runs and not after.
    """
    sweep = plan.sweep
    if sweep.rows_only and "--runs" not in help_of(program.path):
        raise TautError(f"{sweep.path}: keep = 'rows' needs an app that takes --runs; {sweep.app} does not")
    text = plan.trial
    if said := check_case(program.path, text, sweep.options):
        # The groups &extreme are the sweep's own.
        if "no group &extreme" in said:
            raise TautError(f"{sweep.path}: [collect]: {sweep.app} writes no trajectories; leave it out")
        which = [q.name for q in sweep.quantities if q.of_steps and f'no column "{q.column}"' in said]
        if which:
            raise TautError(f"{sweep.path}: [collect] {which[0]}: {said}")
        raise TautError(f"{sweep.path}: run 1 is refused: {said}")
    if sweep.quantities or sweep.trajectories or sweep.plots:
        case = parse(text, "run 1")
        _check_windows(plan, case)
        with tempfile.TemporaryDirectory() as folder:
            _try(program, case, Path(folder))
            _check_columns(sweep, Path(folder) / RESULTS)


def _check_windows(plan: Plan, case: f90nml.Namelist) -> None:
    """Refuses a window in time that the runs do not reach."""
    times = case.get("integration", {})
    if plan.varies("integration", "t_start") or plan.varies("integration", "t_end"):
        return
    begin, end = times.get("t_start", 0.0), times.get("t_end", math.inf)
    for quantity in plan.sweep.quantities:
        where = f"{plan.sweep.path}: [collect] {quantity.name}:"
        if quantity.start > end:
            raise TautError(f"{where} from = {quantity.start} is after the end, t_end = {end}")
        if quantity.end < begin:
            raise TautError(f"{where} to = {quantity.end} is before the beginning, t_start = {begin}")


def _try(program: Program, case: f90nml.Namelist, folder: Path) -> None:
    """Runs a case for one step; whatever this comes to, the columns are known if there are any."""
    short = f90nml.Namelist(case)
    short["integration"] = f90nml.Namelist(case.get("integration", {}), max_steps=1)
    if check_case(program.path, str(short)) is not None:
        # A program that does not integrate has no such group, and is short.
        short = case
    (folder / CASE).write_text(f"{short}\n", encoding="utf-8")
    command = [program.path, CASE, "--out", ".", "--quiet"]
    try:
        subprocess.run(
            command, cwd=folder, capture_output=True, env=os.environ | ONE_THREAD, timeout=TRIAL, check=False
        )
    except subprocess.TimeoutExpired:
        return


def _check_columns(sweep: Sweep, results: Path) -> None:
    """Refuses columns that the results of a trial do not have."""
    source = last_file(results)
    if source is None:
        return
    summary = read_table(source, rows_needed=False)
    header = summary.header
    check_names(sweep, header)
    rest = [quantity for quantity in sweep.quantities if not quantity.of_steps]
    wanted = {f"[collect] {quantity.name}": quantity.column for quantity in rest}
    wanted |= {f"[collect] trajectories, {name}": name for name in sweep.trajectories}
    if wanted and "method" not in header:
        raise TautError(
            f"{sweep.path}: [collect]: {sweep.app} writes no trajectories; its table has {', '.join(header)}"
        )
    for method in summary.column("method") if wanted else []:
        path = results / f"{method}.csv"
        if not path.is_file():
            continue
        columns = read_table(path, rows_needed=False).header
        for where, column in wanted.items():
            if column not in columns:
                raise TautError(
                    f"{sweep.path}: {where}: '{method}' has no column '{column}'; it has {', '.join(columns)}"
                )
    table = ["run", *sweep.columns, *columns_kept(sweep, header)]
    table += [quantity.name for quantity in sweep.quantities]
    over_time = ["run", *sweep.columns, "method", "t", *sweep.trajectories]
    for plot in sweep.plots:
        columns = over_time if plot.over_time else table
        for name in plot.columns:
            if name not in columns:
                raise TautError(
                    f"{sweep.path}: [[plot]] {plot.name}: there is no column '{name}'; "
                    f"there are {', '.join(columns)}"
                )
