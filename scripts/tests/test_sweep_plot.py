"""Figures of a sweep: drawn from the table alone, and the same from the same table."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure
from taut_report import style
from taut_sweep import plot as plots
from taut_sweep import sweep_file
from taut_sweep.files import SweepError

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


def draw(folder: Path, block: str, monkeypatch: pytest.MonkeyPatch) -> Figure:
    kept: list[Figure] = []
    monkeypatch.setattr(plots.plt, "close", lambda: kept.append(plt.gcf()))
    read = sweep(folder, block)
    plots.draw(read, read.plots[0], folder, "png")
    monkeypatch.undo()
    plt.close("all")
    return kept[0]


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
    with pytest.raises(SweepError) as caught:
        plots.draw(read, read.plots[0], tmp_path, "png")
    assert not plt.get_fignums()
    assert "\n" not in str(caught.value)
    for part in parts:
        assert part in str(caught.value)
    assert not list(tmp_path.glob("*.png"))
