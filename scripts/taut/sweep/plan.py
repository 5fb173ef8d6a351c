"""The runs of a sweep: their parameters, their case files, and the hashes that are their identity."""

import hashlib
import itertools
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from taut.case_file import Entry, Template
from taut.errors import TautError
from taut.formats import count_of
from taut.sweep.sweep_file import Sweep

DIGITS = 8


@dataclass(frozen=True)
class Run:
    """One run: its index orders it, its hash is what it is."""

    index: int
    # One value for each column of the sweep's parameters.
    values: tuple[Any, ...]
    hash: str
    # The beginning of the hash; all of it where another run begins the same way.
    id: str
    # Its folder's name.
    name: str


class Plan:
    """All runs of a sweep with a given version of its program."""

    def __init__(self, sweep: Sweep, version: str) -> None:
        """Combines the parameters' values and hashes what a run depends on."""
        self.sweep = sweep
        texts = [*sweep.fixed]
        # Where each entry has its value from: fixed, or a column times a factor.
        self._sources: list[tuple[Any, int | None, float]] = [
            (value, None, 1) for value in sweep.fixed.values()
        ]
        column = 0
        for parameter in sweep.parameters:
            for entry in parameter.entries:
                texts.append(entry.text)
                self._sources.append((None, column, 1))
                column += 1
            for text, factor in parameter.also.items():
                texts.append(text)
                self._sources.append((None, column - 1, factor))
        try:
            self._template = Template(sweep.case, [Entry.read(text) for text in texts])
        except TautError as error:
            raise TautError(f"{sweep.path}: {error}") from None
        rows = list(_combinations(sweep))
        width = max(len(str(len(rows))), 4)
        ids: dict[str, str] = {}
        self.runs: list[Run] = []
        self._first: dict[str, int] = {}
        for index, values in enumerate(rows, start=1):
            inputs = json.dumps([sweep.app, version, self._text(values)])
            digest = hashlib.sha256(inputs.encode()).hexdigest()
            short = digest[:DIGITS]
            run_id = short if ids.setdefault(short, digest) == digest else digest
            # A run that stands twice in the plan is run once, in the folder of the first.
            first = self._first.setdefault(digest, index)
            self.runs.append(Run(index, values, digest, run_id, f"{first:0{width}}-{run_id}"))

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
        said = count_of(len(self.runs), "run")
        return said if different == len(self.runs) else f"{said}, {different} of them different"

    def varies(self, group: str, name: str) -> bool:
        """Returns whether runs differ in an entry."""
        return any(
            (entry.group, entry.name) == (group, name)
            for parameter in self.sweep.parameters
            for entry in (*parameter.entries, *map(Entry.read, parameter.also))
        )

    def text(self, run: Run) -> str:
        """Returns the case file of a run."""
        return self._text(run.values)

    def parameters(self, run: Run) -> dict[str, Any]:
        """Returns the parameters of a run by name."""
        return dict(zip(self.sweep.columns, run.values, strict=True))

    def _text(self, values: tuple[Any, ...]) -> str:
        return self._template.fill(
            [
                fixed if column is None else values[column] if factor == 1 else _times(values[column], factor)
                for fixed, column, factor in self._sources
            ]
        )


def _times(value: float, factor: float) -> float:
    """Returns a multiple, without the last digits that a product of decimals leaves."""
    return float(f"{value * factor:.15g}")


def _combinations(sweep: Sweep) -> Iterator[tuple[Any, ...]]:
    """Returns the rows of all parameters, combined; in a grid the last parameter varies fastest."""
    rows = [parameter.rows for parameter in sweep.parameters]
    combined = itertools.product(*rows) if sweep.combine == "grid" else zip(*rows, strict=True)
    for parts in combined:
        yield tuple(itertools.chain.from_iterable(parts))
