"""Sweeps of very many short runs, each of which leaves a row and no files."""

import csv
import shutil
import signal
from pathlib import Path

import pytest
from sweep_runs import CASE, Begin, Sweep, assert_refused, home, program, records, table, wait_until, write

from taut.sweep.batch import mend, read_rows

ROWS = 'keep = "rows"\n'
HUNDREDS = "random = { count = 300, seed = 1, uniform = [1, 2] }"
# A program in the place of the pendulum, which one value of the list ends.
CRASHES = """[ "$1" = --help ] && { echo "--runs"; exit; }
case "$*" in *none*) echo "case.nml/none/" >&2; exit 1;; esac
[ "$2" = --runs ] || exit 0
echo run,case,method,status,wall_seconds,message
while read -r run value; do
  if [ "$value" = 3.0 ]; then echo "out of luck" >&2; kill -SEGV $$; fi
  echo "$run,case,present,reached-end,1.0,"
done <runs.tsv
"""


def rows_of(folder: Path, values: str, more: str = "", **options: str) -> None:
    write(folder, values, more, **options)
    path = folder / "sweep.toml"
    path.write_text(ROWS + path.read_text())


def files(folder: Path) -> list[Path]:
    return [path for path in home(folder).rglob("*") if path.is_file()]


def test_a_row_is_that_of_the_single_run(sweep: Sweep, tmp_path: Path) -> None:
    values = "latin_hypercube = { count = 60, seed = 2, uniform = [1, 2] }\n"
    values += (
        'also = { "pendulum.length" = 0.7, "method[2].alpha" = 3.0 }\n[fixed]\n"integration.rtol" = 1e-7\n'
    )
    case = CASE.replace('"baseline"', '"baumgarte", alpha = 1.0')
    write(tmp_path, values, case=case)
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    single = (home(tmp_path) / "table.csv").read_text().splitlines()
    shutil.rmtree(home(tmp_path))
    rows_of(tmp_path, values, case=case)
    assert "60 runs in 3 batches" in sweep("plan").stdout
    done = sweep("run")
    assert done.returncode == 0 and done.stderr == "" and "60 runs in" in done.stdout
    assert "3 done, 0 running, 0 failed, 0 missing\n60 of 60 runs have rows" in sweep("status").stdout
    assert sweep("collect").returncode == 0
    joined = (home(tmp_path) / "table.csv").read_text().splitlines()
    assert joined[0] == single[0] + ",message"
    assert joined[1:] == [line + "," for line in single[1:]]
    timing = table(tmp_path, "timing.csv")
    assert len(timing) == 120 and float(timing[0]["wall_seconds"]) > 0 and timing[0]["attempts"] == "1"
    # Nothing to do, and nothing is touched.
    assert sweep("run").stdout == "sweep: 60 runs in 3 batches, nothing left to do\n"
    assert not [path for path in files(tmp_path) if path.name in ("case.nml", "runs.tsv", "stderr.log")]


def test_killed_at_any_moment_it_ends_with_the_same_table(sweep: Sweep, tmp_path: Path, begin: Begin) -> None:
    rows_of(tmp_path, HUNDREDS, case=CASE.replace("0.5", "5"))
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    undisturbed = (home(tmp_path) / "table.csv").read_bytes()
    shutil.rmtree(home(tmp_path))
    for size in (1e3, 4e4, 1e5):
        process = begin()
        wait_until(lambda s=size: sum(p.stat().st_size for p in home(tmp_path).glob("runs/*/rows.csv")) > s)
        process.kill()
        process.wait()
        assert_refused(sweep("collect"), "of 12 batches have no results", "--partial")
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    assert (home(tmp_path) / "table.csv").read_bytes() == undisturbed


def test_ctrl_c_stops_cleanly(sweep: Sweep, tmp_path: Path, begin: Begin) -> None:
    rows_of(tmp_path, "range = { start = 1, stop = 50, step = 1 }", case=CASE.replace("0.5", "1e3"))
    process = begin("--jobs", "2")
    rows = home(tmp_path) / "runs"
    wait_until(lambda: sum(path.stat().st_size > 1000 for path in rows.glob("*/rows.csv")) == 2)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said == "sweep: stopped with 2 batches to go; go on with scripts/sweep run sweep.toml\n"
    assert "2 interrupted" in sweep("status").stdout
    assert 2 < sum(len(list(read_rows(path))) for path in rows.glob("*/rows.csv")) < 100


def test_a_wrong_value_and_one_that_ends_early_are_rows(sweep: Sweep, tmp_path: Path) -> None:
    rows_of(tmp_path, "list = [1.0, -2.0, 3.0]")
    done = sweep("run")
    assert done.returncode == 0 and "1 ended early" in done.stderr
    assert "1 failed, as run 2: case.nml" in done.stderr and "mass = -2.0 is not positive" in done.stderr
    assert sweep("collect").returncode == 0
    rows = table(tmp_path)
    assert [row["status"] for row in rows] == ["reached-end"] * 2 + ["failed"] + ["reached-end"] * 2
    assert "is not positive" in rows[2]["message"] and rows[2]["mass"] == "-2.0" and rows[2]["steps"] == ""
    rows_of(tmp_path, "list = [1.0, -2.0]", '[collect]\nq = { column = "vx", take = "abs-max" }\n')
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    rows = table(tmp_path)
    assert [row["status"] for row in rows] == ["reached-end"] * 2 + ["failed"]
    assert [row["q"] != "" for row in rows] == [True, True, False] and "is not positive" in rows[2]["message"]
    rows_of(tmp_path, "list = [1.0]", '[fixed]\n"integration.max_steps" = 2\n')
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    assert [row["status"] for row in table(tmp_path)] == ["too-many-steps"] * 2
    assert all("max_steps = 2" in row["message"] for row in table(tmp_path))


def test_a_run_that_crashes_takes_nobody_with_it(sweep: Sweep, tmp_path: Path) -> None:
    program(tmp_path, "app", CRASHES)
    rows_of(tmp_path, "list = [1.0, 2.0, 3.0, 4.0, 3.0, 3.0]", app="app")
    done = sweep("run", TAUT_BIN=str(tmp_path))
    assert done.returncode == 0 and "3 crashed, as run 3: out of luck" in done.stderr
    assert sweep("collect").returncode == 0
    crashed, good = ("crashed", "out of luck"), ("reached-end", "")
    rows = [(row["status"], row["message"]) for row in table(tmp_path)]
    assert rows == [good, good, crashed, good, crashed, crashed]
    assert records(tmp_path)[0]["parameters"] == {"runs": [1, 6]}


def test_what_does_not_go_with_rows(sweep: Sweep, tmp_path: Path) -> None:
    for more in ('[collect]\ntrajectories = ["x"]', '[collect]\nq = { column = "x", take = "mean" }'):
        rows_of(tmp_path, "list = [1.0]", more)
        assert_refused(sweep("run"), "[collect]", "keep = 'files'")
    path = tmp_path / "sweep.toml"
    rows_of(tmp_path, "list = [1.0]")
    path.write_text("checkpoint = 1\n" + path.read_text())
    assert_refused(sweep("run"), "checkpoint", "keep = 'files'")
    path.write_text(path.read_text().replace("checkpoint = 1\n", "").replace('"rows"', '"row"'))
    assert_refused(sweep("run"), "keep = 'row'", "'rows'")
    program(tmp_path, "app", "exit 0\n")
    rows_of(tmp_path, "list = [1.0]", app="app")
    assert_refused(sweep("run", TAUT_BIN=str(tmp_path)), "keep = 'rows'", "--runs")


@pytest.mark.parametrize("whole", [True, False])
def test_what_a_power_cut_leaves_is_mended(tmp_path: Path, whole: bool) -> None:
    path = tmp_path / "rows.csv"
    assert mend(path, whole) is None
    lines = ["run,method,x", "7,a,1", "7,b,1", "8,a,1", "run,method,x", "8,b,1", "9,a,1"]
    path.write_text("\n".join(lines))
    assert mend(path, whole) == (8 if whole else 7)
    rows = list(read_rows(path))
    assert rows == [line.split(",") for line in lines[: 4 if whole else 3]] + [["8", "b", "1"]] * whole
    path.write_text("run,me")
    assert mend(path, whole) is None and path.read_text() == ""
    with path.open("w") as file:
        csv.writer(file, lineterminator="\n").writerows([["run", "x"], [1, "a, b"]])
    assert mend(path, whole) == (1 if whole else None)
