"""The command line: scripts/sweep plan|run|status|collect|plot|work SWEEP."""

import argparse
import shlex
import sys
from collections import Counter
from pathlib import Path

from taut import programs
from taut.case_file import plain
from taut.errors import TautError
from taut.formats import count_of
from taut.programs import cores
from taut.sweep import arrays, sweep_file
from taut.sweep.batch import BatchExecutor
from taut.sweep.check import check
from taut.sweep.execute import INTERRUPTED, Executor
from taut.sweep.local import Report, run_all
from taut.sweep.plan import Plan
from taut.sweep.store import FINISHED, STATES, TABLE, Store, state_of

SHOWN = 5
RESULTS = Path("results")
FORMATS = ("png", "pdf", "svg")


def main(arguments: list[str] | None = None) -> int:
    """Does what the command line asks for."""
    words = sys.argv[1:] if arguments is None else arguments
    end = words.index("--") if "--" in words else len(words)
    asked = _parser().parse_args(words[:end])
    asked.options = words[end + 1 :]
    try:
        if asked.options and not getattr(asked, "slurm", False):
            raise TautError("options after -- are for sbatch; they go with run --slurm")
        if getattr(asked, "runs_per_task", None) and not asked.slurm:
            raise TautError("--runs-per-task is of Slurm's tasks; it goes with run --slurm")
        return asked.command(asked)
    except TautError as error:
        print(f"sweep: {error}", file=sys.stderr)
    except KeyboardInterrupt:
        return 130
    except OSError as error:
        print(f"sweep: {error.filename}: {error.strerror}", file=sys.stderr)
    return 1


def plan(asked: argparse.Namespace) -> int:
    """Says how many runs there are and shows the first."""
    sweep = sweep_file.read(asked.sweep)
    program = programs.find(sweep.app)
    planned = Plan(sweep, program.version)
    check(planned, program)
    print(f"{sweep.name}: {planned.size} of {sweep.app} with {sweep.case}")
    table = [["run", *sweep.columns]]
    table += [[str(i), *map(plain, row)] for i, row in enumerate(planned.rows[:SHOWN], start=1)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for row in table:
        print("  " + "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)))
    if len(planned.rows) > SHOWN:
        print("  ...")
    return 0


def run(asked: argparse.Namespace) -> int:
    """Runs what is not done, on this machine or as job arrays of Slurm."""
    sweep = sweep_file.read(asked.sweep)
    program = programs.find(sweep.app)
    planned = Plan(sweep, program.version)
    check(planned, program)
    store = Store(asked.results, sweep.name)
    store.check_owner(sweep.path)
    program = store.prepare(planned, program)
    with store.at_work(planned.different):
        if asked.slurm:
            arrays.submit(planned, store, asked.runs_per_task, asked.options)
            return 0
        todo = [one for one in planned.different if state_of(store.folder(one), one) not in FINISHED]
        if not todo:
            print(f"{sweep.name}: {planned.size}, nothing left to do")
        report = run_all(executor(planned, store, program), todo, asked.jobs, patient=True)
    tell(report)
    return finish(planned, report, call(asked, "run"), 130)


def work(asked: argparse.Namespace) -> int:
    """Runs some runs one after the other, as a task of a cluster's job does; `run` has prepared them."""
    planned, store, program = prepared(asked)
    first, last = asked.runs
    if not 1 <= first <= last <= len(planned.runs):
        raise TautError(f"--runs {first}:{last}: there are runs 1 to {len(planned.runs)}")
    runs = planned.runs[first - 1 : last]
    with store.at_work(runs):
        report = run_all(executor(planned, store, program), runs, 1, patient=False)
    tell(report)
    return finish(planned, report, "the same again", INTERRUPTED)


def status(asked: argparse.Namespace) -> int:
    """Counts the runs by state, from their records and locks alone; Slurm, if there, tells of its tasks."""
    planned, store, program = prepared(asked)
    counts = count(planned, store)
    others = store.others(planned)
    kept = f" ({count_of(others, 'folder')} of other inputs)" if others else ""
    shown = [name for name in STATES if counts[name] or name in ("done", "running", "failed", "missing")]
    print(
        f"{planned.sweep.name}: {planned.size}: "
        + ", ".join(f"{counts[name]} {name}" for name in shown)
        + kept
    )
    if planned.sweep.rows_only:
        reached = executor(planned, store, program).reached
        made = sum(map(reached, planned.different))
        print(f"{made} of {count_of(len(planned.rows), 'run')} have rows")
    for line in arrays.told(planned, store):
        print(line)
    return 0


def collect(asked: argparse.Namespace) -> int:
    """Writes the tables."""
    from taut.sweep.collect import collect

    planned, store, _ = prepared(asked)
    for path in collect(planned, store, asked.partial):
        print(path)
    return 0


def plot(asked: argparse.Namespace) -> int:
    """Draws the figures of the sweep file from the tables alone; a wrong one does not stop the others."""
    from taut.sweep.plot import draw

    sweep = sweep_file.read(asked.sweep)
    store = Store(asked.results, sweep.name)
    store.check_owner(sweep.path)
    if not sweep.plots:
        raise TautError(f"{sweep.path} has no [[plot]]")
    if not (store.root / TABLE).is_file():
        raise TautError(f"{store.root / TABLE} is missing: {call(asked, 'collect')} first")
    code = 0
    for one in sweep.plots:
        try:
            print(draw(sweep, one, store.root, asked.format))
        except TautError as error:
            print(f"sweep: {error}", file=sys.stderr)
            code = 1
    return code


def executor(planned: Plan, store: Store, program: programs.Program) -> Executor:
    """Returns what runs the sweep's runs: each for itself, or in batches."""
    return (BatchExecutor if planned.sweep.rows_only else Executor)(planned, store, program)


def prepared(asked: argparse.Namespace) -> tuple[Plan, Store, programs.Program]:
    """Returns the plan with the program that the runs were made with."""
    sweep = sweep_file.read(asked.sweep)
    store = Store(asked.results, sweep.name)
    store.check_owner(sweep.path)
    program = store.program()
    if program is None:
        raise TautError(f"{store.root} has no runs; {call(asked, 'run')} first")
    store.scan()
    return Plan(sweep, program.version), store, program


def call(asked: argparse.Namespace, name: str) -> str:
    """Returns what to type for another command on the same sweep."""
    results = "" if asked.results == RESULTS else f" --results {shlex.quote(str(asked.results))}"
    return f"scripts/sweep {name} {shlex.quote(str(asked.sweep))}{results}"


def count(planned: Plan, store: Store) -> Counter[str]:
    """Returns how many runs are in which state."""
    return Counter(state_of(store.folder(one), one) for one in planned.different)


def tell(report: Report) -> None:
    """Prints what came of the runs."""
    if report.started:
        own = 1e3 * report.own_seconds / report.started
        print(
            f"{count_of(report.started, 'run')} in {report.seconds:.1f} s, {report.workers} at a time: "
            f"{own:.1f} ms a run integrating, {1e3 * report.overhead:.1f} ms a run for all else"
        )
    for said, times in report.messages.most_common(SHOWN):
        state, message = said
        print(f"sweep: {times} {state}, as in {report.examples[said]}: {message}", file=sys.stderr)
    if len(report.messages) > SHOWN:
        print(f"sweep: and {len(report.messages) - SHOWN} other messages", file=sys.stderr)


def finish(planned: Plan, report: Report, again: str, stopped_code: int) -> int:
    """Says what is left to do and returns the exit code."""
    states = report.states
    if left := states["interrupted"] + states["stopped"]:
        print(f"sweep: stopped with {planned.counted(left)} to go; go on with {again}", file=sys.stderr)
        return stopped_code
    if states["busy"]:
        print(f"sweep: {planned.counted(states['busy'])} left to another process", file=sys.stderr)
    return 1 if states["failed"] else stopped_code if report.stopped else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="sweep", description="Runs many variants of a case and collects what came of them."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(function: object, text: str) -> argparse.ArgumentParser:
        command = commands.add_parser(function.__name__, help=text, description=function.__doc__)
        command.add_argument(
            "sweep", type=Path, metavar="SWEEP", help="a sweep file, such as cases/swing/peak_force.toml"
        )
        command.add_argument(
            "--results", type=Path, default=RESULTS, metavar="DIR", help="default: results, in this folder"
        )
        command.set_defaults(command=function)
        return command

    add(plan, "say how many runs there are and show the first")
    command = add(run, "run what is not done")
    command.add_argument(
        "--jobs", type=_jobs, default=cores(), metavar="N", help="runs at a time; default: cores"
    )
    command.add_argument(
        "--slurm", action="store_true", help="submit to Slurm; options of sbatch may follow after --"
    )
    command.add_argument(
        "--runs-per-task", type=_jobs, metavar="N", help="runs of a task of Slurm; default: by their time"
    )
    add(status, "count the runs that are done, running, failed, missing")
    command = add(collect, "write the tables of all runs")
    command.add_argument("--partial", action="store_true", help="leave out runs that have no results")
    command = add(plot, "draw the figures of the sweep file")
    command.add_argument(
        "--format", default="png", choices=FORMATS, metavar="KIND", help=f"{', '.join(FORMATS)}; default: png"
    )
    command = add(work, "run some runs, one after the other (a task of a cluster's job)")
    command.add_argument(
        "--runs", type=_slice, required=True, metavar="FIRST:LAST", help="which runs, both included"
    )
    return parser


def _jobs(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError("must be a whole number of one or more")
    return int(text)


def _slice(text: str) -> tuple[int, int]:
    first, _, last = text.partition(":")
    if not first.isdecimal() or not last.isdecimal():
        raise argparse.ArgumentTypeError(f"'{text}' is not FIRST:LAST, as in 1:20")
    return int(first), int(last)
