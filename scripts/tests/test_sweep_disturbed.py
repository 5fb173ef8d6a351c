"""Sweeps that are disturbed: nothing is lost or doubled, and the table is the same in the end."""

import fcntl
import os
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from sweep_runs import (
    CASE,
    Begin,
    Sweep,
    assert_refused,
    home,
    program,
    records,
    seconds,
    table,
    wait_until,
    write,
)

# A summary of an integration, and an integration whose first variant waits until it is let go.
SUMMARY = "printf 'case,method,status,wall_seconds\\ncase,present,reached-end,1.0\\n' >case/summary.csv\n"
WAITS = f"""case "$*" in *none*) echo "case.nml/none/" >&2; exit 1;; esac
mkdir -p case
if grep -q "mass = 1.0" case.nml; then touch waits; while [ ! -e "$GO" ]; do sleep 0.05; done; fi
{SUMMARY}"""
# Programs in the place of the pendulum, for what it cannot be made to do on demand.
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


def test_killed_at_any_moment_it_ends_with_the_same_table(sweep: Sweep, tmp_path: Path, begin: Begin) -> None:
    write(tmp_path, "range = { start = 1, stop = 60, step = 1 }", case=CASE.replace("0.5", "10"))
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    undisturbed = (home(tmp_path) / "table.csv").read_bytes()
    shutil.rmtree(home(tmp_path))
    for count in (2, 11, 30):
        process = begin()
        wait_until(lambda n=count: len(list(home(tmp_path).glob("runs/*/case/summary.csv"))) > n)
        process.kill()
        process.wait()
        missing = sweep("collect")
        assert_refused(missing, "of 60 runs have no results", "--partial")
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    assert (home(tmp_path) / "table.csv").read_bytes() == undisturbed


def test_ctrl_c_stops_cleanly(sweep: Sweep, tmp_path: Path, begin: Begin) -> None:
    write(tmp_path, "list = [1.0, 2.0, 3.0]", case=CASE.replace("0.5", "1e5"))
    process = begin("--jobs", "2")
    wait_until(lambda: len(list(home(tmp_path).glob("runs/*/case/*"))) >= 2)
    assert "0 done, 2 running, 0 failed, 1 missing" in sweep("status").stdout
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said.splitlines() == ["sweep: stopped with 3 runs to go; go on with scripts/sweep run sweep.toml"]
    assert "0 done, 0 running, 0 failed, 2 interrupted, 1 missing" in sweep("status").stdout


def test_two_calls_at_once_share_the_work(sweep: Sweep, tmp_path: Path, begin: Begin) -> None:
    write(tmp_path, "range = { start = 1, stop = 150, step = 1 }", case=CASE.replace("0.5", "5"))
    processes = [begin() for _ in range(3)]
    assert [process.wait(timeout=120) for process in processes] == [0, 0, 0]
    assert "150 done, 0 running, 0 failed, 0 missing" in sweep("status").stdout
    assert {record["attempts"] for record in records(tmp_path)} == {1}
    assert sweep("collect").returncode == 0 and len(table(tmp_path)) == 300


def test_a_run_in_other_hands_is_waited_for(sweep: Sweep, tmp_path: Path, begin: Begin) -> None:
    write(tmp_path, "list = [1.0, 2.0]")
    assert sweep("run").returncode == 0
    first = sorted(home(tmp_path).glob("runs/*"))[0]
    (first / "record.json").unlink()
    with (first / "lock").open("r+") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        process = begin()
        assert process.stderr is not None
        assert process.stderr.readline() == "sweep: waiting for 1 run of another process\n"
        # A task of a cluster leaves it to the other.
        left = sweep("work", "--runs", "1:2")
        assert left.returncode == 0 and "1 run left to another process" in left.stderr
        assert not (first / "record.json").exists()
    assert process.communicate(timeout=60)[1] == "" and process.returncode == 0
    assert (first / "record.json").exists()


def test_a_sweep_that_changes_while_it_runs(sweep: Sweep, tmp_path: Path, begin: Begin) -> None:
    program(tmp_path, "app", WAITS)
    write(tmp_path, "list = [1.0, 2.0, 3.0]", app="app")
    more = {"TAUT_BIN": str(tmp_path), "GO": str(tmp_path / "go")}
    first = begin("--jobs", "1", **more)
    wait_until(lambda: list(home(tmp_path).glob("runs/*/waits")))
    # The first call has yet to begin two runs, which are others' by their place now.
    write(tmp_path, "list = [4.0, 3.0, 2.0, 1.0]", app="app")
    second = begin("--jobs", "1", **more)
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
    sweep: Sweep, tmp_path: Path, begin: Begin
) -> None:
    program(tmp_path, "sleeper", LONG)
    write(tmp_path, "list = [1.0]", app="sleeper")
    caller = begin(TAUT_BIN=str(tmp_path))
    wait_until(lambda: [path for path in home(tmp_path).glob("runs/*/pid") if path.read_text()])
    caller.kill()
    caller.wait()
    (pid,) = home(tmp_path).glob("runs/*/pid")
    assert "0 done, 1 running, 0 failed, 0 missing" in sweep("status").stdout
    again = begin(TAUT_BIN=str(tmp_path))
    assert again.stderr is not None and "another process" in again.stderr.readline()
    again.send_signal(signal.SIGINT)
    assert "1 run left to another process" in again.communicate(timeout=60)[1] and again.returncode == 130
    os.kill(int(pid.read_text()), signal.SIGKILL)
    wait_until(lambda: "1 killed" in sweep("status").stdout)


def test_stopped_again_and_again_it_continues_and_ends_with_the_same_table(
    sweep: Sweep, tmp_path: Path, begin: Begin
) -> None:
    write(tmp_path, "list = [1.0, 2.0]", case=CASE.replace("0.5", "2000"))
    assert sweep("run").returncode == 0 and sweep("collect").returncode == 0
    undisturbed = (home(tmp_path) / "table.csv").read_bytes()
    shutil.rmtree(home(tmp_path))
    for number in (signal.SIGINT, signal.SIGTERM):
        # Two at a time, on one core too.
        process = begin("--jobs", "2")
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
