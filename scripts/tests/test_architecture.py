"""The rules of the layout that no compiler keeps: arrows point down, names are paths, only apps stop."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "src").rglob("*.f90"))

# Rooms from the ground up, and what a module of each may use besides its own room and the ground floor.
GROUND = {
    "taut_archive",
    "taut_kinds",
    "taut_error",
    "taut_name_index",
    "taut_shared_library",
    "taut_spelling",
    "taut_version",
}
ROOMS = {
    "linalg": set(),
    "rotation": set(),
    "jet": set(),
    "ode": {"linalg"},
    "constrained": {"linalg", "rotation", "jet", "ode"},
    "model": {"linalg", "rotation", "jet", "ode", "constrained"},
    "case": {"linalg", "rotation", "ode", "constrained", "model"},
}

# Statements that must not be found: input and output below `case`, and an end of the program below the apps.
INPUT_OUTPUT = (
    r"(print|rewind|backspace|flush|endfile)\b|(open|close|inquire|read|write)\s*\(|read\s+\*|namelist\s*/"
)
STOP = r"(error\s+)?stop\b|call\s+(exit|abort)\b"


def code(path: Path) -> list[str]:
    """Returns the statements of a file in lower case: no comments, no texts, continued lines joined."""
    text = path.read_text(encoding="utf-8")
    text = re.sub(
        r"'(?:[^'\n]|'')*'|\"(?:[^\"\n]|\"\")*\"", "''", "\n".join(map(drop_comment, text.splitlines()))
    )
    text = re.sub(r"&\s*\n\s*&?", "", text)
    return [part.strip().lower() for line in text.splitlines() for part in line.split(";") if part.strip()]


def drop_comment(line: str) -> str:
    """Returns a line without its comment; an exclamation mark inside a text begins none."""
    quote = ""
    for i, character in enumerate(line):
        if quote:
            quote = "" if character == quote else quote
        elif character in "'\"":
            quote = character
        elif character == "!":
            return line[:i]
    return line


def used(path: Path) -> set[str]:
    """Returns the modules of taut that a file uses."""
    uses = (re.match(r"use\s*(?:,[^:]*)?(?:::)?\s*(\w+)", line) for line in code(path))
    return {match[1] for match in uses if match and match[1].startswith("taut")}


def is_submodule(path: Path) -> bool:
    """Returns whether a file holds a submodule: what procedures do that its module declares."""
    return code(path)[0].startswith("submodule")


def name_of(path: Path) -> str:
    """Returns the name that a module must have at its place."""
    return "_".join(path.relative_to(ROOT / "src").with_suffix("").parts)


def room_of(module: str) -> str:
    """Returns the room of a module; those of the ground floor have none."""
    part = module.removeprefix("taut").strip("_").split("_")[0]
    return part if part in ROOMS else ""


def condition(line: str) -> str:
    """Returns what an `if` on one line guards, or the line itself."""
    if not (start := re.match(r"if\s*\(", line)):
        return line
    depth = 0
    for i in range(start.end() - 1, len(line)):
        depth += {"(": 1, ")": -1}.get(line[i], 0)
        if depth == 0:
            return line[i + 1 :].strip()
    return line


def statements(path: Path, pattern: str) -> list[str]:
    """Returns the statements of a file that begin with a pattern, guarded by an `if` or not."""
    return [line for line in code(path) if re.match(pattern, condition(line))]


def is_internal(statement: str) -> bool:
    """Tells whether a `read` or `write` goes to a text, and not to a file or the screen."""
    match = re.match(r"(?:read|write)\s*\(\s*(\w+)", condition(statement))
    return bool(match) and match[1] in {"buffer", "text", "line"}


def each(paths: list[Path]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("path", paths, ids=[str(path.relative_to(ROOT)) for path in paths])


def test_there_are_sources() -> None:
    # An empty list would make every other test here pass.
    rooms = {room_of(name_of(path)) for path in SOURCES}
    assert {"linalg", "ode", "constrained", "model", "case"} <= rooms
    assert "taut_linalg_lapack" in used(ROOT / "src/taut/linalg/block_diagonal.f90")


@each(SOURCES)
def test_arrows_point_down(path: Path) -> None:
    module = name_of(path)
    room = room_of(module)
    if module == "taut":
        # The front door shows the models too, so that an installed taut has them; of files
        # only how one becomes a model.
        assert [name for name in used(path) if room_of(name) == "case"] == ["taut_case_mechanism"]
        return
    allowed = ROOMS[room] | {room} if room else set()
    for name in used(path) - GROUND:
        if name.startswith("taut_jet"):  # numbers, like those of the kinds
            continue
        assert room_of(name) in allowed, f"{module} uses {name}"
    assert "taut" not in used(path), "the library must not use its own front door"


def test_lowest_rooms_are_closed() -> None:
    # Said once more in plain words, so that a change of the table above cannot lift these by accident.
    for path in SOURCES:
        above = {room_of(name) for name in used(path)}
        if "/linalg/" in path.as_posix():
            assert above <= {"", "linalg"}
        if "/ode/" in path.as_posix():
            assert not above & {"constrained", "model", "case"}
        if "/model/" in path.as_posix():
            assert "case" not in above


def test_no_circles() -> None:
    uses = {name_of(path): used(path) for path in SOURCES}
    done: set[str] = set()
    while ready := {name for name, needs in uses.items() if name not in done and needs <= done}:
        done |= ready
    assert done == set(uses)


@each(SOURCES)
def test_name_is_the_path(path: Path) -> None:
    modules = [line for line in code(path) if re.match(r"(submodule\s*\(|module\s+\w+$)", line)]
    kind = "submodule" if is_submodule(path) else "module"
    # A submodule stands in the folder of its module.
    of_parent = f"({name_of(path.parent)}) " if kind == "submodule" else " "
    assert modules == [f"{kind}{of_parent}{name_of(path)}"]
    assert code(path)[-1] == f"end {kind} {name_of(path)}"


@each(SOURCES)
def test_module_is_strict_and_private(path: Path) -> None:
    lines = code(path)
    head = lines[: lines.index("contains")] if "contains" in lines else lines
    assert "implicit none (type, external)" in head
    # Nothing of a submodule can be used elsewhere.
    assert "private" in head or is_submodule(path)


@each(sorted([*(ROOT / "app").glob("*.f90"), *(ROOT / "test").glob("*.f90")]))
def test_program_is_strict(path: Path) -> None:
    assert "implicit none (type, external)" in code(path)


@each([path for path in SOURCES if room_of(name_of(path)) != "case"])
def test_no_input_or_output_below_case(path: Path) -> None:
    assert [line for line in statements(path, INPUT_OUTPUT) if not is_internal(line)] == []
    assert not any("output_unit" in line or "error_unit" in line for line in code(path))


@each(SOURCES)
def test_only_apps_stop(path: Path) -> None:
    assert statements(path, STOP) == []


def test_one_version() -> None:
    source = (ROOT / "src/taut/version.f90").read_text(encoding="utf-8")
    versions = re.findall(r"version = '([^']+)'", source)
    manifest = tomllib.loads((ROOT / "fpm.toml").read_text(encoding="utf-8"))
    assert versions == [manifest["version"]]


@pytest.mark.parametrize(
    ("name", "pattern"),
    [
        ("README.md", r"(?i)\b(?:taut|version)[ :]+v?(\d+\.\d+\.\d+)"),
        ("CITATION.cff", r"(?m)^version:\s*[\"']?([^\"'\s]+)"),
    ],
)
def test_version_of_the_papers(name: str, pattern: str) -> None:
    path = ROOT / name
    if not path.exists():
        pytest.skip(f"there is no {name}")
    manifest = tomllib.loads((ROOT / "fpm.toml").read_text(encoding="utf-8"))
    assert set(re.findall(pattern, path.read_text(encoding="utf-8"))) <= {manifest["version"]}
