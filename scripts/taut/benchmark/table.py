"""The table: every measurement as CSV, and the comparison at equal errors as Markdown."""

import csv
import math
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path

from taut.benchmark.entrant import Peer, Problem
from taut.benchmark.measure import Measurement, cheapest, exponent
from taut.errors import TautError
from taut.results import read_table

COLUMNS = [field.name for field in fields(Measurement)]
# The entrant that the others are compared with.
OURS = "taut"


def write_csv(rows: Iterable[Measurement], path: Path) -> None:
    """Writes all measurements, a row each."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def read_csv(path: Path) -> list[Measurement]:
    """Returns the measurements of a file."""
    kinds = {"str": str, "int": int, "float": float}
    types = {
        field.name: kinds[getattr(field.type, "__name__", str(field.type))] for field in fields(Measurement)
    }
    table = read_table(path, rows_needed=False, remedy="run scripts/benchmark without --draw first")
    if table.header != COLUMNS:
        raise TautError(f"{path} does not have the columns {','.join(COLUMNS)}")
    try:
        return [Measurement(**{name: types[name](row[name]) for name in COLUMNS}) for row in table.records()]
    except ValueError as error:
        raise TautError(f"{path}: {error}") from error


def machine() -> str:
    """Returns the processor's name and the system."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor() or platform.machine()}, {platform.system()}"


def milliseconds(seconds: float) -> str:
    """Returns three digits."""
    value = 1e3 * seconds
    return f"{value:.{max(0, 2 - math.floor(math.log10(value)))}f}" if 0 < value < 1e3 else f"{value:.0f}"


def comparison(
    problem: Problem, size: int, target: float, rows: Sequence[Measurement], absent: Sequence[Peer] = ()
) -> list[str]:
    """Returns one comparison: each entrant's cheapest setting that reaches the error, cheapest first.

    Peers that are not installed are named.
    """
    best = cheapest(rows, target)
    ours = best.get(OURS)
    unit = problem.error_unit
    sized = f"{problem.title}, {size} {problem.unit}" if len(problem.sizes) > 1 else problem.title
    lines = [
        f"### {sized}: error {target:.0e} {unit} or less",
        "",
        "| entrant | setting | steps | rhs | Jacobians | ms | us per step "
        f"| error [{unit}] | violation [m] | time / taut's |",
        "| --- " * 10 + "|",
    ]
    reached = sorted((row for row in best.values() if row), key=lambda row: row.seconds)
    for row in reached:
        ratio = f"{row.seconds / ours.seconds:.3g}" if ours else ""
        lines.append(
            f"| {row.entrant} | {row.setting:.0e} | {row.steps} | {row.rhs} | {row.jacobians} "
            f"| {milliseconds(row.seconds)} "
            f"| {row.microseconds_per_step:.3g} | {row.error:.1e} | {row.violation:.1e} | {ratio} |"
        )
    for entrant in (name for name, row in best.items() if row is None):
        nearest = min((row for row in rows if row.entrant == entrant), key=lambda row: row.error)
        lines.append(f"| {entrant} | refused: | | | | | | {nearest.error:.1e} at best | | |")
    for peer in absent:
        for entrant in peer.entrants(problem, size):
            lines.append(f"| {entrant.label} | not installed: `--install {peer.name}` | | | | | | | | |")
    return [*lines, ""]


def growth(problem: Problem, rows: Sequence[Measurement]) -> list[str]:
    """Returns how the cost of a step grows with the size, a line for each entrant."""
    lines = [f"### {problem.title}: cost of a step [us]", ""]
    sizes = sorted({row.size for row in rows})
    lines.append(f"| entrant | {' | '.join(map(str, sizes))} | exponent |")
    lines.append("| --- " * (len(sizes) + 2) + "|")
    for entrant in dict.fromkeys(row.entrant for row in rows):
        costs: dict[int, float] = {}
        for size in sizes:
            mine = [row for row in rows if row.size == size and row.entrant == entrant]
            if best := cheapest(mine, min(problem.targets(size))).get(entrant):
                costs[size] = best.microseconds_per_step
        cells = [f"{costs[size]:.3g}" if size in costs else "" for size in sizes]
        slope = exponent(list(costs), list(costs.values()))
        lines.append(f"| {entrant} | {' | '.join(cells)} | {'' if math.isnan(slope) else f'{slope:.2f}'} |")
    return [*lines, ""]


def markdown(
    rows: Sequence[Measurement],
    problems: Mapping[str, Problem],
    versions: Mapping[str, str],
    absent: Sequence[Peer] = (),
) -> str:
    """Returns the page of all comparisons; peers that are not installed have rows that say so."""
    who = ", ".join(f"{name} {version}" for name, version in versions.items())
    lines = [
        "# Benchmark",
        "",
        f"{machine()}; one thread; {who}. Processor time of the fastest run, beyond a program's start. Each "
        "entrant is shown with its cheapest setting (rtol, or the step) that reaches the error against an "
        "independent reference; one that has none is refused.",
        "",
    ]
    for name, problem in problems.items():
        mine = [row for row in rows if row.problem == name]
        sizes = sorted({row.size for row in mine})
        for size in sizes:
            for target in problem.targets(size):
                chosen = [row for row in mine if row.size == size]
                lines += comparison(problem, size, target, chosen, absent if size in problem.sizes else ())
        if len(sizes) > 1:
            lines += growth(problem, mine)
    return "\n".join(lines)


def missed(rows: Sequence[Measurement], problems: Mapping[str, Problem]) -> list[str]:
    """Returns the errors that taut did not reach, in words."""
    found = []
    for name, problem in problems.items():
        for size in sorted({row.size for row in rows if row.problem == name}):
            ours = [row for row in rows if (row.problem, row.size, row.entrant) == (name, size, OURS)]
            best = min((row.error for row in ours), default=math.nan)
            if not best <= min(problem.targets(size)):
                found.append(
                    f"taut misses the error {min(problem.targets(size)):.0e} of {name} {size}: {best:.1e}"
                )
    return found
