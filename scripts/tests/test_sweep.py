"""Sweeps that run: nothing is lost, nothing is doubled, and what was interrupted ends with the same table."""

import csv
import fcntl
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[1] / "sweep"
Sweep = Callable[..., subprocess.CompletedProcess[str]]

CASE = """&pendulum mass = 1.0 /
&integration t_end = 0.5 /
&output dt = 0.1 /
&method name = "present" /
&method name = "baseline" /
"""
MASSES = 'case = "base.nml"\napp = "{app}"\n[[parameter]]\nname = "mass"\nentry = "pendulum.mass"\n'

# A summary of an integration, and an integration whose first variant waits until it is let go.
SUMMARY = "printf 'case,method,status,wall_seconds\\ncase,present,reached-end,1.0\\n' >case/summary.csv\n"
WAITS = f"""case "$*" in *none*) echo "case.nml/none/" >&2; exit 1;; esac
mkdir -p case
if grep -q "mass = 1.0" case.nml; then touch waits; while [ ! -e "$GO" ]; do sleep 0.05; done; fi
{SUMMARY}"""
# Programs in the place of the pendulum, for what it cannot be made to do on demand.
SIGNALED = 'case "$*" in *none*) echo "case.nml/none/" >&2; exit 1;; esac\nkill -SEGV $$\n'
LONG = 'case "$*" in *none*) echo "case.nml/none/" >&2; exit 1;; esac\necho $$ >pid\nexec sleep 60\n'
CHECKPOINTS = """case "$*" in *none*) echo "case.nml/none/" >&2; exit 1;; esac
mkdir -p case
case "$*" in
  *--restart*)
    grep -q good case/checkpoint.taut || { echo "x: case/checkpoint.taut: damaged" >&2; exit 1; }
    rm case/checkpoint.taut; how=continued;;
  *) if [ ! -e begun ]; then touch begun; echo "$STATE" >case/checkpoint.taut; exit 75; fi; how=anew;;
esac
printf 'case,method,status,wall_seconds\\ncase,%s,reached-end,1.0\\n' $how >case/summary.csv
"""


def program(folder: Path, name: str, text: str) -> None:
    path = folder / name
    path.write_text(f'#!/bin/sh\n[ "$1" = --version ] && {{ echo "taut test"; exit; }}\n{text}')
    path.chmod(0o755)


@pytest.fixture
def environment(pendulum: Path) -> dict[str, str]:
    return os.environ | {"TAUT_BIN": str(pendulum.parent)}


@pytest.fixture
def sweep(environment: dict[str, str], tmp_path: Path) -> Sweep:
    """Runs scripts/sweep on sweep.toml in a folder of its own."""

    def command(
        name: str, *arguments: str, cwd: Path = tmp_path, results: Path | None = None, **more: str
    ) -> subprocess.CompletedProcess[str]:
        where = [] if results is None else ["--results", results]
        return subprocess.run(
            [sys.executable, SCRIPT, name, "sweep.toml", *where, *arguments],
            cwd=cwd,
            env=environment | more,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    return command


def write(folder: Path, values: str, more: str = "", case: str = CASE, app: str = "pendulum") -> None:
    (folder / "base.nml").write_text(case)
    (folder / "sweep.toml").write_text(MASSES.format(app=app) + values + "\n" + more)


def home(folder: Path) -> Path:
    return folder / "results" / "sweeps" / "sweep"


def table(folder: Path, name: str = "table.csv") -> list[dict[str, str]]:
    with (home(folder) / name).open(newline="") as file:
        return list(csv.DictReader(file))


def records(folder: Path) -> list[dict[str, object]]:
    return [json.loads(path.read_text()) for path in sorted(home(folder).glob("runs/*/record.json"))]


def seconds(record: dict[str, str]) -> float:
    """Returns how long the last attempt of a run took."""
    start, end = (datetime.fromisoformat(record[key]) for key in ("start", "end"))
    return (end - start).total_seconds()


def assert_refused(done: subprocess.CompletedProcess[str], *parts: str, code: int = 1) -> None:
    assert done.returncode == code, done.stderr
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("sweep: ")
    for part in parts:
        assert part in lines[0]


def wait_until(happened: Callable[[], object]) -> None:
    deadline = time.monotonic() + 60
    while not happened():
        assert time.monotonic() < deadline
        time.sleep(0.01)


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


def test_killed_at_any_moment_it_ends_with_the_same_table(
    sweep: Sweep, tmp_path: Path, environment: dict[str, str]
) -> None:
    write(tmp_path, "range = { start = 1, stop = 60, step = 1 }", case=CASE.replace("0.5", "10"))
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    undisturbed = (home(tmp_path) / "table.csv").read_bytes()
    shutil.rmtree(home(tmp_path))
    for count in (2, 11, 30):
        process = subprocess.Popen(
            [sys.executable, SCRIPT, "run", "sweep.toml"],
            cwd=tmp_path,
            env=environment,
            stdout=subprocess.DEVNULL,
        )
        wait_until(lambda n=count: len(list(home(tmp_path).glob("runs/*/case/summary.csv"))) > n)
        process.kill()
        process.wait()
        missing = sweep("collect")
        assert_refused(missing, "of 60 runs have no results", "--partial")
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    assert (home(tmp_path) / "table.csv").read_bytes() == undisturbed


def test_ctrl_c_stops_cleanly(sweep: Sweep, tmp_path: Path, environment: dict[str, str]) -> None:
    write(tmp_path, "list = [1.0, 2.0, 3.0]", case=CASE.replace("0.5", "1e5"))
    command = [sys.executable, SCRIPT, "run", "sweep.toml", "--jobs", "2"]
    process = subprocess.Popen(
        command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    wait_until(lambda: len(list(home(tmp_path).glob("runs/*/case/*"))) >= 2)
    assert "0 done, 2 running, 0 failed, 1 missing" in sweep("status").stdout
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said.splitlines() == ["sweep: stopped with 3 runs to go; go on with scripts/sweep run sweep.toml"]
    assert "0 done, 0 running, 0 failed, 2 interrupted, 1 missing" in sweep("status").stdout


def test_two_calls_at_once_share_the_work(sweep: Sweep, tmp_path: Path, environment: dict[str, str]) -> None:
    write(tmp_path, "range = { start = 1, stop = 150, step = 1 }", case=CASE.replace("0.5", "5"))
    command = [sys.executable, SCRIPT, "run", "sweep.toml"]
    processes = [subprocess.Popen(command, cwd=tmp_path, env=environment) for _ in range(3)]
    assert [process.wait(timeout=120) for process in processes] == [0, 0, 0]
    assert "150 done, 0 running, 0 failed, 0 missing" in sweep("status").stdout
    assert {record["attempts"] for record in records(tmp_path)} == {1}
    assert sweep("collect").returncode == 0 and len(table(tmp_path)) == 300


def test_a_run_in_other_hands_is_waited_for(
    sweep: Sweep, tmp_path: Path, environment: dict[str, str]
) -> None:
    write(tmp_path, "list = [1.0, 2.0]")
    assert sweep("run").returncode == 0
    first = sorted(home(tmp_path).glob("runs/*"))[0]
    (first / "record.json").unlink()
    with (first / "lock").open("r+") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        command = [sys.executable, SCRIPT, "run", "sweep.toml"]
        process = subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True)
        assert process.stderr is not None
        assert process.stderr.readline() == "sweep: waiting for 1 run of another process\n"
        # A task of a cluster leaves it to the other.
        left = sweep("work", "--runs", "1:2")
        assert left.returncode == 0 and "1 run left to another process" in left.stderr
        assert not (first / "record.json").exists()
    assert process.communicate(timeout=60)[1] == "" and process.returncode == 0
    assert (first / "record.json").exists()


def test_a_sweep_that_changes_while_it_runs(
    sweep: Sweep, tmp_path: Path, environment: dict[str, str]
) -> None:
    program(tmp_path, "app", WAITS)
    write(tmp_path, "list = [1.0, 2.0, 3.0]", app="app")
    more = {"TAUT_BIN": str(tmp_path), "GO": str(tmp_path / "go")}
    command = [sys.executable, SCRIPT, "run", "sweep.toml", "--jobs", "1"]
    first = subprocess.Popen(command, cwd=tmp_path, env=environment | more)
    wait_until(lambda: list(home(tmp_path).glob("runs/*/waits")))
    # The first call has yet to begin two runs, which are others' by their place now.
    write(tmp_path, "list = [4.0, 3.0, 2.0, 1.0]", app="app")
    second = subprocess.Popen(command, cwd=tmp_path, env=environment | more)
    wait_until(lambda: len(list(home(tmp_path).glob("runs/*/case/summary.csv"))) == 3)
    (tmp_path / "go").touch()
    assert first.wait(timeout=60) == second.wait(timeout=60) == 0
    assert {record["attempts"] for record in records(tmp_path)} == {1}
    assert len({path.name[5:] for path in home(tmp_path).glob("runs/*")}) == len(records(tmp_path)) == 4
    # With nobody at work the folders get the numbers of the plan.
    assert sweep("run", **more).returncode == 0
    assert [record["parameters"]["mass"] for record in records(tmp_path)] == [4, 3, 2, 1]


def test_two_folders_of_one_run_block_nothing(sweep: Sweep, tmp_path: Path) -> None:
    write(tmp_path, "list = [1.0, 2.0]")
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    undisturbed = (home(tmp_path) / "table.csv").read_bytes()
    folder = sorted(home(tmp_path).glob("runs/*"))[1]
    for number in ("0001", "0009"):
        twin = folder.with_name(number + folder.name[4:])
        twin.mkdir()
        (twin / "case.nml").touch()
    assert "nothing left to do" in sweep("run").stdout
    assert sweep("collect").returncode == 0
    assert (home(tmp_path) / "table.csv").read_bytes() == undisturbed


def test_a_program_whose_caller_was_killed_keeps_its_folder(
    sweep: Sweep, tmp_path: Path, environment: dict[str, str]
) -> None:
    program(tmp_path, "sleeper", LONG)
    write(tmp_path, "list = [1.0]", app="sleeper")
    command = [sys.executable, SCRIPT, "run", "sweep.toml"]
    caller = subprocess.Popen(command, cwd=tmp_path, env=environment | {"TAUT_BIN": str(tmp_path)})
    wait_until(lambda: [path for path in home(tmp_path).glob("runs/*/pid") if path.read_text()])
    caller.kill()
    caller.wait()
    (pid,) = home(tmp_path).glob("runs/*/pid")
    assert "0 done, 1 running, 0 failed, 0 missing" in sweep("status").stdout
    again = subprocess.Popen(
        command,
        cwd=tmp_path,
        env=environment | {"TAUT_BIN": str(tmp_path)},
        stderr=subprocess.PIPE,
        text=True,
    )
    assert again.stderr is not None and "another process" in again.stderr.readline()
    again.send_signal(signal.SIGINT)
    assert "1 run left to another process" in again.communicate(timeout=60)[1] and again.returncode == 130
    os.kill(int(pid.read_text()), signal.SIGKILL)
    wait_until(lambda: "1 killed" in sweep("status").stdout)


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


def test_stopped_again_and_again_it_continues_and_ends_with_the_same_table(
    sweep: Sweep, tmp_path: Path, environment: dict[str, str]
) -> None:
    write(tmp_path, "list = [1.0, 2.0]", case=CASE.replace("0.5", "2000"))
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    undisturbed = (home(tmp_path) / "table.csv").read_bytes()
    shutil.rmtree(home(tmp_path))
    for number in (signal.SIGINT, signal.SIGTERM):
        process = subprocess.Popen(
            [sys.executable, SCRIPT, "run", "sweep.toml"],
            cwd=tmp_path,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        wait_until(lambda: [record["state"] for record in records(tmp_path)] == ["running"] * 2)
        time.sleep(0.1)
        process.send_signal(number)
        assert process.wait() == 130
        assert len(list(home(tmp_path).glob("runs/*/case/checkpoint.taut"))) == 2
    done = sweep("run")
    assert done.returncode == 0 and sweep("collect").returncode == 0
    # The summary's time is that of all three attempts, the report's that of this call.
    own, other = re.findall(r"(-?[\d.]+) ms a run", done.stdout)
    assert 0 < float(own) < 1e3 * sum(map(seconds, records(tmp_path))) and float(other) >= 0
    assert [(record["attempts"], record["restarted"]) for record in records(tmp_path)] == [(3, True)] * 2
    assert not list(home(tmp_path).glob("runs/*/refused*"))
    assert (home(tmp_path) / "table.csv").read_bytes() == undisturbed


@pytest.mark.parametrize(("state", "how"), [("good", "continued"), ("bad", "anew")])
def test_an_interrupted_run_goes_on_from_its_checkpoint(
    sweep: Sweep, tmp_path: Path, state: str, how: str
) -> None:
    program(tmp_path, "app", CHECKPOINTS)
    write(tmp_path, "list = [1.0]", app="app")
    more = {"TAUT_BIN": str(tmp_path), "STATE": state}
    assert_refused(sweep("run", **more), "stopped with 1 run to go", code=130)
    assert "1 interrupted" in sweep("status").stdout
    done = sweep("run", **more)
    assert done.returncode == 0
    # The program says that it integrated for a second: longer than this call has lasted.
    own, other = map(float, re.findall(r"(-?[\d.]+) ms a run", done.stdout))
    assert 0 < own < 1000 and other >= 0
    assert records(tmp_path)[0]["restarted"] == (how == "continued")
    assert len(list(home(tmp_path).glob("runs/*/refused_checkpoint.taut"))) == (how == "anew")
    assert sweep("collect").returncode == 0
    assert [row["method"] for row in table(tmp_path)] == [how]


@pytest.fixture
def mounted(tmp_path: Path) -> Iterator[Callable[..., None]]:
    """Mounts a file system on results/, which only root can."""
    folder = tmp_path / "results"
    folder.mkdir()

    def mount(*options: str) -> None:
        command = ["mount", *options, str(folder)]
        if os.geteuid() != 0 or subprocess.run(command, capture_output=True, check=False).returncode != 0:
            pytest.skip("a file system cannot be mounted here")

    yield mount
    while subprocess.run(["umount", str(folder)], capture_output=True, check=False).returncode == 0:
        pass


def test_a_full_disk_loses_nothing(sweep: Sweep, tmp_path: Path, mounted: Callable[..., None]) -> None:
    write(tmp_path, "range = { start = 1, stop = 300, step = 1 }")
    mounted("-t", "tmpfs", "-o", "size=4m", "tmpfs")
    done = sweep("run")
    assert done.returncode == 1 and "No space left on device" in done.stderr.splitlines()[-1]
    assert len(done.stderr.splitlines()) <= 3
    kept = sum(record["state"] == "done" for record in records(tmp_path))
    assert 0 < kept < 300 and f"{kept} done" in sweep("status").stdout
    assert not list(home(tmp_path).rglob(".*"))
    assert_refused(sweep("collect", "--partial"), "No space left on device")
    subprocess.run(["mount", "-o", "remount,size=64m", str(tmp_path / "results")], check=True)
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    assert len(table(tmp_path)) == 600


def test_a_folder_that_cannot_be_written(sweep: Sweep, tmp_path: Path, mounted: Callable[..., None]) -> None:
    write(tmp_path, "list = [1.0, 2.0]")
    mounted("-t", "tmpfs", "tmpfs")
    assert sweep("run").returncode == 0
    write(tmp_path, "list = [1.0, 2.0, 3.0]")
    subprocess.run(["mount", "-o", "remount,ro", str(tmp_path / "results")], check=True)
    assert_refused(sweep("run"), "Read-only file system")
    assert_refused(sweep("collect", "--partial"), "Read-only file system")
    assert "2 done, 0 running, 0 failed, 1 missing" in sweep("status").stdout
    (tmp_path / "taken").write_text("")
    assert_refused(sweep("run", "--results", "taken"), "taken")
