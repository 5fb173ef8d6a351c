"""Figures of a sweep: drawn from the table alone, and the same from the same table."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure

from taut import style
from taut.errors import TautError
from taut.sweep import plot as plots
from taut.sweep import sweep_file

PARAMETERS = """case = "base.nml"
[[parameter]]
name = "a"
entry = "pendulum.mass"
list = [1.0, 2.0, 3.0]
[[parameter]]
name = "b"
entry = "pendulum.length"
list = [10.0, 20.0]
"""


def sweep(folder: Path, block: str) -> sweep_file.Sweep:
    (folder / "base.nml").write_text("&pendulum /\n")
    (folder / "sweep.toml").write_text(f'{PARAMETERS}[[plot]]\nname = "figure"\n{block}\n')
    rows = ["run,a,b,method,status,work,q"]
    for i, (a, b) in enumerate([(a, b) for a in (3.0, 1.0, 2.0) for b in (10.0, 20.0)], start=1):
        for method, factor in (("present", -1), ("baseline", 2)):
            rows.append(f"{i},{a},{b},{method},reached-end,{100 - a},{factor * a * b}")
    rows.append("7,4.0,10.0,present,too-many-steps,1,1e9")
    (folder / "table.csv").write_text("\n".join(rows) + "\n")
    return sweep_file.read(folder / "sweep.toml")


def drawn(read: sweep_file.Sweep, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Figure:
    """Draws the first figure of a sweep and keeps it."""
    kept: list[Figure] = []
    monkeypatch.setattr(plots.plt, "close", lambda *_: kept.append(plt.gcf()))
    plots.draw(read, read.plots[0], folder, "png")
    monkeypatch.undo()
    plt.close("all")
    return kept[0]


def draw(folder: Path, block: str, monkeypatch: pytest.MonkeyPatch) -> Figure:
    return drawn(sweep(folder, block), folder, monkeypatch)


def test_a_line_for_each_method_in_its_style(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    figure = draw(tmp_path, 'x = "a"\ny = "q"\nwhere = { b = 10 }\nlog = ["y"]', monkeypatch)
    first, second = figure.axes[0].get_lines()
    assert first.get_color() == style.METHODS["present"].color
    # Sorted along the parameter, magnitudes on the logarithmic axis, without the run that ended early.
    assert first.get_xdata().tolist() == [1, 2, 3] and first.get_ydata().tolist() == [10, 20, 30]
    assert second.get_ydata().tolist() == [20, 40, 60]
    assert "1 that ended early" in "".join(text.get_text() for text in figure.axes[0].texts)


def test_a_line_for_each_value_and_work_in_the_order_of_the_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    block = 'x = "work"\ny = "q"\nlines = "b"\nwhere = { method = "baseline" }'
    lines = draw(tmp_path, block, monkeypatch).axes[0].get_lines()
    assert [line.get_xdata().tolist() for line in lines] == [[97, 99, 98]] * 2
    assert [line.get_ydata().tolist() for line in lines] == [[60, 20, 40], [120, 40, 80]]


def test_a_map_has_each_value_in_its_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    block = 'x = "a"\ny = "b"\nz = "q"\nwhere = { method = "baseline" }\ncontours = [50]'
    figure = draw(tmp_path, block, monkeypatch)
    (mesh,) = (c for c in figure.axes[0].collections if type(c).__name__ == "QuadMesh")
    assert np.asarray(mesh.get_array()).tolist() == [[20, 40, 60], [40, 80, 120]]


@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_the_same_table_makes_the_same_file(tmp_path: Path, kind: str) -> None:
    read = sweep(tmp_path, 'x = "a"\ny = "q"\nwhere = { b = 10 }')
    first, second = (plots.draw(read, read.plots[0], tmp_path, kind).read_bytes() for _ in range(2))
    assert first == second and len(first) > 5000


@pytest.mark.parametrize(
    ("block", "parts"),
    [
        ('x = "c"\ny = "q"', ("no column 'c'", "it has run, a, b")),
        ('x = "a"\ny = "method"', ("column 'method' has texts", "'lines'")),
        ('x = "a"\ny = "b"\nz = "q"\nwhere = { method = "present" }\ncontours = [1.0]', ("no contour", "q")),
        ('x = "work"\ny = "q"\nz = "a"\nwhere = { run = 1 }\ncontours = [1.0]', ("contours need a grid",)),
        ('x = "t"\ny = "q"', ("trajectories.csv", "[collect]")),
        ('x = "a"\ny = "q"', ("several rows have the same a", "where")),
        ('x = "a"\ny = "b"\nz = "q"', ("several rows", "where")),
        ('x = "a"\ny = "q"\nwhere = { b = 11 }', ("no row", "figure")),
    ],
)
def test_what_cannot_be_drawn_is_told_in_one_line(tmp_path: Path, block: str, parts: tuple[str, ...]) -> None:
    read = sweep(tmp_path, block)
    # What a worker has drawn for other tests is not what is asked.
    plt.close("all")
    with pytest.raises(TautError) as caught:
        plots.draw(read, read.plots[0], tmp_path, "png")
    assert not plt.get_fignums()
    assert "\n" not in str(caught.value)
    for part in parts:
        assert part in str(caught.value)
    assert not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize(
    ("text", "short"),
    [
        ("0.30000000000000004", "0.3"),
        ("-2.5", "\N{MINUS SIGN}2.5"),
        ("1e-05", "$10^{-5}$"),
        ("0.0001", "$10^{-4}$"),
        ("250000.0", r"2.5$\times 10^{5}$"),
        ("-1e-6", "\N{MINUS SIGN}1$\\times 10^{-6}$"),
        ("0", "0"),
        ("inf", "inf"),
        ("beam", "beam"),
    ],
)
def test_numbers_are_short(text: str, short: str) -> None:
    assert plots._short(text) == short


def many(folder: Path, names: list[str], column: str) -> sweep_file.Sweep:
    """Returns a sweep of one figure, with a line for each of some values."""
    block = f'x = "a"\ny = "q"\nlines = "{column}"'
    read = sweep(folder, block)
    rows = [f"{i},{a},{name},x,reached-end,1,{a}" for i, name in enumerate(names) for a in (1, 2)]
    (folder / "table.csv").write_text("\n".join(["run,a,b,method,status,work,q", *rows]) + "\n")
    return read


def test_lines_are_named_in_the_order_of_their_values(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figure = drawn(many(tmp_path, ["10.0", "9.0", "-1.0"], "b"), tmp_path, monkeypatch)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts == ["\N{MINUS SIGN}1", "9", "10", "b"]
    assert [line.get_label() for line in figure.axes[0].get_lines()] == texts[:3]


def test_many_numbers_have_a_color_bar(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    figure = drawn(many(tmp_path, [f"{i}.0" for i in range(1, 31)], "b"), tmp_path, monkeypatch)
    axes, bar = figure.axes
    assert axes.get_legend() is None and bar.get_ylabel() == "b"
    assert len({line.get_color() for line in axes.get_lines()}) == 30


def test_many_texts_have_a_legend_with_the_name_of_what_varies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figure = drawn(many(tmp_path, [f"n{i}" for i in range(30)], "b"), tmp_path, monkeypatch)
    assert figure.axes[0].get_legend().get_title().get_text() == "b"


def test_methods_are_named_without_gains_and_labels_as_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = many(tmp_path, ["1.0"], "method")
    table = (tmp_path / "table.csv").read_text()
    more = table.partition("\n")[2].replace(",x,", ",baumgarte,")
    soft = table.partition("\n")[2].replace(",x,", ",baumgarte-soft,")
    (tmp_path / "table.csv").write_text(table + more + soft)
    lines = drawn(read, tmp_path, monkeypatch).axes[0].get_lines()
    assert [line.get_label() for line in lines] == ["x", "Baumgarte", "baumgarte-soft"]


def test_a_map_of_few_cells_has_a_tick_for_each(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    block = 'x = "a"\ny = "b"\nz = "q"\nwhere = { method = "baseline" }\nlog = ["y"]'
    axes = draw(tmp_path, block, monkeypatch).axes[0]
    assert axes.get_xticks().tolist() == [1, 2, 3] and axes.get_yticks().tolist() == [10, 20]
    assert [text.get_text() for text in axes.get_yticklabels()] == ["10", "20"]
