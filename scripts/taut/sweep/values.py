"""The values that a parameter takes: lists, ranges, samples, tables."""

import csv
import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

from taut.case_file import check_value
from taut.errors import TautError

Row = list[Any]
# More runs than anyone means.
LIMIT = 1_000_000


def listed(spec: Any, width: int, _folder: Path) -> list[Row]:
    """A list of values; of lists with one value for each entry if there are several entries."""
    if not isinstance(spec, list):
        raise TautError(f"'list' needs a list of values, as in list = [{spec}]")
    if not spec:
        raise TautError("'list' is empty; give it one value or more")
    if width == 1:
        return [[value] for value in spec]
    for row in spec:
        if not isinstance(row, list) or len(row) != width:
            raise TautError(f"'list' has {row}; each of its rows needs {width} values, one an entry")
    return spec


def spaced(spec: Any, width: int, _folder: Path) -> list[Row]:
    """Equal distances, both ends included; decimal fractions come out as one would write them."""
    table = _table("range", spec, ("start", "stop", "step", "count"))
    start, stop = (_number("range", table, key) for key in ("start", "stop"))
    if ("step" in table) == ("count" in table):
        raise TautError("'range' needs either 'step' or 'count', and not both")
    low, high = Fraction(repr(start)), Fraction(repr(stop))
    if "count" in table:
        count = _count("range", table)
        _check_ends("range", count, start, stop)
        step = (high - low) / max(count - 1, 1)
    else:
        step = Fraction(repr(_number("range", table, "step")))
        if step == 0 or (high - low) / step < 0:
            raise TautError(f"'range' does not lead from {start} to {stop} by steps of {table['step']}")
        count = int((high - low) / step) + 1
        if count > LIMIT:
            raise TautError(f"'range' makes {count} values; a sweep has {LIMIT} runs at most")
        if (last := low + (count - 1) * step) != high:
            raise TautError(
                f"'range' does not end at stop = {stop} but at {float(last):g}; "
                "give that as 'stop', or 'count' instead of 'step'"
            )
    whole = all(isinstance(table[key], int) for key in ("start", "stop", "step") if key in table)
    values = [low + i * step for i in range(count)]
    whole = whole and all(value.denominator == 1 for value in values)
    return [[int(value) if whole else float(value)] * width for value in values]


def log_spaced(spec: Any, width: int, _folder: Path) -> list[Row]:
    """Equal ratios, both ends included."""
    table = _table("log_range", spec, ("start", "stop", "count"))
    low, high = (math.log10(_positive("log_range", table, key)) for key in ("start", "stop"))
    count = _count("log_range", table)
    _check_ends("log_range", count, low, high)
    return [[_tidy(10 ** (low + (high - low) * i / max(count - 1, 1)))] * width for i in range(count)]


def random(spec: Any, width: int, _folder: Path) -> list[Row]:
    """Independent samples."""
    import numpy as np

    count, seed, maps = _sampling("random", spec, width)
    return _spread(np.random.default_rng(seed).random((count, len(maps))), maps, width)


def latin_hypercube(spec: Any, width: int, _folder: Path) -> list[Row]:
    """Samples of which each of so many equal shares of each distribution holds one."""
    from scipy.stats import qmc

    count, seed, maps = _sampling("latin_hypercube", spec, width)
    return _spread(qmc.LatinHypercube(len(maps), rng=seed).random(count), maps, width)


def tabled(spec: Any, width: int, folder: Path) -> list[Row]:
    """Columns of a CSV file, one an entry; numbers and logicals are told from texts by their look."""
    table = _table("table", spec, ("file", "columns"))
    columns = table.get("columns")
    if not isinstance(table.get("file"), str) or not isinstance(columns, list) or len(columns) != width:
        raise TautError(f"'table' needs 'file' and 'columns' with {width} names, one an entry")
    path = folder / table["file"]
    if not path.is_file():
        raise TautError(f"{path}: there is no such table, or it is no regular file")
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = [[cell.strip() for cell in line] for line in csv.reader(file) if any(line)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise TautError(f"{path}: the table cannot be read: {getattr(error, 'strerror', error)}") from None
    header, rows = (lines[0], lines[1:]) if lines else ([], [])
    for name in columns:
        if name not in header:
            raise TautError(f"{path}: no column '{name}'; it has {', '.join(header)}")
    if not rows:
        raise TautError(f"{path}: the table has no rows")
    for number, row in enumerate(rows, start=2):
        if len(row) != len(header):
            raise TautError(f"{path}: row {number} has {len(row)} entries under {len(header)} columns")
    return [[_guess(row[header.index(name)]) for name in columns] for row in rows]


KINDS: dict[str, Callable[[Any, int, Path], list[Row]]] = {
    "list": listed,
    "range": spaced,
    "log_range": log_spaced,
    "random": random,
    "latin_hypercube": latin_hypercube,
    "table": tabled,
}


def values_of(kind: str, spec: Any, width: int, folder: Path) -> list[Row]:
    """Returns the rows of values, one value for each entry, all of them checked."""
    rows = KINDS[kind](spec, width, folder)
    for row in rows:
        for value in row:
            check_value(value)
    return rows


def _table(kind: str, spec: Any, keys: tuple[str, ...]) -> dict[str, Any]:
    """Checks that a kind is given as a table of known keys."""
    if not isinstance(spec, dict):
        raise TautError(f"'{kind}' needs a table with {', '.join(keys)}")
    for key in spec:
        if key not in keys:
            raise TautError(f"'{kind}' has no key '{key}'; it has {', '.join(keys)}")
    return spec


def _number(kind: str, table: dict[str, Any], key: str) -> int | float:
    """Returns a finite number."""
    value = table.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise TautError(f"'{kind}' needs a number for '{key}'")
    return value


def _positive(kind: str, table: dict[str, Any], key: str) -> float:
    """Returns a number whose logarithm there is."""
    if (value := _number(kind, table, key)) <= 0:
        raise TautError(f"'{kind}' needs a positive number for '{key}'")
    return value


def _count(kind: str, table: dict[str, Any]) -> int:
    """Returns how many values there are to be."""
    value = table.get("count")
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise TautError(f"'{kind}' needs a whole number of one or more for 'count'")
    if value > LIMIT:
        raise TautError(f"'{kind}' makes {value} values; a sweep has {LIMIT} runs at most")
    return value


def _check_ends(kind: str, count: int, start: float, stop: float) -> None:
    """Refuses a single value that is to be at both ends."""
    if count == 1 and start != stop:
        raise TautError(f"'{kind}' with count = 1 leaves out 'stop'; write list = [...] for a single value")


def _tidy(value: float) -> float:
    """Rounds to 12 digits, so that another machine's logarithm makes no other number."""
    return float(f"{value:.12g}")


def _guess(text: str) -> Any:
    """Returns a cell of a table as a number, a logical or a text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return {"true": True, "false": False, ".true.": True, ".false.": False}.get(text.lower(), text)


Quantile = Callable[[Any], Any]
DISTRIBUTIONS = ("uniform", "log_uniform", "normal")


def _sampling(kind: str, spec: Any, width: int) -> tuple[int, int, list[Quantile]]:
    """Returns the number of samples, the seed and the inverse distribution functions."""
    table = _table(kind, spec, ("count", "seed", *DISTRIBUTIONS, "of"))
    count = _count(kind, table)
    seed = table.get("seed")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise TautError(f"'{kind}' needs 'seed', a whole number, so that its samples are the same each time")
    given = {key: value for key, value in table.items() if key in DISTRIBUTIONS}
    if "of" not in table:
        return count, seed, [_quantile(kind, given)]
    of = table["of"]
    if given or not isinstance(of, list) or len(of) != width or not all(isinstance(one, dict) for one in of):
        raise TautError(f"'of' of '{kind}' needs {width} distributions, one an entry, and none beside it")
    return count, seed, [_quantile(kind, one) for one in of]


def _quantile(kind: str, given: dict[str, Any]) -> Quantile:
    """Returns the inverse distribution function of a table such as { uniform = [1, 2] }."""
    from scipy.special import ndtri

    name, ends = next(iter(given.items()), ("", None))
    if len(given) != 1 or name not in DISTRIBUTIONS or not isinstance(ends, list) or len(ends) != 2:
        raise TautError(
            f"'{kind}' needs one of uniform = [low, high], log_uniform = [low, high], "
            "normal = [mean, deviation]"
        )
    table = dict(zip("ab", ends, strict=True))
    if name == "log_uniform":
        low, high = (math.log(_positive(name, table, key)) for key in "ab")
        _check_order(name, ends, low < high)
        return lambda u: math.e ** (low + (high - low) * u)
    a, b = (_number(name, table, key) for key in "ab")
    if name == "normal" and b <= 0:
        raise TautError(f"normal = {ends}: the deviation must be greater than zero")
    _check_order(name, ends, name == "normal" or a < b)
    return (lambda u: a + (b - a) * u) if name == "uniform" else (lambda u: a + b * ndtri(u))


def _check_order(name: str, ends: list[float], good: bool) -> None:
    """Refuses an interval whose ends are not in order."""
    if not good:
        raise TautError(f"{name} = {ends}: the low end must be less than the high end")


def _spread(samples: Any, maps: list[Quantile], width: int) -> list[Row]:
    """Maps samples of the unit cube to values; a single distribution's value serves all entries."""
    rows = [[_tidy(float(f(u))) for f, u in zip(maps, row, strict=True)] for row in samples]
    return rows if len(maps) == width else [row * width for row in rows]
