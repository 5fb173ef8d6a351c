"""What a report consists of, apart from how it is rendered."""

from dataclasses import dataclass
from enum import Enum
from pathlib import Path


class Verdict(Enum):
    """Whether a statement of the paper is met: the sign is read without color, the word without the sign."""

    YES = ("✓", "reproduced")
    CONDITION = ("◐", "reproduced under a condition")
    NO = ("✗", "not reproduced")
    NOT_YET = ("○", "not yet")

    @property
    def sign(self) -> str:
        """A sign for the verdict."""
        return self.value[0]

    @property
    def word(self) -> str:
        """The verdict in words."""
        return self.value[1]


@dataclass(frozen=True)
class Claim:
    """One statement of the paper beside what the runs give."""

    paper: str
    taut: str
    verdict: Verdict
    # The condition, or the reason why not.
    because: str = ""


@dataclass(frozen=True)
class Paragraph:
    """Running text; `code` stands between backticks."""

    text: str


@dataclass(frozen=True)
class Table:
    """Rows under a header; the columns after the first `text_columns` hold numbers and align right."""

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    text_columns: int = 1

    def __post_init__(self) -> None:
        """Refuses rows that do not fit the header."""
        for row in self.rows:
            if len(row) != len(self.header):
                raise ValueError(
                    f"{self.caption}: {len(row)} entries under {len(self.header)} columns: {row}"
                )


@dataclass(frozen=True)
class Figure:
    """A picture with its caption; text stands for the picture where there is none."""

    title: str
    path: Path
    caption: str


@dataclass(frozen=True)
class Section:
    """A heading and what follows it."""

    title: str
    blocks: tuple[Paragraph | Table | Figure, ...]


@dataclass(frozen=True)
class Chapter:
    """A problem of the paper: the claims go to the opening table, the sections follow."""

    title: str
    reference: str
    claims: tuple[Claim, ...]
    sections: tuple[Section, ...]
    # What the reader must know before trusting a number, such as a run that ended early.
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Report:
    """All chapters."""

    title: str
    lead: str
    chapters: tuple[Chapter, ...]

    def tally(self) -> list[tuple[Verdict, int]]:
        """Returns how many claims have each verdict."""
        claims = [claim for chapter in self.chapters for claim in chapter.claims]
        return [(verdict, sum(claim.verdict is verdict for claim in claims)) for verdict in Verdict]
