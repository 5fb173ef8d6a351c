"""Public procedures and their arguments say what they are: FORD gives a comment to the one name below it."""

import re
from dataclasses import dataclass, field
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# The procedures of LAPACK and BLAS are described in LAPACK's own pages.
SOURCES = sorted(path for path in (ROOT / "src").rglob("*.f90") if path.name != "lapack.f90")
SAYS_NOTHING = {"where", "the result", "the value", "the answer", "see above", "as above", "the same"}
HEAD = re.compile(
    r"(?:(?:pure|elemental|impure|recursive|module|integer|logical|real\(\w+\)|type\(\w+\))\s+)*"
    r"(subroutine|function)\s+(\w+)\s*(?:\(([^)]*)\))?(?:.*result\s*\((\w+)\))?",
    re.IGNORECASE,
)


@dataclass
class Procedure:
    """A procedure, its comment and those of its arguments; an argument that shares one has none."""

    name: str
    comment: str
    arguments: list[str]
    # A procedure of a library in C, which its own guide describes.
    foreign: bool = False
    comments: dict[str, str] = field(default_factory=dict)


def statements(text: str) -> list[tuple[str, str]]:
    """Returns each statement, continued lines joined, with the comment for FORD above it."""
    found, comment, whole = [], "", ""
    for line in text.splitlines():
        bare = line.strip()
        if bare.startswith("!>"):
            comment = bare[2:].strip()
        elif bare.startswith("!!"):
            comment = f"{comment} {bare[2:].strip()}"
        elif bare and not bare.startswith("!"):
            code = re.sub(r"\s!(?=[^'\"]*$).*", "", bare).strip()
            whole += code.removeprefix("&").removesuffix("&")
            if not code.endswith("&"):
                found.append((whole.strip(), comment.strip()))
                comment, whole = "", ""
    return found


def procedures(text: str) -> list[Procedure]:
    """Returns the procedures of a module and its interfaces, without those that are inside others."""
    found: list[Procedure] = []
    depth = 0
    for code, comment in statements(text):
        if re.match(r"end (subroutine|function)\b", code):
            depth -= 1
        elif head := HEAD.match(code):
            depth += 1
            if depth == 1:
                typed = re.match(r"(pure |elemental |impure )*(integer|logical|real|type)\b", code)
                names = re.findall(r"\w+", head[3] or "") + [head[4]] * bool(head[4] and not typed)
                found.append(Procedure(head[2], comment, names, "bind(c" in code.lower()))
        elif depth == 1 and re.match(
            r"(?:type|class|real|complex|integer|logical|character|procedure)\b.*::", code
        ):
            declared = re.sub(r"'[^']*'", "", code.split("::", 1)[1])
            while "(" in declared:
                declared = re.sub(r"\([^()]*\)", "", declared)
            names = [name for name in re.findall(r"\w+", declared) if name in found[-1].arguments]
            found[-1].comments |= {name: comment if len(names) == 1 else "" for name in names}
    return found


def public(text: str) -> set[str]:
    """Returns the names that are public, bound to a type, or the interface of what is."""
    names: set[str] = set()
    for code, _ in statements(text):
        if re.match(r"public\b", code):
            names |= set(re.findall(r"\w+", code))
        elif (
            bound := re.match(r"(?:procedure|generic)\b(?:\((\w+)\))?(.*?)::(.*)", code)
        ) and "private" not in bound[2]:
            names |= {bound[1]} | set(re.findall(r"\w+", bound[3]))
    return names


def says_nothing(comment: str) -> bool:
    return comment.rstrip(".").lower() in SAYS_NOTHING | {""}


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT / "src")))
def test_arguments_are_described(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    known = public(text)
    missing = []
    for one in procedures(text):
        if one.name not in known or one.foreign:
            continue
        if says_nothing(one.comment):
            missing.append(one.name)
        missing += [
            f"{one.name}: {name}" for name in one.arguments if says_nothing(one.comments.get(name, ""))
        ]
    assert missing == []
