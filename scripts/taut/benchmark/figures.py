"""The two figures, drawn from the table alone: work against precision, and cost against the size."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from taut import style
from taut.benchmark.measure import Measurement, cheapest
from taut.benchmark.problems import PROBLEMS
from taut.style import GRAY, METHODS, MethodStyle

# taut's methods look as they do everywhere; the others have what is left of Okabe and Ito's colors.
ENTRANTS: dict[str, MethodStyle] = {
    "taut": METHODS["present"],
    "taut, stages as they are": METHODS["present-position"],
    "taut, Eq. (8)": METHODS["baseline"],
    "taut, Radau IIA": MethodStyle("taut, Radau IIA", "#7F3C8D", "solid", "o"),
    "taut, generalized-alpha": MethodStyle("taut, generalized-alpha", "#7F3C8D", (0, (4, 2)), "P"),
    "SciPy RK45": MethodStyle("SciPy RK45", "#D55E00", "solid", "s"),
    "SciPy DOP853": MethodStyle("SciPy DOP853", "#D55E00", (0, (4, 2)), "v"),
    "SciPy Radau": MethodStyle("SciPy Radau", "#E69F00", "solid", "s"),
    "SciPy BDF": MethodStyle("SciPy BDF", "#E69F00", (0, (4, 2)), "v"),
    "SUNDIALS ARKODE": MethodStyle("SUNDIALS ARKODE", "#009E73", "solid", "^"),
    "Pinocchio": MethodStyle("Pinocchio", "#56B4E9", "solid", "X"),
}


def look(entrant: str) -> dict[str, object]:
    """Returns the keywords of an entrant's line, every point marked; a new entrant is gray."""
    found = ENTRANTS.get(entrant, MethodStyle(entrant, GRAY, (0, (2, 2)), "x"))
    return found.line(9) | {"markevery": 1}


def legend(figure: Figure, entrants: Sequence[str]) -> None:
    """Puts one legend above all panels."""
    handles = [
        Line2D([0, 0.5, 1], [0, 0, 0], label=name, **look(name) | {"markevery": [1]}) for name in entrants
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=3, columnspacing=2.0, handlelength=3.4)


def shown_size(rows: Sequence[Measurement]) -> int:
    """Returns the size for work against precision: the middle one of those with several entrants."""
    entrants: dict[int, set[str]] = {}
    for row in rows:
        entrants.setdefault(row.size, set()).add(row.peer)
    most = max(map(len, entrants.values()))
    sizes = sorted(size for size, names in entrants.items() if len(names) == most)
    return sizes[len(sizes) // 2]


def panels(names: Sequence[str]) -> tuple[Figure, dict[str, plt.Axes]]:
    """Returns a figure with a panel for each problem."""
    figure, axes = plt.subplots(
        1, len(names), figsize=(max(4.0 * len(names), 6.5), 4.4), layout="constrained", squeeze=False
    )
    return figure, dict(zip(names, axes[0], strict=True))


def title(name: str) -> str:
    """Returns a problem's title; one that is no longer there has its name."""
    return PROBLEMS[name].title if name in PROBLEMS else name


def order(rows: Sequence[Measurement]) -> list[str]:
    """Returns the entrants of some rows in the order of the styles, new ones last."""
    known = list(ENTRANTS)
    found = dict.fromkeys(row.entrant for row in rows)
    return sorted(found, key=lambda name: known.index(name) if name in known else len(known))


def work_precision(rows: Sequence[Measurement]) -> Figure:
    """Draws time against error, a panel for each problem; the better, the further to the lower left."""
    figure, axes = panels(list(dict.fromkeys(row.problem for row in rows)))
    for name, panel in axes.items():
        mine = [row for row in rows if row.problem == name]
        size = shown_size(mine)
        unit = PROBLEMS[name].unit if name in PROBLEMS else ""
        for entrant in order(mine):
            # Errors of order one and more are no solutions.
            line = sorted(
                (row for row in mine if row.entrant == entrant and row.size == size and row.error < 0.5),
                key=lambda row: -row.setting,
            )
            panel.plot([row.error for row in line], [1e3 * row.seconds for row in line], **look(entrant))
            if len(line) == 1:
                at, said = (line[0].error, 1e3 * line[0].seconds), f"{entrant}: one setting gets below 0.5 m"
                panel.annotate(said, at, (6, 4), textcoords="offset points", fontsize=7.5, color=GRAY)
        panel.set(xscale="log", yscale="log", xlabel="error at the end [m]")
        panel.set_title(title(name) if size == 1 else f"{title(name)}: {size} {unit}")
    next(iter(axes.values())).set_ylabel("processor time [ms]")
    legend(figure, order(rows))
    return figure


def cost_size(rows: Sequence[Measurement]) -> Figure | None:
    """Draws the time of a step against the size for problems of several sizes; without one, nothing."""
    sizes: dict[str, set[int]] = {}
    for row in rows:
        sizes.setdefault(row.problem, set()).add(row.size)
    names = [name for name, found in sizes.items() if len(found) > 1 and name in PROBLEMS]
    if not names:
        return None
    figure, axes = panels(names)
    for name, panel in axes.items():
        mine = [row for row in rows if row.problem == name]
        for entrant in order(mine):
            best = [
                cheapest(
                    [row for row in mine if row.entrant == entrant and row.size == size],
                    min(PROBLEMS[name].targets(size)),
                ).get(entrant)
                for size in sorted(sizes[name])
            ]
            reached = [row for row in best if row]
            panel.plot(
                [row.size for row in reached], [row.microseconds_per_step for row in reached], **look(entrant)
            )
        panel.set(xscale="log", yscale="log", xlabel=f"number of {PROBLEMS[name].unit}", title=title(name))
        # The sizes themselves are the ticks.
        panel.set_xticks(sorted(sizes[name]), [f"{size:,}" for size in sorted(sizes[name])])
        panel.xaxis.set_minor_formatter(NullFormatter())
    next(iter(axes.values())).set_ylabel("processor time of a step [µs]")
    legend(figure, order([row for row in rows if row.problem in names]))
    return figure


def save(rows: Sequence[Measurement], folder: Path) -> list[Path]:
    """Writes both figures as PNG and PDF."""
    style.use()
    paths = []
    for name, figure in (("work_precision", work_precision(rows)), ("cost_size", cost_size(rows))):
        if figure is None:
            continue
        for kind in ("pdf", "png"):
            paths.append(folder / f"{name}.{kind}")
            style.save(figure, paths[-1])
    return paths
