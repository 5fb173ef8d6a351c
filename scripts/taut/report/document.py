"""What a report consists of, apart from how it is rendered."""

from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from taut.formats import listed


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
class Held:
    """A statement held against runs at some settings, in words such as 'with an honest error test'."""

    settings: str
    met: bool


@dataclass(frozen=True)
class Claim:
    """One statement of the paper beside what the runs give; the verdict follows from where it is met."""

    paper: str
    taut: str
    # At the paper's own settings, and at strict ones; empty where the statement says nothing of them.
    at_paper: tuple[Held, ...] = ()
    strict: tuple[Held, ...] = ()
    # Why it is met nowhere, and what else is to be known.
    otherwise: str = ""
    remark: str = ""
    # The figure that it is read from, and the files that its numbers come from.
    figure: str = ""
    files: tuple[Path, ...] = ()

    def __post_init__(self) -> None:
        """Refuses what could lose a condition: settings without words where there are several."""
        if len(self.held) > 1 and not all(one.settings for one in self.held):
            raise ValueError(f"'{self.paper}' is held against several settings and does not name each")

    @property
    def held(self) -> tuple[Held, ...]:
        """Where it was held against runs."""
        return self.at_paper + self.strict

    @property
    def verdict(self) -> Verdict:
        """Reproduced if it is met everywhere, under a condition if somewhere."""
        if not self.held:
            return Verdict.NOT_YET
        met = sum(one.met for one in self.held)
        return Verdict.YES if met == len(self.held) else Verdict.CONDITION if met else Verdict.NO

    @property
    def because(self) -> str:
        """The condition, which is where it is met, or the reason why it is met nowhere; then the remark."""
        said = self.otherwise if self.verdict in (Verdict.NO, Verdict.NOT_YET) else ""
        if self.verdict is Verdict.CONDITION:
            said = listed([one.settings for one in self.held if one.met])
        return "; ".join(filter(None, (said, self.remark)))


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
class Group:
    """Statements and the figures that belong to them."""

    claims: tuple[Claim, ...]
    figures: tuple[Figure, ...]


@dataclass(frozen=True)
class Chapter:
    """A problem of the paper: statements with their figures, then sections."""

    title: str
    reference: str
    claims: tuple[Claim, ...]
    sections: tuple[Section, ...]
    figures: tuple[Figure, ...] = ()
    # What is compared with closed forms; the paper says nothing of it.
    checks: tuple[Claim, ...] = ()
    # What the reader must know before trusting a number, such as a run that ended early.
    warnings: tuple[str, ...] = ()

    @property
    def opening(self) -> tuple[Figure, ...]:
        """The figures that no statement is read from."""
        named = {claim.figure for claim in self.claims}
        return tuple(figure for figure in self.figures if figure.path.stem not in named)

    @property
    def groups(self) -> tuple[Group, ...]:
        """The statements in their order, each figure after the last one that is read from it."""
        groups: list[Group] = []
        rows: list[Claim] = []
        for i, claim in enumerate(self.claims):
            rows.append(claim)
            later = {other.figure for other in self.claims[i + 1 :]}
            done = [f for f in self.figures if f.path.stem == claim.figure and claim.figure not in later]
            if done or i == len(self.claims) - 1:
                groups.append(Group(tuple(rows), tuple(done)))
                rows = []
        return tuple(groups)


@dataclass(frozen=True)
class Report:
    """All chapters."""

    title: str
    lead: str
    chapters: tuple[Chapter, ...]
    # Version, commit and the day of the results; a picture of what else there is.
    made: str = ""
    gallery: Figure | None = None

    def tally(self) -> list[tuple[Verdict, int]]:
        """Returns how many claims have each verdict."""
        claims = [claim for chapter in self.chapters for claim in chapter.claims]
        return [(verdict, sum(claim.verdict is verdict for claim in claims)) for verdict in Verdict]

    def tally_line(self) -> str:
        """Returns the tally in one line."""
        return "   ".join(f"{verdict.sign} {number} {verdict.word}" for verdict, number in self.tally())
