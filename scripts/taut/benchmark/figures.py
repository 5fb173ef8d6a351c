"""The figures, drawn from the table alone: work against precision, cost against the size, both pairs."""

from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
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
    "taut, stages as they are": MethodStyle(
        "taut, stages as they are", METHODS["present"].color, (0, (4, 2)), "v"
    ),
    "taut, Eq. (8)": METHODS["baseline"],
    "taut, phi alone": MethodStyle("taut, phi alone", METHODS["present"].color, (0, (1, 1.5)), "*"),
    "taut, dop853": MethodStyle("taut, dop853", "#CC79A7", "solid", "D"),
    "taut, dop853, stages as they are": MethodStyle(
        "taut, dop853, stages as they are", "#CC79A7", (0, (4, 2)), "d"
    ),
    "taut, Radau IIA": MethodStyle("taut, Radau IIA", "#7F3C8D", "solid", "o"),
    "taut, generalized-alpha": MethodStyle("taut, generalized-alpha", "#7F3C8D", (0, (4, 2)), "P"),
    "SciPy RK45": MethodStyle("SciPy RK45", "#D55E00", "solid", "s"),
    "SciPy DOP853": MethodStyle("SciPy DOP853", "#D55E00", (0, (4, 2)), "v"),
    "SciPy Radau": MethodStyle("SciPy Radau", "#E69F00", "solid", "s"),
    "SciPy BDF": MethodStyle("SciPy BDF", "#E69F00", (0, (4, 2)), "v"),
    "SUNDIALS ARKODE": MethodStyle("SUNDIALS ARKODE", "#009E73", "solid", "^"),
    "SUNDIALS ARKODE, order 8": MethodStyle("SUNDIALS ARKODE, order 8", "#009E73", (0, (4, 2)), "<"),
    "SUNDIALS ARKStep": MethodStyle("SUNDIALS ARKStep", "#000000", (0, (4, 2)), ">"),
    "SUNDIALS IDA": MethodStyle("SUNDIALS IDA", "#000000", (0, (1, 1)), "p"),
    "Exudyn, generalized-alpha": MethodStyle("Exudyn, generalized-alpha", "#8C6D46", (0, (4, 2)), "h"),
    "Pinocchio": MethodStyle("Pinocchio", "#56B4E9", "solid", "X"),
}


# Points are close whose logarithms differ by less.
CLOSE = 0.5
# Who is in the figures of the explicit pairs, and the problems and sizes of their panels.
PAIRS = (
    "taut",
    "taut, stages as they are",
    "taut, dop853",
    "taut, dop853, stages as they are",
    "SciPy DOP853",
    "SUNDIALS ARKODE",
    "SUNDIALS ARKODE, order 8",
)
PAIR_PANELS = (
    ("pendulum", 1),
    ("four-bar", 2),
    ("four-bar", 40),
    ("chain", 100),
    ("heavy_top", 1),
    ("bricard", 1),
    ("andrews", 1),
)

# Panels beside each other in the other figures.
MOST_IN_A_ROW = 4


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
    """Returns a figure with a panel for each problem, at most four in a row."""
    columns = min(len(names), MOST_IN_A_ROW)
    rows = -(-len(names) // columns)
    size = (max(4.0 * columns, 6.5), 3.6 * rows + 0.8)
    figure, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)
    for unused in axes.flat[len(names) :]:
        unused.axis("off")
    return figure, dict(zip(names, axes.flat, strict=False))


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
        error_unit = PROBLEMS[name].error_unit if name in PROBLEMS else "m"
        alone: list[tuple[str, Measurement]] = []
        for entrant in order(mine):
            # Errors of order one and more are no solutions.
            line = sorted(
                (row for row in mine if row.entrant == entrant and row.size == size and row.error < 0.5),
                key=lambda row: -row.setting,
            )
            panel.plot([row.error for row in line], [1e3 * row.seconds for row in line], **look(entrant))
            alone += [(entrant, row) for row in line if len(line) == 1]
        panel.set(xscale="log", yscale="log", xlabel=f"error at the end [{error_unit}]")
        name_lone_points(panel, alone)
        panel.set_title(title(name) if size == 1 else f"{title(name)}: {size} {unit}")
        if panel.get_subplotspec().is_first_col():
            panel.set_ylabel("processor time [ms]")
    legend(figure, order(rows))
    return figure


def name_lone_points(panel: Axes, alone: Sequence[tuple[str, Measurement]]) -> None:
    """Says which entrants have one setting alone, towards the middle; close ones one above the other."""
    low, high = np.log(panel.get_xlim())
    for index, (entrant, row) in enumerate(alone):
        near = [
            other
            for _, other in alone[:index]
            if max(abs(np.log(other.error / row.error)), abs(np.log(other.seconds / row.seconds))) < CLOSE
        ]
        right = np.log(row.error) > (low + high) / 2
        panel.annotate(
            f"{entrant}: one setting",
            (row.error, 1e3 * row.seconds),
            (-6 if right else 6, 4 + 9 * len(near)),
            textcoords="offset points",
            fontsize=7.5,
            color=GRAY,
            ha="right" if right else "left",
        )


def strictest(rows: Sequence[Measurement], targets: Sequence[float]) -> float:
    """Returns the error that most entrants reach; of several the smallest."""

    def reached(target: float) -> int:
        return len({row.entrant for row in rows if row.reaches(target)})

    return max(sorted(targets), key=reached)


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
                    strictest([row for row in mine if row.size == size], PROBLEMS[name].targets(size)),
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


def pairs(rows: Sequence[Measurement], label: str, cost: Callable[[Measurement], float]) -> Figure | None:
    """Draws a cost against the error for both explicit pairs; nothing where one of them was not measured."""
    mine = [row for row in rows if row.entrant in PAIRS and (row.problem, row.size) in PAIR_PANELS]
    if not {"taut", "taut, dop853"} <= {row.entrant for row in mine}:
        return None
    found = [panel for panel in PAIR_PANELS if panel in {(row.problem, row.size) for row in mine}]
    figure, axes = plt.subplots(2, 4, figsize=(13.0, 6.6), layout="constrained")
    for (name, size), panel in zip(found, axes.flat, strict=False):
        problem = PROBLEMS[name]
        for entrant in order(mine):
            line = sorted(
                (
                    row
                    for row in mine
                    if (row.problem, row.size, row.entrant) == (name, size, entrant) and row.error < 0.5
                ),
                key=lambda row: -row.setting,
            )
            panel.plot([row.error for row in line], [cost(row) for row in line], **look(entrant))
        panel.set(xscale="log", yscale="log", xlabel=f"error at the end [{problem.error_unit}]")
        panel.set_title(
            f"{problem.title}: {size} {problem.unit}" if len(problem.sizes) > 1 else problem.title
        )
        if panel in axes[:, 0]:
            panel.set_ylabel(label)
    # The legend takes the first place that is left; there is one more than problems.
    for panel in axes.flat[len(found) :]:
        panel.axis("off")
    handles = [
        Line2D([0, 0.5, 1], [0, 0, 0], label=name, **look(name) | {"markevery": [1]}) for name in order(mine)
    ]
    axes.flat[len(found)].legend(handles=handles, loc="center", handlelength=3.4)
    return figure


def save(rows: Sequence[Measurement], folder: Path) -> list[Path]:
    """Writes all figures as PNG and PDF."""
    style.use()
    paths = []
    drawn = {
        "work_precision": work_precision(rows),
        "cost_size": cost_size(rows),
        "pairs_rhs": pairs(rows, "right-hand sides", lambda row: row.rhs),
        "pairs_time": pairs(rows, "processor time [ms]", lambda row: 1e3 * row.seconds),
    }
    for name, figure in drawn.items():
        if figure is None:
            continue
        for kind in ("pdf", "png"):
            paths.append(folder / f"{name}.{kind}")
            style.save(figure, paths[-1])
    return paths
