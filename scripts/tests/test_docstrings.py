"""Every public procedure, type, component and argument says what it is; FORD gives each comment to the one name below it."""

import re
from dataclasses import dataclass, field
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "src").rglob("*.f90"))
EMPTY = {"where", "the result", "the value", "the answer", "see above", "as above", "same"}
HEAD = re.compile(
    r"(?:(?:pure|elemental|impure|recursive|module|non_recursive|integer|logical|real\(\w+\)|type\(\w+\))\s+)*"
    r"(subroutine|function)\s+(\w+)\s*(?:\(([^)]*)\))?(?:.*result\s*\((\w+)\))?",
    re.IGNORECASE,
)


@dataclass
class Procedure:
    """A procedure's head, its comment and the comments of its arguments."""

    name: str
    line: int
    comment: str
    arguments: list[str]
    comments: dict[str, str] = field(default_factory=dict)
    shared: set[str] = field(default_factory=set)


def statements(text: str) -> list[tuple[int, str, str]]:
    """Returns line, statement and the comment above it; continued lines are joined, other comments left out."""
    found, comment, whole, first = [], "", "", 0
    for number, line in enumerate(text.splitlines(), start=1):
        bare = line.strip()
        if bare.startswith("!>"):
            comment = bare[2:].strip()
            continue
        if bare.startswith("!!"):
            comment += " " + bare[2:].strip()
            continue
        if not bare or bare.startswith("!"):
            continue
        code = re.sub(r"""\s*!(?=[^'"]*$).*""", "", bare) if "!" in bare else bare
        if not whole:
            first = number
        whole += code.lstrip("&").rstrip("&") if whole else code.rstrip("&")
        if code.endswith("&"):
            continue
        found.append((first, whole.strip(), comment.strip()))
        comment, whole = "", ""
    return found


def procedures(text: str) -> list[Procedure]:
    """Returns the procedures of a module, those inside others left out, and of its interfaces."""
    found: list[Procedure] = []
    open_ones: list[Procedure | None] = []
    for line, code, comment in statements(text):
        if re.match(r"end (subroutine|function)\b", code):
            open_ones.pop()
        elif (head := HEAD.match(code)) and not code.startswith("end"):
            names = [name.strip() for name in (head[3] or "").split(",") if name.strip()]
            if head[1] == "function" and head[4]:
                names.append(head[4])
            inner = bool(open_ones)
            one = Procedure(head[2], line, comment, names)
            open_ones.append(None if inner else one)
            if not inner:
                found.append(one)
        elif open_ones and open_ones[-1] is not None and "::" in code:
            declared = re.findall(r"(\w+)\s*(?:\([^()]*(?:\([^()]*\)[^()]*)*\))?", code.split("::", 1)[1].split("=")[0])
            dummies = [name for name in declared if name in open_ones[-1].arguments]
            for name in dummies:
                open_ones[-1].comments[name] = comment
            if len(dummies) > 1:
                open_ones[-1].shared |= set(dummies)
    return found
