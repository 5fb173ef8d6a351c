"""Reads the CSV files that the programs write into numpy arrays."""

import csv
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
REACHED_END = "reached-end"
# What programs write last: those that integrate, and the one that solves for modes.
LAST_FILES = ("summary.csv", "frequencies.csv")


class DataError(Exception):
    """What is wrong with the results, in one line that says what to do."""


@dataclass(frozen=True)
class Run:
    """One method of one case over time: its columns by name."""

    path: Path
    columns: dict[str, Array]

    def __getitem__(self, name: str) -> Array:
        """Returns a column, one value a step."""
        try:
            return self.columns[name]
        except KeyError:
            raise DataError(f"{self.path}: no column '{name}'; it has {', '.join(self.columns)}") from None

    @property
    def steps(self) -> int:
        """The number of steps: the first row is the start."""
        return len(next(iter(self.columns.values()))) - 1


@dataclass(frozen=True)
class Case:
    """The results of one case file: a summary row and a run for each method."""

    folder: Path

    @property
    def name(self) -> str:
        """The case's name, which is its folder's."""
        return self.folder.name

    @cached_property
    def summary(self) -> dict[str, dict[str, str]]:
        """The rows of summary.csv by method, in the order of the case file."""
        header, rows = _read(self.folder / "summary.csv")
        if "method" not in header:
            raise DataError(f"{self.folder / 'summary.csv'}: no column 'method'; it has {', '.join(header)}")
        return {row[header.index("method")]: dict(zip(header, row, strict=True)) for row in rows}

    @cached_property
    def model(self) -> dict[str, float]:
        """The numbers that the model knows about itself, by name, from model.csv."""
        path = self.folder / "model.csv"
        header, rows = _read(path)
        if header != ["name", "value", "unit"]:
            raise DataError(f"{path}: the columns are {', '.join(header)} and should be name, value, unit")
        try:
            return {name: float(value) for name, value, _ in rows}
        except ValueError as error:
            raise DataError(f"{path}: {error}") from None

    @property
    def methods(self) -> list[str]:
        """The labels of the methods, in the order of the case file."""
        return list(self.summary)

    def text(self, method: str, column: str) -> str:
        """Returns an entry of the summary as it is written."""
        path = self.folder / "summary.csv"
        if method not in self.summary:
            raise DataError(f"{path}: no method '{method}'; it has {', '.join(self.summary)}")
        if column not in self.summary[method]:
            raise DataError(f"{path}: no column '{column}'; it has {', '.join(self.summary[method])}")
        return self.summary[method][column]

    def number(self, method: str, column: str) -> float:
        """Returns an entry of the summary as a number."""
        text = self.text(method, column)
        try:
            return float(text)
        except ValueError:
            raise DataError(
                f"{self.folder / 'summary.csv'}: '{text}' in column '{column}' is no number"
            ) from None

    def steps(self, method: str) -> int:
        """Returns the number of accepted steps."""
        return int(self.number(method, "steps"))

    def run(self, method: str) -> Run:
        """Returns the history of a method."""
        return read_run(self.folder / f"{method}.csv")

    def table(self, file: str) -> dict[str, list[str]]:
        """Returns the columns of a further file of the case as they are written; there may be no row."""
        header, rows = _read(self.folder / file, rows_needed=False)
        return {name: [row[i] for row in rows] for i, name in enumerate(header)}

    @property
    def unfinished(self) -> dict[str, str]:
        """The methods that did not reach the end of the interval, and how each of them ended."""
        status = {method: self.text(method, "status") for method in self.methods}
        return {method: text for method, text in status.items() if text != REACHED_END}


@dataclass(frozen=True)
class Results:
    """The folder that holds one folder for each case."""

    root: Path

    def case(self, name: str) -> Case:
        """Returns a case, which must have been run."""
        if not self.has(name):
            raise DataError(f"{self.root / name / 'summary.csv'} is missing: run scripts/reproduce first")
        return Case(self.root / name)

    def has(self, name: str) -> bool:
        """Returns whether a case has been run."""
        return any((self.root / name / file).is_file() for file in LAST_FILES)


def _read(path: Path, rows_needed: bool = True) -> tuple[list[str], list[list[str]]]:
    """Returns the header and the rows of a CSV file."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            header, *rows = list(csv.reader(file)) or [[]]
    except OSError:
        raise DataError(f"{path} is missing: run scripts/reproduce first") from None
    if not header or (rows_needed and not rows):
        raise DataError(f"{path} is empty: run scripts/reproduce again")
    for line, row in enumerate(rows, start=2):
        if len(row) != len(header):
            raise DataError(f"{path}:{line}: {len(row)} entries under {len(header)} columns")
    return header, rows


def read_run(path: Path) -> Run:
    """Returns a history; every entry must be a number."""
    try:
        stat = path.stat()
    except OSError:
        raise DataError(f"{path} is missing: run scripts/reproduce first") from None
    # Several figures and claims use the same history; one that was written anew is read anew.
    return _run(path, stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=16)
def _run(path: Path, changed: int, size: int) -> Run:
    """Reads a history that has not changed since."""
    try:
        with path.open(encoding="utf-8") as file:
            header, rest = file.readline().rstrip("\n").split(","), file.readlines()
        values = np.loadtxt(rest, delimiter=",", ndmin=2, comments=None) if rest else np.empty((0, 0))
    except ValueError:
        values = np.empty((0, 0))
    if values.size == 0 or values.shape[1] != len(header):
        # Something is wrong: the slow way finds what.
        header, rows = _read(path)
        try:
            values = np.array(rows, dtype=np.float64)
        except ValueError as error:
            raise DataError(f"{path}: {error}") from None
    return Run(path, {name: values[:, i] for i, name in enumerate(header)})
