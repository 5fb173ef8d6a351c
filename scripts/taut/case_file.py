"""Case files: namelists that are read, or that are templates in which some entries are blanks."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import f90nml

from taut.errors import TautError

# A place for a value in a template.
BLANK = re.compile(r"@\d+@")
# The entry that names a file to be read, beside the case.
FILE = "table"
ENTRY = re.compile(r"(?P<group>\w+)(\[(?P<which>[^][]+)\])?\.(?P<name>\w+)(\((?P<at>[\d\s,]+)\))?")


@dataclass(frozen=True)
class Entry:
    """An entry: `swing.force(2)`; `method[2].alpha` or `method[present].alpha` where there are several."""

    text: str
    group: str
    which: str | None
    name: str
    at: tuple[int, ...]

    @classmethod
    def read(cls, text: str) -> "Entry":
        """Takes an entry's name apart."""
        found = ENTRY.fullmatch(text.strip())
        if not found:
            raise TautError(
                f"'{text}' is no entry; write group.entry, as in swing.force(2), "
                "method[2].alpha or method[present].alpha"
            )
        at = tuple(int(part) for part in found["at"].split(",")) if found["at"] else ()
        return cls(text.strip(), found["group"].lower(), found["which"], found["name"].lower(), at)


@dataclass(frozen=True)
class Blank:
    """What an app fills in itself for each run of a list: @1@, @2@, ..."""

    number: int


def parse(text: str, source: str) -> f90nml.Namelist:
    """Returns the groups of a case's text; the source is what an error names."""
    try:
        return f90nml.Parser().read(StringIO(text))
    except Exception as error:  # noqa: BLE001 # f90nml raises whatever its tokens lead to
        raise TautError(f"{source}: the case is no namelist: {error or type(error).__name__}") from None


def read(path: Path) -> f90nml.Namelist:
    """Reads a case file."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise TautError(f"{path}: the case cannot be read: {getattr(error, 'strerror', error)}") from None
    return parse(text, str(path))


class Template:
    """A case file with blanks: comments are left out, so that they make no difference."""

    def __init__(
        self,
        path: Path,
        entries: list[Entry],
        more: Sequence[tuple[str, dict[str, Any]]] = (),
        place: Callable[[str], str] = str,
    ) -> None:
        """Reads the case file, makes the blanks and adds more groups, which have none.

        The last argument tells where a file that the case names will be.
        """
        groups = read(path)
        taken: dict[tuple[int, str], list[Entry]] = {}
        for number, entry in enumerate(entries):
            group = _find(groups, entry, path)
            others = taken.setdefault((id(group), entry.name), [])
            for other in others:
                if not (other.at and entry.at and other.at != entry.at):
                    raise TautError(f"'{other.text}' and '{entry.text}' are the same entry; vary it once")
            others.append(entry)
            _put(group, entry, f"@{number}@")
        for several in groups.values():
            for group in several if isinstance(several, list) else [several]:
                if isinstance(group.get(FILE), str) and not BLANK.fullmatch(group[FILE]):
                    group[FILE] = place(group[FILE])
        for name, values in more:
            groups.add_cogroup(name, f90nml.Namelist(values))
        out = StringIO()
        groups.write(out, sort=False)
        # An odd number of parts: text, number of a blank, text, ...
        self._parts = re.split(r"'@(\d+)@'", out.getvalue())

    def fill(self, values: list[Any]) -> str:
        """Returns the case with values in its blanks, in the order of the entries."""
        parts = self._parts
        return "".join(part if i % 2 == 0 else fortran(values[int(part)]) for i, part in enumerate(parts))


def fortran(value: Any) -> str:
    """Returns a value as a namelist has it; a number reads back as the same double."""
    if isinstance(value, Blank):
        return f"@{value.number}@"
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    return ", ".join(map(fortran, value))


def plain(value: Any) -> str:
    """Returns a value as a table has it: the same digits, but no quotation marks."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return " ".join(map(plain, value))
    return str(value)


def check_value(value: Any) -> None:
    """Refuses what a namelist cannot hold."""
    if isinstance(value, list):
        if not value or any(isinstance(item, list) for item in value):
            raise TautError(
                f"{value} is no value; an array is a list of one or more numbers, texts or logicals"
            )
        for item in value:
            check_value(item)
    elif isinstance(value, float) and not math.isfinite(value):
        raise TautError(f"{value} is no finite number")
    elif not isinstance(value, bool | int | float | str):
        raise TautError(f"{value!s} is neither a number nor a text nor a logical")
    elif isinstance(value, str) and not value.isprintable():
        raise TautError(f"{value!r} is not one line of text")


def _find(groups: f90nml.Namelist, entry: Entry, path: Path) -> f90nml.Namelist:
    """Returns the group of an entry; one that the case leaves out is added, for then its defaults hold."""
    if entry.group not in groups and entry.which is None:
        groups[entry.group] = f90nml.Namelist()
    if entry.group not in groups:
        known = ", ".join(f"&{name}" for name in groups)
        raise TautError(f"'{entry.text}': {path} has no group &{entry.group}; it has {known}")
    found = groups[entry.group]
    several = found if isinstance(found, list) else [found]
    labels = [str(group.get("label", group.get("name", ""))) for group in several]
    if entry.which is None:
        if len(several) == 1:
            return several[0]
        choice = f"{entry.group}[1]" + (f" or {entry.group}[{labels[0]}]" if labels[0] else "")
        raise TautError(
            f"'{entry.text}': {path} has {len(several)} groups &{entry.group}; say which, as in {choice}"
        )
    if entry.which.isdecimal() and 1 <= int(entry.which) <= len(several):
        return several[int(entry.which) - 1]
    if labels.count(entry.which) == 1:
        return several[labels.index(entry.which)]
    known = ", ".join(f"{i} {label}".rstrip() for i, label in enumerate(labels, start=1))
    raise TautError(f"'{entry.text}': {path} has no one &{entry.group} '{entry.which}'; it has {known}")


def _put(group: f90nml.Namelist, entry: Entry, blank: str) -> None:
    """Puts a blank in the place of a value."""
    if not entry.at:
        group.start_index.pop(entry.name, None)
        group[entry.name] = blank
        return
    first = group.start_index.get(entry.name, [1])
    values = group.get(entry.name, [])
    values = values if isinstance(values, list) else [values]
    flat = len(entry.at) == len(first) == 1 and not any(isinstance(value, list) for value in values)
    if flat and first[0] is not None and 0 <= entry.at[0] - first[0] < len(values):
        values[entry.at[0] - first[0]] = blank
        group[entry.name] = values
    else:
        # A later assignment to one element overrides what came before.
        group[f"{entry.name}({','.join(map(str, entry.at))})"] = blank
