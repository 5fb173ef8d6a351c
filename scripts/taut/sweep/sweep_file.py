"""Sweep files: which entries of which case vary, and what is made of the results."""

import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from taut.case_file import Entry, check_value
from taut.errors import TautError
from taut.sweep.slurm import check_table
from taut.sweep.values import KINDS, LIMIT, Row, values_of

PLOT_KEYS = ("name", "title", "x", "y", "z", "lines", "points", "contours", "log", "where", "labels")
# Columns that the tables of an app that integrates have anyway.
TAKEN = (
    *("run", "case", "method", "t", "status", "t_end", "steps", "rejected", "rhs_evaluations"),
    *("projection_iterations", "jacobians", "factorizations", "newton_iterations"),
    *("max_phi", "max_phidot", "max_phiddot", "energy_drift", "work", "min_rank"),
    *("note", "wall_seconds", "blas", "message"),
)
# What is taken of the steps, by the program, and what of the rows of a trajectory.
OF_STEPS = ("max", "min", "abs-max")
TAKES = (*OF_STEPS, "max-change", "mean", "final")


@dataclass(frozen=True)
class Parameter:
    """Entries that vary together, the columns that name them, and their values, a row at a time."""

    entries: list[Entry]
    names: list[str]
    rows: list[Row]
    # Further entries, each a multiple of the first.
    also: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Quantity:
    """A number made of a column of a trajectory."""

    name: str
    column: str
    take: str
    start: float
    end: float

    @property
    def of_steps(self) -> bool:
        """Whether the program finds it, as an extreme that its summary tells."""
        return self.take in OF_STEPS

    @property
    def group(self) -> tuple[str, dict[str, Any]]:
        """The group of a case file that asks for it."""
        times = {"from": self.start, "to": self.end}
        return "extreme", {
            "name": self.name,
            "column": self.column,
            **{key: value for key, value in times.items() if math.isfinite(value)},
        }

    @property
    def told(self) -> dict[str, str]:
        """The columns of the summary that tell of it."""
        return {key: f"{self.name}_{key}" for key in ("min", "min_t", "max", "max_t")}


@dataclass(frozen=True)
class Plot:
    """A figure of collected columns."""

    name: str
    x: str
    y: str
    z: str | None
    lines: str | None
    points: bool
    contours: list[float]
    log: list[str]
    where: dict[str, Any]
    labels: dict[str, str]
    title: str

    @property
    def over_time(self) -> bool:
        """Whether it is drawn from the trajectories and not from the table."""
        return self.x == "t"

    @property
    def columns(self) -> list[str]:
        """The columns that it needs."""
        return [name for name in (self.x, self.y, self.z, self.lines, *self.where) if name]


@dataclass(frozen=True)
class Sweep:
    """A sweep file, read and checked."""

    path: Path
    app: str
    case: Path
    combine: str
    checkpoint: float | None
    # Whether a run leaves a row and no files.
    rows_only: bool
    fixed: dict[str, Any]
    parameters: list[Parameter]
    quantities: list[Quantity]
    trajectories: list[str]
    plots: list[Plot]
    # Options of sbatch.
    slurm: dict[str, Any]

    @property
    def name(self) -> str:
        """The sweep's name, which is its file's."""
        return self.path.stem

    @property
    def options(self) -> list[str]:
        """The options that the program takes besides."""
        return [] if self.checkpoint is None else ["--checkpoint", f"{self.checkpoint:g}"]

    @property
    def columns(self) -> list[str]:
        """The names of the parameters' columns."""
        return [name for parameter in self.parameters for name in parameter.names]


def read(path: Path) -> Sweep:
    """Reads a sweep file; every complaint names the file."""
    if not path.is_file():
        raise TautError(f"{path}: there is no such sweep file, or it is no regular file")
    if set(path.stem) == {"."}:
        raise TautError(f"{path}: a sweep of this name would write into another folder; rename the file")
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise TautError(f"{path}: the sweep file cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise TautError(f"{path}: {error}") from None
    try:
        return _sweep(path, table)
    except TautError as error:
        raise TautError(f"{path}: {error}") from None


def _sweep(path: Path, table: dict[str, Any]) -> Sweep:
    """Makes a sweep of the file's table."""
    keys = ("case", "app", "combine", "checkpoint", "keep", "fixed", "parameter", "collect", "plot", "slurm")
    _known(table, keys, "the sweep file")
    case = path.parent / _take(table, "case", str, "the sweep file")
    if not case.is_file():
        raise TautError(f"case: there is no file {case}")
    app = _take(table, "app", str, "the sweep file", path.resolve().parent.name)
    if not re.fullmatch(r"\w[\w-]*", app, re.ASCII):
        raise TautError(f"app = '{app}' is no name of an app; TAUT_BIN may name the folder of one's own")
    combine = _take(table, "combine", str, "the sweep file", "grid")
    if combine not in ("grid", "zip"):
        raise TautError(f"combine = '{combine}' is neither 'grid' nor 'zip'")
    checkpoint = _take(table, "checkpoint", float, "the sweep file", None)
    if checkpoint is not None and not checkpoint > 0:
        raise TautError("checkpoint needs a number of seconds greater than zero")
    keep = _take(table, "keep", str, "the sweep file", "files")
    if keep not in ("files", "rows"):
        raise TautError(f"keep = '{keep}' is neither 'files' nor 'rows'")
    if keep == "rows" and checkpoint is not None:
        raise TautError("checkpoint is for runs that leave files; leave it out, or take keep = 'files'")
    fixed = _flat(_take(table, "fixed", dict, "the sweep file", {}))
    for entry, value in fixed.items():
        Entry.read(entry)
        check_value(value)
    blocks = _blocks(table, "parameter")
    if not blocks:
        raise TautError("there is no [[parameter]]; give at least one")
    parameters = [_parameter(block, f"[[parameter]] {i}", path) for i, block in enumerate(blocks, start=1)]
    names = [name for parameter in parameters for name in parameter.names]
    for name in names:
        if names.count(name) > 1 or name in TAKEN:
            raise TautError(f"the name '{name}' of a parameter is taken; give another with 'name'")
    if combine == "zip" and len({len(parameter.rows) for parameter in parameters}) > 1:
        lengths = ", ".join(f"{parameter.names[0]} {len(parameter.rows)}" for parameter in parameters)
        raise TautError(f"combine = 'zip' needs equally many values of all parameters; there are {lengths}")
    if combine == "grid" and (number := math.prod(len(parameter.rows) for parameter in parameters)) > LIMIT:
        raise TautError(f"the grid has {number} runs; a sweep has {LIMIT} at most")
    options = _take(table, "slurm", dict, "the sweep file", {})
    check_table(options)
    quantities, trajectories = _collect(_take(table, "collect", dict, "the sweep file", {}), names)
    if keep == "rows" and (trajectories or not all(quantity.of_steps for quantity in quantities)):
        raise TautError(
            f"[collect] has more than {', '.join(OF_STEPS)} and needs trajectories, "
            "which keep = 'rows' does not leave; take keep = 'files'"
        )
    return Sweep(
        path=path,
        app=app,
        case=case,
        combine=combine,
        checkpoint=checkpoint,
        rows_only=keep == "rows",
        fixed=fixed,
        parameters=parameters,
        quantities=quantities,
        trajectories=trajectories,
        plots=[_plot(block, f"[[plot]] {i}") for i, block in enumerate(_blocks(table, "plot"), start=1)],
        slurm=options,
    )


def _parameter(block: dict[str, Any], where: str, path: Path) -> Parameter:
    """Reads a [[parameter]]."""
    several = "entries" in block
    keys = ("entries", "names") if several else ("entry", "name", "also")
    _known(block, (*keys, *KINDS), where)
    kinds = [kind for kind in KINDS if kind in block]
    if len(kinds) != 1:
        there = f"; there are {' and '.join(kinds)}" if kinds else ""
        raise TautError(f"{where} needs one of {', '.join(KINDS)}{there}")
    if several:
        texts = _list(block, "entries", str, where)
        names = _list(block, "names", str, where) or texts
        if len(names) != len(texts) or not texts:
            raise TautError(f"{where}: 'names' needs one name an entry")
        also = {}
    else:
        texts = [_take(block, "entry", str, where)]
        names = [_take(block, "name", str, where, texts[0])]
        also = _flat(_take(block, "also", dict, where, {}))
        also = {entry: _take(also, entry, float, f"{where}.also") for entry in also}
    for text in also:
        Entry.read(text)
    try:
        rows = values_of(kinds[0], block[kinds[0]], len(texts), path.parent)
    except TautError as error:
        raise TautError(f"{where}: {error}") from None
    if any(factor != 1 for factor in also.values()) and any(
        isinstance(row[0], bool) or not isinstance(row[0], int | float) for row in rows
    ):
        raise TautError(f"{where}: 'also' multiplies numbers alone")
    for number, text in enumerate(texts):
        if Entry.read(text).name == "label" and not all(isinstance(row[number], str) for row in rows):
            raise TautError(f"{where}: '{text}' is a text; write its values in quotation marks")
    return Parameter([Entry.read(text) for text in texts], names, rows, also)


def _collect(table: dict[str, Any], parameters: list[str]) -> tuple[list[Quantity], list[str]]:
    """Reads [collect]: the columns of trajectories to be joined, and quantities made of columns."""
    quantities = []
    for name, spec in table.items():
        if name == "trajectories":
            continue
        where = f"[collect] {name}"
        if name in parameters or name in TAKEN:
            raise TautError(f"{where}: the name is that of another column of the table; give another")
        if not isinstance(spec, dict):
            raise TautError(f"{where} needs a table with column, take, from, to")
        _known(spec, ("column", "take", "from", "to"), where)
        take = _take(spec, "take", str, where)
        if take not in TAKES:
            raise TautError(f"{where}: take = '{take}' is not known; there are {', '.join(TAKES)}")
        start = _take(spec, "from", float, where, float("-inf"))
        end = _take(spec, "to", float, where, float("inf"))
        if not start <= end:
            raise TautError(f"{where}: from = {start} is later than to = {end}")
        quantities.append(Quantity(name, _take(spec, "column", str, where), take, start, end))
    trajectories = _list(table, "trajectories", str, "[collect]")
    for name in trajectories:
        if trajectories.count(name) > 1 or name in (*parameters, "run", "method", "t"):
            raise TautError(f"[collect] trajectories: the table has another column '{name}'")
    return quantities, trajectories


def _plot(block: dict[str, Any], where: str) -> Plot:
    """Reads a [[plot]]."""
    _known(block, PLOT_KEYS, where)
    name = _take(block, "name", str, where)
    if not re.fullmatch(r"[\w.-]+", name):
        raise TautError(f"{where}: name = '{name}' must be fit for a file: letters, digits, - and _")
    z, lines = (_take(block, key, str, where, None) for key in ("z", "lines"))
    if z and lines:
        raise TautError(f"{where} has 'lines' and 'z'; a map has no lines")
    contours = _list(block, "contours", int | float, where)
    if contours and not z:
        raise TautError(f"{where} has 'contours' but no 'z'; only a map has contours")
    log = _list(block, "log", str, where)
    _known(dict.fromkeys(log), ("x", "y", "z"), f"'log' of {where}")
    labels = _take(block, "labels", dict, where, {})
    _known(labels, ("x", "y", "z", "lines"), f"'labels' of {where}")
    return Plot(
        name=name,
        x=_take(block, "x", str, where),
        y=_take(block, "y", str, where),
        z=z,
        lines=lines,
        points=_take(block, "points", bool, where, False),
        contours=contours,
        log=log,
        where=_take(block, "where", dict, where, {}),
        labels=labels,
        title=_take(block, "title", str, where, ""),
    )


def _flat(table: dict[str, Any], before: str = "") -> dict[str, Any]:
    """Returns a table of entries by name: without quotation marks TOML makes a table of each group."""
    flat = {}
    for key, value in table.items():
        flat |= _flat(value, f"{before}{key}.") if isinstance(value, dict) else {before + key: value}
    return flat


def _known(table: dict[str, Any], keys: tuple[str, ...], where: str) -> None:
    """Refuses keys that are not known."""
    for key in table:
        if key not in keys:
            raise TautError(f"{where} has no key '{key}'; it has {', '.join(keys)}")


NEEDED = object()
WORDS = {str: "a text", float: "a number", bool: "true or false", dict: "a table"}


def _take(table: dict[str, Any], key: str, kind: type, where: str, default: Any = NEEDED) -> Any:
    """Returns a value of a kind; without a default it is needed."""
    if key not in table:
        if default is NEEDED:
            raise TautError(f"{where} needs '{key}'")
        return default
    value = table[key]
    logical = isinstance(value, bool)
    if not isinstance(value, int | float if kind is float else kind) or logical != (kind is bool):
        raise TautError(f"{where}: '{key}' must be {WORDS[kind]}")
    return value


def _list(table: dict[str, Any], key: str, kind: Any, where: str) -> list[Any]:
    """Returns a list of texts or numbers; an empty one if there is none."""
    value = table.get(key, [])
    if not isinstance(value, list) or not all(isinstance(item, kind) for item in value):
        raise TautError(f"{where}: '{key}' must be a list of {'texts' if kind is str else 'numbers'}")
    return value


def _blocks(table: dict[str, Any], key: str) -> list[dict[str, Any]]:
    """Returns the tables of an array of tables."""
    value = table.get(key, [])
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        raise TautError(f"write [[{key}]], with two brackets")
    return value
