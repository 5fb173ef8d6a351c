"""The columns of a result: all, or those that the case asks for, with the same numbers."""

import csv
from pathlib import Path

from conftest import Run

METHOD = "&integration t_end = 0.5 /\n"


def table(path: Path) -> dict[str, list[str]]:
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def test_chosen_columns(run: Run, tmp_path: Path) -> None:
    (tmp_path / "all.nml").write_text(METHOD)
    (tmp_path / "some.nml").write_text(METHOD + '&output columns = "z", "*dot", "l*a", "ene*rgy*" /')
    assert run("all.nml", "some.nml").returncode == 0
    everything = table(tmp_path / "results/all/present.csv")
    some = table(tmp_path / "results/some/present.csv")
    assert list(some) == ["t", "z", "phidot", "phiddot", "energy", "lambda"]
    assert some == {name: everything[name] for name in some}
    assert len(everything) == 16
