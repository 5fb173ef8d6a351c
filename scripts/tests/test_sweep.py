"""Sweeps that run: from the plan to the table, and what is refused or fails."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from sweep_runs import CASE, SCRIPT, Sweep, assert_refused, home, program, records, table, write

# A program in the place of the pendulum that crashes.
SIGNALED = 'case "$*" in *none*) echo "case.nml/none/" >&2; exit 1;; esac\nkill -SEGV $$\n'


def test_a_sweep_from_plan_to_table(sweep: Sweep, tmp_path: Path) -> None:
    collect = 'trajectories = ["x"]\ntop = { column = "x", take = "max", from = 0.2 }\n'
    collect += 'end = { column = "x", take = "final" }\nmiddle = { column = "t", take = "mean" }\n'
    write(tmp_path, "range = { start = 1, stop = 7, step = 1 }", "[collect]\n" + collect)
    plan = sweep("plan")
    assert plan.returncode == 0 and "7 runs" in plan.stdout and not home(tmp_path).exists()
    assert_refused(sweep("status"), "no runs", "scripts/sweep run")
    done = sweep("run")
    assert done.returncode == 0 and done.stderr == "" and "7 runs in" in done.stdout
    assert "7 done, 0 running, 0 failed, 0 missing" in sweep("status").stdout
    before = {path: path.stat().st_mtime_ns for path in home(tmp_path).glob("runs/*/*")}
    again = sweep("run")
    assert again.returncode == 0 and again.stdout == "sweep: 7 runs, nothing left to do\n"
    assert {path: path.stat().st_mtime_ns for path in home(tmp_path).glob("runs/*/*")} == before
    assert sweep("collect").returncode == 0
    rows = table(tmp_path)
    assert [(row["run"], row["mass"], row["method"]) for row in rows] == [
        (str(i), str(i), method) for i in range(1, 8) for method in ("present", "baseline")
    ]
    assert list(rows[0])[:3] == ["run", "mass", "method"] and "wall_seconds" not in rows[0]
    assert all(row["status"] == "reached-end" and float(row["middle"]) == 0.25 for row in rows)
    # The pendulum starts level: it falls as a quarter of a full swing, whatever its mass.
    ends = [float(row["end"]) for row in rows]
    assert ends == pytest.approx([ends[0]] * 14, abs=1e-4)
    assert 0 < ends[0] < float(rows[0]["top"]) < 1
    assert list(table(tmp_path, "timing.csv")[0])[:3] == ["run", "method", "wall_seconds"]
    long = table(tmp_path, "trajectories.csv")
    assert len(long) == 7 * 2 * 6 and list(long[0]) == ["run", "mass", "method", "t", "x"]
    (record, *_) = records(tmp_path)
    assert record["parameters"] == {"mass": 1} and record["attempts"] == 1 and record["exit_code"] == 0
    assert record["version"][0].startswith("taut ") and record["host"] and record["start"] <= record["end"]


def test_runs_are_kept_when_the_sweep_changes(sweep: Sweep, tmp_path: Path) -> None:
    write(tmp_path, "list = [1.0, 2.0, 3.0]")
    assert sweep("run").returncode == 0
    write(tmp_path, "list = [4.0, 3.0, 1.0, 3.0]")
    counted = "4 runs, 3 of them different"
    assert counted in sweep("plan").stdout
    assert f"{counted}: 2 done, 0 running, 0 failed, 1 missing" in sweep("status").stdout
    done = sweep("run")
    assert done.returncode == 0 and "1 run in" in done.stdout
    names = sorted(path.name[:4] for path in home(tmp_path).glob("runs/*"))
    assert names == ["0001", "0002", "0002", "0003"], "one of them is the 2.0 of before"
    assert sweep("collect").returncode == 0
    assert [row["mass"] for row in table(tmp_path)[::2]] == ["4.0", "3.0", "1.0", "3.0"]


def test_a_thousand_runs_are_all_there_once(sweep: Sweep, tmp_path: Path) -> None:
    write(tmp_path, "random = { count = 1000, seed = 1, uniform = [1, 2] }", case=CASE.replace("0.5", "0.01"))
    assert sweep("run", "--jobs", "4").returncode == 0
    assert sweep("collect").returncode == 0
    rows = table(tmp_path)
    assert [(int(row["run"]), row["method"]) for row in rows] == [
        (i, method) for i in range(1, 1001) for method in ("present", "baseline")
    ]
    assert len({row["mass"] for row in rows}) == 1000
    assert {record["attempts"] for record in records(tmp_path)} == {1}


def test_a_slice_of_the_runs(sweep: Sweep, tmp_path: Path) -> None:
    write(tmp_path, "list = [1.0, 2.0, 3.0, 4.0]")
    assert_refused(sweep("work", "--runs", "1:2"), "no runs", "scripts/sweep run")
    assert sweep("run").returncode == 0
    shutil.rmtree(home(tmp_path) / "runs")
    (home(tmp_path) / "runs").mkdir()
    assert sweep("work", "--runs", "2:3").returncode == 0
    assert "2 done, 0 running, 0 failed, 2 missing" in sweep("status").stdout
    assert_refused(sweep("work", "--runs", "4:5"), "4:5", "1 to 4")


def test_an_integration_that_ends_early_is_a_result(sweep: Sweep, tmp_path: Path) -> None:
    write(tmp_path, "list = [1.0, 2.0]", '[fixed]\n"integration.max_steps" = 2\n')
    done = sweep("run")
    assert done.returncode == 0 and "2 ended early" in done.stderr and "max_steps = 2" in done.stderr
    assert "0 done, 2 ended early, 0 running, 0 failed, 0 missing" in sweep("status").stdout
    again = sweep("run")
    assert again.returncode == 0 and "nothing left to do" in again.stdout
    assert [record["attempts"] for record in records(tmp_path)] == [1, 1]
    assert sweep("collect").returncode == 0
    assert [row["status"] for row in table(tmp_path)] == ["too-many-steps"] * 4


def test_another_sweep_of_the_same_name_is_refused(sweep: Sweep, tmp_path: Path) -> None:
    write(tmp_path, "list = [1.0]")
    assert sweep("run").returncode == 0
    other = tmp_path / "other"
    other.mkdir()
    write(other, "list = [2.0]")
    for command in ("run", "status", "collect", "plot"):
        done = sweep(command, cwd=other, results=tmp_path / "results")
        assert_refused(done, f"belongs to {tmp_path / 'sweep.toml'}", "--results")
    # One that was moved is the same.
    (tmp_path / "sweep.toml").unlink()
    assert sweep("run", cwd=other, results=tmp_path / "results").returncode == 0


@pytest.mark.parametrize(
    ("more", "parts"),
    [
        ('[collect]\nq = { column = "energie", take = "max" }', ("[collect] q", "energie", "energy")),
        ('[collect]\ntrajectories = ["energie"]', ("[collect]", "energie", "energy")),
        ('[collect]\nq = { column = "x", take = "max", from = 0.6 }', ("[collect] q", "0.6", "t_end = 0.5")),
        ('[collect]\nq = { column = "x", take = "max", to = -0.1 }', ("[collect] q", "-0.1", "t_start = 0")),
        ('[[plot]]\nname = "p"\nx = "mass"\ny = "stepps"', ("[[plot]] p", "stepps", "steps")),
        ('[[plot]]\nname = "p"\nx = "t"\ny = "x"', ("[[plot]] p", "'x'", "run, mass, method, t")),
    ],
)
def test_a_misspelt_column_is_said_before_anything_runs(
    sweep: Sweep, tmp_path: Path, more: str, parts: tuple[str, ...]
) -> None:
    write(tmp_path, "list = [1.0, 2.0]", more)
    for command in ("plan", "run"):
        assert_refused(sweep(command), "sweep.toml", *parts)
    assert not home(tmp_path).exists()


def test_a_sweep_of_modes(sweep: Sweep, tmp_path: Path, root: Path) -> None:
    (tmp_path / "base.nml").write_text((root / "cases" / "beam_modes" / "free_free.nml").read_text())
    text = 'case = "base.nml"\napp = "beam_modes"\n[[parameter]]\nname = "{}"\nentry = "beam.length"\n'
    text += "list = [0.5, 1.0]\n[[plot]]\nname = 'p'\nx = 'length'\ny = 'frequency'\nlines = 'mode'\n"
    more = '[collect]\nq = { column = "x", take = "max" }\n'
    (tmp_path / "sweep.toml").write_text(text.format("length") + more)
    assert_refused(sweep("run"), "[collect]", "beam_modes writes no trajectories")
    (tmp_path / "sweep.toml").write_text(text.format("mode"))
    assert_refused(sweep("run"), "'mode'", "give another")
    (tmp_path / "sweep.toml").write_text(text.format("length"))
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    assert sweep("plot").returncode == 0
    rows = table(tmp_path)
    assert len(rows) == 2 * 15 and list(rows[0])[:4] == ["run", "length", "mode", "frequency"]


def test_a_wrong_figure_does_not_stop_the_others(sweep: Sweep, tmp_path: Path) -> None:
    plots = ['name = "bad"\nx = "mass"\ny = "status"', 'name = "good"\nx = "mass"\ny = "steps"']
    plots += ['name = "path"\nx = "t"\ny = "x"\nwhere = { method = "present" }\nlines = "mass"']
    more = '[collect]\ntrajectories = ["x"]\n' + "".join(f"[[plot]]\n{plot}\n" for plot in plots)
    write(tmp_path, "list = [1.0, 2.0]", more)
    assert_refused(sweep("plot", "--results", "r s"), "scripts/sweep collect sweep.toml --results 'r s'")
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    done = sweep("plot")
    assert_refused(done, "'status' has texts")
    assert [Path(line).name for line in done.stdout.splitlines()] == ["good.png", "path.png"]
    assert {path.name for path in home(tmp_path).glob("*.png")} == {"good.png", "path.png"}


def test_options_that_would_do_nothing_are_refused(sweep: Sweep, tmp_path: Path) -> None:
    write(tmp_path, "list = [1.0]")
    assert_refused(sweep("run", "--runs-per-task", "2"), "--runs-per-task", "run --slurm")


def test_a_python_that_cannot_be_started(tmp_path: Path) -> None:
    (tmp_path / "scripts" / "taut").mkdir(parents=True)
    for name in ("sweep", "taut/__init__.py", "taut/bootstrap.py"):
        shutil.copy(SCRIPT.parent / name, tmp_path / "scripts" / name)
    python = tmp_path / ".venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.touch(mode=0o644)
    done = subprocess.run(
        [sys.executable, "-S", tmp_path / "scripts" / "sweep", "plan", "sweep.toml"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert_refused(done, str(python), "cannot be started: Permission denied")


def test_one_wrong_value_fails_alone(sweep: Sweep, tmp_path: Path) -> None:
    write(tmp_path, "list = [1.0, -2.0, 3.0]")
    assert_refused(sweep("run"), "1 failed", "0002-", "mass = -2")
    assert_refused(sweep("collect"), "1 of 3 runs", "--partial")
    assert sweep("collect", "--partial").returncode == 0
    assert [row["run"] for row in table(tmp_path)] == ["1", "1", "3", "3"]


def test_a_misspelt_entry_is_said_once_and_nothing_runs(sweep: Sweep, tmp_path: Path) -> None:
    write(tmp_path, "list = [1.0, 2.0]", '[fixed]\n"pendulum.masss" = 1.0\n')
    for command in ("plan", "run"):
        assert_refused(sweep(command), "sweep.toml", "no entry masss", "mass,")
    assert not home(tmp_path).exists()


def test_an_option_that_the_program_does_not_take_is_said_once(sweep: Sweep, tmp_path: Path) -> None:
    program(tmp_path, "app", 'case "$*" in *--checkpoint*) echo "app: no option" >&2; exit 2;; esac\n')
    write(tmp_path, "list = [1.0, 2.0]", app="app")
    path = tmp_path / "sweep.toml"
    path.write_text("checkpoint = 60\n" + path.read_text())
    assert_refused(sweep("run", TAUT_BIN=str(tmp_path)), "app: no option")
    assert not home(tmp_path).exists()


def test_a_program_that_crashes(sweep: Sweep, tmp_path: Path) -> None:
    program(tmp_path, "crash", SIGNALED)
    write(tmp_path, "list = [1.0, 2.0]", app="crash")
    assert_refused(sweep("run", TAUT_BIN=str(tmp_path)), "2 failed", "signal 11")
    assert [record["exit_code"] for record in records(tmp_path)] == [-11, -11]
    assert_refused(sweep("run", TAUT_BIN=str(tmp_path / "none")), "none/crash", "TAUT_BIN")


@pytest.mark.parametrize("keep", ["files", "rows"])
def test_peaks_are_found_between_the_rows(sweep: Sweep, tmp_path: Path, root: Path, keep: str) -> None:
    """A rod that swings from the horizontal pulls at its hinge with (5/2) m g, between rows 0.7 s apart."""
    text = (root / "cases" / "mechanism" / "simple_pendulum.nml").read_text()
    (tmp_path / "base.nml").write_text(text.replace("dt = 0.02", "dt = 0.7"))
    (tmp_path / "sweep.toml").write_text(
        f'case = "base.nml"\napp = "mechanism"\nkeep = "{keep}"\n'
        '[[parameter]]\nname = "m"\nentry = "body.mass"\nlist = [1.0, 3.0]\n'
        '[collect]\npull = { column = "hinge.force", take = "max" }\n'
        'late = { column = "rod.wz", take = "abs-max", from = 0.6, to = 0.7 }\n'
        'low = { column = "hinge.fy", take = "min" }\nhigh = { column = "hinge.fy", take = "abs-max" }\n'
        '[fixed]\n"integration.t_end" = 2.0\n'
    )
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    rows = table(tmp_path)
    assert [row["m"] for row in rows] == ["1.0", "3.0"]
    for row in rows:
        weight = 9.81 * float(row["m"])
        assert float(row["pull"]) == pytest.approx(2.5 * weight, rel=1e-6)
        assert float(row["high"]) == pytest.approx(2.5 * weight, rel=1e-6)
        assert float(row["low"]) == pytest.approx(0.25 * weight, rel=1e-6)
        assert 4.0 < float(row["late"]) < 5.4
        assert "pull_max" not in row and "pull_max_t" not in row


MOVED = """&body name = "m", mass = 2.0, inertia = 1.0, position = 0.0, 0.0 /
&mechanism planar = .true. /
&joint name = "rail", type = "prismatic", body_2 = "m", point = 0.0, 0.0, axis = 1.0, 0.0, 0.0 /
&function name = "g", kind = "table", table = "loads/g.csv" /
&force body = "m", value = 4.0, 0.0, function = "g" /
&integration t_end = 1.0 /
"""


@pytest.mark.parametrize("keep", ["files", "rows"])
def test_a_table_is_found_and_belongs_to_the_runs(sweep: Sweep, tmp_path: Path, keep: str) -> None:
    """A force F t/T of a table moves a mass m by F T^2/(6 m), wherever the case and its table lie."""
    folder = tmp_path / "there"
    (folder / "loads").mkdir(parents=True)
    (folder / "base.nml").write_text(MOVED)
    (tmp_path / "sweep.toml").write_text(
        f'case = "there/base.nml"\napp = "mechanism"\nkeep = "{keep}"\n'
        '[[parameter]]\nname = "m"\nentry = "body.mass"\nlist = [1.0, 2.0]\n'
        '[collect]\nx = { column = "m.x", take = "max" }\n'
    )
    for force in (1.0, 3.0):
        (folder / "loads" / "g.csv").write_text(f"0,0\n1,{force}\n")
        assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
        found = [float(row["x"]) for row in table(tmp_path)]
        assert found == pytest.approx([4.0 * force / 6.0, 4.0 * force / 12.0], rel=1e-6)
    (folder / "loads" / "g.csv").unlink()
    assert_refused(sweep("plan"), "sweep.toml", "loads/g.csv", "no such table")


@pytest.mark.parametrize("name", ["..toml", "...toml"])
def test_a_sweep_stays_in_its_folder(sweep: Sweep, tmp_path: Path, name: str) -> None:
    write(tmp_path, "list = [1.0]")
    (tmp_path / "sweep.toml").rename(tmp_path / name)
    for command in ("plan", "run", "collect"):
        assert_refused(sweep(command, file=name), name, "into another folder; rename the file")
    assert not (tmp_path / "results").exists()


def test_what_is_no_file_is_not_read(sweep: Sweep, tmp_path: Path) -> None:
    assert_refused(sweep("plan", file="/dev/zero"), "/dev/zero", "no regular file")
    write(tmp_path, 'table = { file = "/dev/zero", columns = ["mass"] }')
    assert_refused(sweep("plan"), "/dev/zero", "no regular file")
    write(tmp_path, "list = [1.0]")
    (tmp_path / "base.nml").unlink()
    (tmp_path / "base.nml").symlink_to("/dev/zero")
    assert_refused(sweep("plan"), "base.nml")


@pytest.mark.parametrize("app", ["./pendulum", "../{here}/pendulum", "{here}", "pendulum;x", ".."])
def test_an_app_is_a_name_and_no_path(sweep: Sweep, tmp_path: Path, app: str) -> None:
    program(tmp_path, "pendulum", "touch ran\n")
    write(tmp_path, "list = [1.0]", app=app.format(here=tmp_path / "pendulum"))
    for command in ("plan", "run"):
        assert_refused(sweep(command, TAUT_BIN=str(tmp_path)), "sweep.toml", "app = ", "no name of an app")
    assert not list(tmp_path.rglob("ran"))
