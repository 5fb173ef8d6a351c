"""Figures of a sweep, drawn from its table alone: lines, points, or a map over two parameters."""

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import cm, colors, patheffects, ticker
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from taut import style
from taut.errors import TautError
from taut.files import whole
from taut.results import Array, read_table
from taut.sweep.store import TABLE, TRAJECTORIES
from taut.sweep.sweep_file import Plot, Sweep

# Light yellow is lost on white paper.
MAP = plt.get_cmap("viridis")
SHADES = colors.LinearSegmentedColormap.from_list("shades", MAP(np.linspace(0.0, 0.88, 256)))
ENDED = ("reached-end", "stopped-by-event", "")
# Lines that have room for their names, and cells of a map for a tick each.
MOST_NAMES = 14
FEW_CELLS = 8


class Table:
    """The rows of the table that a figure is drawn from."""

    def __init__(self, path: Path, rows: list[dict[str, str]], left_out: int) -> None:
        """Knows its rows and how many were left out because they ended early."""
        self._path = path
        self.rows = rows
        self.left_out = left_out

    def text(self, name: str) -> list[str]:
        """Returns a column as it is written."""
        if self.rows and name not in self.rows[0]:
            raise TautError(f"{self._path}: no column '{name}'; it has {', '.join(self.rows[0])}")
        return [row[name] for row in self.rows]

    def numbers(self, name: str) -> Array:
        """Returns a column of numbers; what is empty is not a number."""
        try:
            return np.array([float(text) if text else np.nan for text in self.text(name)])
        except ValueError:
            raise TautError(
                f"{self._path}: column '{name}' has texts; an axis needs numbers, while 'lines' and 'where' "
                "take texts too"
            ) from None

    def only(self, rows: list[dict[str, str]]) -> "Table":
        """Returns a table of some of the rows."""
        return Table(self._path, rows, 0)


def draw(sweep: Sweep, plot: Plot, folder: Path, kind: str) -> Path:
    """Draws a figure of a sweep and returns its path."""
    style.use()
    plt.rcParams["svg.hashsalt"] = "taut"
    table = _read(folder / (TRAJECTORIES if plot.over_time else TABLE), plot)
    try:
        figure = _map(plot, table) if plot.z else _lines(plot, table, sweep)
        path = folder / f"{plot.name}.{kind}"
        with whole(path) as part:
            style.save(figure, part, format=kind, bbox_inches="tight", pad_inches=0.08)
    finally:
        plt.close()
    return path


def _read(path: Path, plot: Plot) -> Table:
    """Returns the rows that a figure shows."""
    if not path.is_file():
        raise TautError(f"{path} is missing; x = 't' needs trajectories = [...] under [collect]")
    rows = read_table(path, rows_needed=False).records()
    for name, value in plot.where.items():
        if rows and name not in rows[0]:
            raise TautError(f"{path}: no column '{name}'; it has {', '.join(rows[0])}")
        wanted = value if isinstance(value, list) else [value]
        rows = [row for row in rows if any(_same(row[name], one) for one in wanted)]
    ended = [row for row in rows if row.get("status", "") in ENDED]
    if not ended:
        raise TautError(f"{path}: no row to draw for '{plot.name}'")
    return Table(path, ended, len(rows) - len(ended))


def _same(text: str, value: Any) -> bool:
    """Returns whether an entry of the table is a value of the sweep file."""
    try:
        return float(text) == float(value)
    except (TypeError, ValueError):
        return text == str(value)


def _figure(plot: Plot, table: Table, width: float) -> tuple[Figure, Axes]:
    """Returns an empty figure with title, labels and scales."""
    figure, axes = plt.subplots(figsize=(width, 4.1), layout="constrained")
    axes.set_title(plot.title)
    axes.set_xlabel(plot.labels.get("x", plot.x))
    axes.set_ylabel(plot.labels.get("y", plot.y))
    if "x" in plot.log:
        axes.set_xscale("log")
    if "y" in plot.log:
        axes.set_yscale("log")
    if table.left_out:
        text = f"{table.left_out} that ended early are left out"
        axes.annotate(
            text, (0, 0), (4, 4), "axes fraction", textcoords="offset points", fontsize=8, color=style.GRAY
        )
    return figure, axes


def _values(plot: Plot, axis: str, table: Table, name: str) -> Array:
    """Returns a column for an axis: a logarithmic one shows magnitudes."""
    values = table.numbers(name)
    return np.where(values == 0, np.nan, np.abs(values)) if axis in plot.log else values


def _lines(plot: Plot, table: Table, sweep: Sweep) -> Figure:
    """Draws one line for each value of a second column, or for each method."""
    figure, axes = _figure(plot, table, 6.6)
    by = plot.lines or ("method" if "method" in table.rows[0] else None)
    groups: dict[str, list[dict[str, str]]] = {}
    for row, key in zip(table.rows, table.text(by) if by else [""] * len(table.rows), strict=True):
        groups.setdefault(key, []).append(row)
    barred = by != "method" and len(groups) > MOST_NAMES and _are_numbers(list(groups))
    shades = {}
    if by != "method":
        shades = _bar(axes, plot, list(groups), by or "") if barred else _shades(list(groups))
        groups = {key: groups[key] for key in shades}
    labels = []
    for key, rows in groups.items():
        part = table.only(rows)
        x, y = _values(plot, "x", part, plot.x), _values(plot, "y", part, plot.y)
        if plot.x in (*sweep.columns, "t"):
            # Over a parameter a line runs from left to right; over a result it follows the runs.
            order = np.argsort(x, kind="stable")
            x, y = x[order], y[order]
            if not plot.points and (np.diff(x) == 0).any():
                raise TautError(
                    f"'{plot.name}': several rows have the same {plot.x}; "
                    "choose with where or lines, or draw points = true"
                )
        if by == "method":
            look = style.method_style(key)
            keys = look.line(len(x)) | ({} if plot.over_time else {"markevery": 1})
            # Runs may differ in the gains of a method, so its name is without; labels of one's own stay.
            label = look.label.partition(" (")[0] if key in style.METHODS else key
        else:
            keys = {"color": shades[key], "linewidth": 1.4}
            keys |= {} if plot.over_time and not plot.points else {"marker": "o", "markersize": 3.2}
            label = _short(key)
        if plot.points:
            keys |= {"linestyle": "none", "markersize": 4}
        axes.plot(x, y, label=label, **keys)
        labels.append((x, y, label, keys["color"]))
    for axis in (axes.xaxis, axes.yaxis):
        _plain_ticks(axis)
    if len(groups) > 1 and not barred:
        _name(axes, plot, labels, by or "")
    return figure


def _short(text: str) -> str:
    """Returns a number with few digits, as the axes write them, and any other text as it is."""
    try:
        value = float(text)
    except ValueError:
        return text
    digits = f"{value:g}"
    if value != 0 and not 1e-3 <= abs(value) < 1e5:
        # The same digits as a power of ten, whichever way %g chose.
        digits = f"{float(digits):e}"
    mantissa, _, power = digits.partition("e")
    digits = f"{float(mantissa):g}"
    digits = digits.replace("-", "\N{MINUS SIGN}")
    if not power:
        return digits
    power = f"10^{{{int(power)}}}"
    return f"${power}$" if digits == "1" else rf"{digits}$\times {power}$"


def _shades(keys: list[str]) -> dict[str, Any]:
    """Returns a color for each line, sorted: light to dark along numbers, as they grow."""
    order = sorted(keys, key=float) if _are_numbers(keys) else keys
    return {key: SHADES(1 - i / max(len(order) - 1, 1)) for i, key in enumerate(order)}


def _are_numbers(texts: list[str]) -> bool:
    """Returns whether all texts are numbers."""
    try:
        return all(np.isfinite(float(text)) for text in texts)
    except ValueError:
        return False


def _bar(axes: Axes, plot: Plot, keys: list[str], by: str) -> dict[str, Any]:
    """Draws a color bar for more lines than have room for their names, and returns their colors."""
    values = [float(key) for key in keys]
    low, high = min(values), max(values)
    norm = colors.LogNorm(low, high) if 0 < 100 * low <= high else colors.Normalize(low, high)
    scale = cm.ScalarMappable(norm, SHADES.reversed())
    bar = axes.figure.colorbar(scale, ax=axes, label=plot.labels.get("lines", by), pad=0.02)
    bar.outline.set_visible(False)
    return {
        key: scale.to_rgba(value)
        for key, value in sorted(zip(keys, values, strict=True), key=lambda pair: pair[1])
    }


def _name(axes: Axes, plot: Plot, labels: list[tuple[Array, Array, str, Any]], by: str) -> None:
    """Writes the lines' names: methods and texts in a legend, numbers at the ends of their lines."""
    title = plot.labels.get("lines", by)
    names = [label for _, _, label, _ in labels]
    if by == "method":
        axes.legend(loc="best", title=plot.labels.get("lines"), handlelength=3.2)
        return
    if plot.points or len(labels) > MOST_NAMES:
        # Beside the axes, where it covers nothing.
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), title=title, ncols=-(-len(names) // 20))
        return
    axes.figure.canvas.draw()
    ends = [(x[np.isfinite(y)][-1:], y[np.isfinite(y)][-1:]) for x, y, _, _ in labels]
    ends = [(x[0], y[0]) if x.size else (np.nan, np.nan) for x, y in ends]
    heights = [axes.transAxes.inverted().transform(axes.transData.transform(end))[1] for end in ends]
    heights = style.spread([h if np.isfinite(h) else 0.0 for h in heights], 0.05, (0.0, 0.94))
    for height, (_, _, label, color) in zip(heights, labels, strict=True):
        axes.annotate(label, (1.01, height), xycoords="axes fraction", color=color, va="center", fontsize=9)
    axes.annotate(
        title,
        (1.01, max(heights) + 0.06),
        xycoords="axes fraction",
        va="center",
        fontsize=9,
        color=style.GRAY,
    )


def _map(plot: Plot, table: Table) -> Figure:
    """Draws a column as colors over two others: cells of a grid with contours, or the samples as dots."""
    figure, axes = _figure(plot, table, 6.8)
    x, y = (_values(plot, axis, table, name) for axis, name in (("x", plot.x), ("y", plot.y)))
    z = _values(plot, "z", table, str(plot.z))
    if not np.isfinite(z).any():
        raise TautError(f"'{plot.name}': no number in '{plot.z}'")
    low, high = np.nanmin(z), np.nanmax(z)
    norm = colors.LogNorm(low, high) if "z" in plot.log else colors.Normalize(low, high)
    xs, ys = np.unique(x), np.unique(y)
    if len(xs) > 1 and len(ys) > 1 and len(xs) * len(ys) <= 4 * len(z):
        grid = np.full((len(ys), len(xs)), np.nan)
        places = np.searchsorted(ys, y), np.searchsorted(xs, x)
        if len(set(zip(*map(list, places), strict=True))) < len(z):
            raise TautError(
                f"'{plot.name}': several rows have the same {plot.x} and {plot.y}; choose with where"
            )
        grid[places] = z
        edges = (_edges(xs, "x" in plot.log), _edges(ys, "y" in plot.log))
        shown = axes.pcolormesh(*edges, grid, cmap=MAP, norm=norm, rasterized=True)
        for at, axis in ((xs, axes.xaxis), (ys, axes.yaxis)):
            if len(at) <= FEW_CELLS:
                axis.set_major_locator(ticker.FixedLocator(at))
                axis.set_major_formatter(ticker.FixedFormatter([_short(str(value)) for value in at]))
                axis.set_minor_locator(ticker.NullLocator())
        if plot.contours:
            levels = sorted(level for level in plot.contours if low < level < high)
            if not levels:
                raise TautError(
                    f"'{plot.name}': no contour is between {low:g} and {high:g}, where {plot.z} is"
                )
            lines = axes.contour(
                xs, ys, grid, levels=levels, colors="white", linewidths=0.9, linestyles="solid"
            )
            texts = axes.clabel(lines, fmt=lambda level: _short(str(level)), fontsize=8)
            # A dark edge, for the lightest colors are almost white.
            edge = [patheffects.withStroke(linewidth=1.7, foreground="#1f2937")]
            for drawn in (lines, *texts):
                drawn.set_path_effects(edge)
    else:
        if plot.contours:
            raise TautError(f"'{plot.name}': contours need a grid of {plot.x} and {plot.y}; leave them out")
        shown = axes.scatter(x, y, c=z, cmap=MAP, norm=norm, s=26, edgecolors="white", linewidths=0.4)
    axes.grid(False)
    bar = figure.colorbar(shown, ax=axes, label=plot.labels.get("z", plot.z), pad=0.02)
    bar.outline.set_visible(False)
    for axis in (axes.xaxis, axes.yaxis):
        _plain_ticks(axis)
    return figure


def _plain_ticks(axis: Any) -> None:
    """Writes the ticks of less than two decades as plain numbers."""
    low, high = axis.get_view_interval()
    if (
        axis.get_scale() == "log"
        and not isinstance(axis.get_major_locator(), ticker.FixedLocator)
        and high < 100 * low
    ):
        axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(ticker.FormatStrFormatter("%g"))
        axis.set_minor_formatter(ticker.NullFormatter())


def _edges(centers: Array, log: bool) -> Array:
    """Returns the edges of cells around centers."""
    at = np.log(centers) if log else centers
    middle = (at[1:] + at[:-1]) / 2
    edges = np.concatenate([[2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]])
    return np.exp(edges) if log else edges
