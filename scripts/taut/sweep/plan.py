"""The runs of a sweep: their parameters, their case files, and the hashes that are their identity."""

import hashlib
import itertools
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taut.case_file import FILE, Blank, Entry, Template, fortran
from taut.errors import TautError
from taut.formats import count_of
from taut.sweep.sweep_file import Sweep

DIGITS = 8
# Runs that leave rows only are made in so many batches, but not fewer than so many at a time.
BATCHES = 128
SMALLEST_BATCH = 25


# A value, or the column that has it and a factor.
Source = tuple[Any, int | None, float]


@dataclass(frozen=True)
class Run:
    """One run, or a batch of them: its index orders it, its hash is what it is."""

    index: int
    # One value for each column of the sweep's parameters.
    values: tuple[Any, ...]
    hash: str
    # The beginning of the hash; all of it where another run begins the same way.
    id: str
    # Its folder's name.
    name: str
    # Of a batch: its first run in the plan, and how many it has.
    first: int = 0
    count: int = 1


class Tables:
    """The files that a case reads, by what is in them: a run keeps what it was planned with."""

    FOLDER = "tables"

    def __init__(self, case: Path) -> None:
        """Knows none yet; paths are from the folder of the case."""
        self._folder = case.parent
        self.contents: dict[str, bytes] = {}
        self._names: dict[str, str] = {}

    def stored(self, path: str) -> str:
        """Returns where a file will be, seen from the folder of a run."""
        if path not in self._names:
            try:
                content = self._file(path).read_bytes()
            except OSError as error:
                raise TautError(
                    f"{self._folder / path}: the table cannot be read: {error.strerror}"
                ) from None
            self._names[path] = hashlib.sha256(content).hexdigest()[: 2 * DIGITS] + ".csv"
            self.contents[self._names[path]] = content
        return f"../../{self.FOLDER}/{self._names[path]}"

    def original(self, path: str) -> str:
        """Returns where it is."""
        return str(self._file(path))

    def _file(self, path: str) -> Path:
        file = (self._folder / path).absolute()
        if not file.is_file():
            raise TautError(f"{self._folder / path}: there is no such table, or it is no regular file")
        return file


class Plan:
    """All runs of a sweep with a given version of its program."""

    def __init__(self, sweep: Sweep, version: str) -> None:
        """Combines the parameters' values and hashes what a run depends on."""
        self.sweep = sweep
        texts = [*sweep.fixed]
        # Where each entry has its value from: fixed, or a column times a factor.
        self._sources: list[Source] = [(value, None, 1) for value in sweep.fixed.values()]
        column = 0
        for parameter in sweep.parameters:
            for entry in parameter.entries:
                texts.append(entry.text)
                self._sources.append((None, column, 1))
                column += 1
            for text, factor in parameter.also.items():
                texts.append(text)
                self._sources.append((None, column - 1, factor))
        self.tables = Tables(sweep.case)
        try:
            entries = [Entry.read(text) for text in texts]
            self._files = [number for number, entry in enumerate(entries) if entry.name == FILE]
            extremes = [quantity.group for quantity in sweep.quantities if quantity.of_steps]
            self._template = Template(sweep.case, entries, extremes, self.tables.stored)
            self._trial = Template(sweep.case, entries, extremes, self.tables.original)
        except TautError as error:
            raise TautError(f"{sweep.path}: {error}") from None
        # The parameters' values of each run.
        self.rows = list(_combinations(sweep))
        count = max(SMALLEST_BATCH, -(-len(self.rows) // BATCHES)) if sweep.rows_only else 1
        firsts = range(1, len(self.rows) + 1, count)
        width = max(len(str(len(firsts))), 4)
        ids: dict[str, str] = {}
        # What is run: each run, or batches of them.
        self.runs: list[Run] = []
        self._first: dict[str, int] = {}
        for index, begin in enumerate(firsts, start=1):
            values = () if sweep.rows_only else self.rows[begin - 1]
            inside = min(count, len(self.rows) - begin + 1)
            text = [self.blanks, self._lines(begin, inside)] if sweep.rows_only else [self._text(values)]
            inputs = json.dumps([sweep.app, version, *text])
            digest = hashlib.sha256(inputs.encode()).hexdigest()
            short = digest[:DIGITS]
            run_id = short if ids.setdefault(short, digest) == digest else digest
            # A run that stands twice in the plan is run once, in the folder of the first.
            first = self._first.setdefault(digest, index)
            self.runs.append(Run(index, values, digest, run_id, f"{first:0{width}}-{run_id}", begin, inside))

    def first(self, run: Run) -> bool:
        """Returns whether no run before it in the plan is the same."""
        return self._first[run.hash] == run.index

    @property
    def different(self) -> list[Run]:
        """The runs without those that are the same as one before."""
        return [run for run in self.runs if self.first(run)]

    @property
    def size(self) -> str:
        """How many runs there are, in words."""
        different = len(self._first)
        said = count_of(len(self.rows), "run")
        if self.sweep.rows_only:
            return f"{said} in {self.counted(different)}"
        return said if different == len(self.runs) else f"{said}, {different} of them different"

    def counted(self, number: int) -> str:
        """Returns so many of what is run, in words."""
        return count_of(number, "batch", "batches") if self.sweep.rows_only else count_of(number, "run")

    def varies(self, group: str, name: str) -> bool:
        """Returns whether runs differ in an entry."""
        return any(
            (entry.group, entry.name) == (group, name)
            for parameter in self.sweep.parameters
            for entry in (*parameter.entries, *map(Entry.read, parameter.also))
        )

    @property
    def trial(self) -> str:
        """The case file of the first run, which reads its tables where they are."""
        return self._trial.fill(self._values(self.rows[0], self._sources, self.tables.original))

    def text(self, run: Run) -> str:
        """Returns the case file of a run; of a batch, that of its first."""
        return self._text(self.rows[run.first - 1])

    @property
    def blanks(self) -> str:
        """The case file with a blank for each value that differs from run to run."""
        numbers = itertools.count(1)
        return self._template.fill(
            [
                self._fixed(i) if column is None else Blank(next(numbers))
                for i, (_, column, _) in enumerate(self._sources)
            ]
        )

    def _fixed(self, number: int) -> Any:
        value = self._sources[number][0]
        return self.tables.stored(value) if number in self._files and isinstance(value, str) else value

    def lines(self, run: Run, begin: int) -> str:
        """Returns what stands in the blanks, a line a run, from one run of a batch to its last."""
        return self._lines(begin, run.first + run.count - begin)

    def _lines(self, begin: int, count: int) -> str:
        there = [i for i, source in enumerate(self._sources) if source[1] is not None]
        rows = enumerate(self.rows[begin - 1 : begin - 1 + count], start=begin)
        whole = ((index, self._values(row, self._sources, self.tables.stored)) for index, row in rows)
        lines = ([str(index), *(fortran(values[i]) for i in there)] for index, values in whole)
        return "".join("\t".join(line) + "\n" for line in lines)

    def parameters(self, run: Run) -> dict[str, Any]:
        """Returns the parameters of a run by name; of a batch, which runs it has."""
        if self.sweep.rows_only:
            return {"runs": [run.first, run.first + run.count - 1]}
        return dict(zip(self.sweep.columns, run.values, strict=True))

    def _text(self, values: tuple[Any, ...]) -> str:
        return self._template.fill(self._values(values, self._sources, self.tables.stored))

    def _values(
        self, values: tuple[Any, ...], sources: list[Source], place: Callable[[str], str]
    ) -> list[Any]:
        """Returns the values of entries in a run."""
        found = [
            fixed if column is None else values[column] if factor == 1 else _times(values[column], factor)
            for fixed, column, factor in sources
        ]
        for number in self._files:
            if isinstance(found[number], str):
                found[number] = place(found[number])
        return found


def _times(value: float, factor: float) -> float:
    """Returns a multiple, without the last digits that a product of decimals leaves."""
    return float(f"{value * factor:.15g}")


def _combinations(sweep: Sweep) -> Iterator[tuple[Any, ...]]:
    """Returns the rows of all parameters, combined; in a grid the last parameter varies fastest."""
    rows = [parameter.rows for parameter in sweep.parameters]
    combined = itertools.product(*rows) if sweep.combine == "grid" else zip(*rows, strict=True)
    for parts in combined:
        yield tuple(itertools.chain.from_iterable(parts))
