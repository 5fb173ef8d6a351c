"""Reads the CSV files that the programs write into numpy arrays."""

import csv
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taut.errors import TautError

Array = NDArray[np.float64]
REACHED_END = "reached-end"
# What programs write last: those that integrate, and the one that solves for modes.
LAST_FILES = ("summary.csv", "frequencies.csv")
# What mends results that are missing or damaged.
REPRODUCE = "run scripts/reproduce first"
# Who listens to which files are read.
_listening: list[set[Path]] = []


@contextmanager
def recording() -> Iterator[set[Path]]:
    """Gives a set that gathers the files of results that are read inside."""
    files: set[Path] = set()
    _listening.append(files)
    try:
        yield files
    finally:
        _listening.remove(files)


@dataclass(frozen=True)
class Table:
    """A CSV file as it is written."""

    path: Path
    header: list[str]
    rows: list[list[str]]

    def column(self, name: str) -> list[str]:
        """Returns a column."""
        if name not in self.header:
            raise TautError(f"{self.path}: no column '{name}'; it has {', '.join(self.header)}")
        index = self.header.index(name)
        return [row[index] for row in self.rows]

    def records(self) -> list[dict[str, str]]:
        """Returns each row by the names of the columns."""
        return [dict(zip(self.header, row, strict=True)) for row in self.rows]


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
            raise TautError(f"{self.path}: no column '{name}'; it has {', '.join(self.columns)}") from None

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
        table = read_table(self.folder / "summary.csv")
        return dict(zip(table.column("method"), table.records(), strict=True))

    @cached_property
    def model(self) -> dict[str, float]:
        """The numbers that the model knows about itself, by name, from model.csv."""
        path = self.folder / "model.csv"
        table = read_table(path)
        if table.header != ["name", "value", "unit"]:
            raise TautError(
                f"{path}: the columns are {', '.join(table.header)} and should be name, value, unit"
            )
        try:
            return {name: float(value) for name, value, _ in table.rows}
        except ValueError as error:
            raise TautError(f"{path}: {error}") from None

    @property
    def methods(self) -> list[str]:
        """The labels of the methods, in the order of the case file."""
        return list(self.summary)

    def text(self, method: str, column: str) -> str:
        """Returns an entry of the summary as it is written."""
        path = self.folder / "summary.csv"
        if method not in self.summary:
            raise TautError(f"{path}: no method '{method}'; it has {', '.join(self.summary)}")
        if column not in self.summary[method]:
            raise TautError(f"{path}: no column '{column}'; it has {', '.join(self.summary[method])}")
        return self.summary[method][column]

    def number(self, method: str, column: str) -> float:
        """Returns an entry of the summary as a number."""
        text = self.text(method, column)
        try:
            return float(text)
        except ValueError:
            raise TautError(
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
        table = read_table(self.folder / file, rows_needed=False)
        return {name: table.column(name) for name in table.header}

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
            raise TautError(f"{self.root / name / 'summary.csv'} is missing: {REPRODUCE}")
        return Case(self.root / name)

    def has(self, name: str) -> bool:
        """Returns whether a case has been run."""
        return last_file(self.root / name) is not None

    def has_printed(self, example: str) -> bool:
        """Returns whether it is kept what an example has printed."""
        return self._print(example).is_file()

    def printed(self, example: str) -> list[str]:
        """Returns the lines that an example has printed."""
        path = self._print(example)
        for files in _listening:
            files.add(path)
        try:
            return path.read_text(encoding="utf-8").splitlines()
        except OSError:
            raise TautError(f"{path} is missing: {REPRODUCE}") from None

    def _print(self, example: str) -> Path:
        """Returns where it is kept what an example has printed."""
        return self.root / "examples" / f"{example}.txt"


def last_file(folder: Path) -> Path | None:
    """Returns the file with one row a method (or a mode), which the programs write last."""
    paths = (folder / name for name in LAST_FILES)
    return next((path for path in paths if path.is_file()), None)


def read_table(path: Path, *, rows_needed: bool = True, remedy: str = REPRODUCE) -> Table:
    """Returns a CSV file of a program; the remedy is what to do about one that is missing or damaged."""
    for files in _listening:
        files.add(path)
    try:
        with path.open(newline="", encoding="utf-8") as file:
            header, *rows = list(csv.reader(file)) or [[]]
    except OSError:
        raise TautError(f"{path} is missing: {remedy}") from None
    if not header or (rows_needed and not rows):
        raise TautError(f"{path} is empty: {remedy}")
    for line, row in enumerate(rows, start=2):
        if len(row) != len(header):
            raise TautError(f"{path}:{line}: {len(row)} entries under {len(header)} columns: {remedy}")
    return Table(path, header, rows)


def read_run(path: Path, *, remedy: str = REPRODUCE) -> Run:
    """Returns a history; every entry must be a number."""
    for files in _listening:
        files.add(path)
    try:
        stat = path.stat()
    except OSError:
        raise TautError(f"{path} is missing: {remedy}") from None
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
        table = read_table(path)
        header = table.header
        try:
            values = np.array(table.rows, dtype=np.float64)
        except ValueError as error:
            raise TautError(f"{path}: {error}") from None
    return Run(path, {name: values[:, i] for i, name in enumerate(header)})
