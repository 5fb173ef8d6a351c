"""Sweeps through a real Slurm: nothing lost, nothing doubled, whatever is killed on the way."""

import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from processes import listens
from slurm_cluster import Cluster, NoSlurmError, wait

from taut.sweep.arrays import sliced
from taut.sweep.slurm import ended

ROOT = Path(__file__).parents[2]

# Steps so small that a run takes some 50 ms.
CASE = """\
&pendulum mass = 2.0 /
&integration t_end = 10.0, rtol = 1e-6, atol = 1e-9, max_step = 4e-4 /
&output dt = 1.0 /
&method name = "present" /
"""
SWEEP = """\
case = "swings.nml"
app = "pendulum"
checkpoint = 0.02

[[parameter]]
entry = "pendulum.gravity"
range = {{ start = 1.0, stop = {gravity}, count = {gravities} }}

[[parameter]]
entry = "pendulum.length"
range = {{ start = 0.5, stop = {length}, count = {lengths} }}
# The bob begins where the rod is horizontal.
also = {{ "pendulum.position(1)" = 1 }}

[collect]
lowest = {{ column = "z", take = "min" }}
trajectories = ["x", "z"]
"""

Sweep = Callable[..., subprocess.CompletedProcess[str]]


def write_sweep(folder: Path, gravities: int, lengths: int, more: str = "") -> Path:
    (folder / "swings.nml").write_text(CASE, encoding="utf-8")
    path = folder / "swings.toml"
    # A single value is the start and the stop.
    ends = {"gravity": 10.0 if gravities > 1 else 1.0, "length": 1.4 if lengths > 1 else 0.5}
    path.write_text(SWEEP.format(gravities=gravities, lengths=lengths, **ends) + more, encoding="utf-8")
    return path


@pytest.fixture
def sweep(pendulum: Path, environment: dict[str, str], tmp_path: Path) -> Sweep:
    """Calls scripts/sweep in the test's folder, or in another one."""

    def call(
        command: str, *words: str | Path, given: dict[str, str] | None = None, cwd: Path = tmp_path
    ) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [ROOT / "scripts" / "sweep", command, *words],
            cwd=cwd,
            env=(given or environment) | {"TAUT_BIN": str(pendulum.parent)},
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
        )

    return call


def good(done: subprocess.CompletedProcess[str]) -> str:
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def refused(done: subprocess.CompletedProcess[str]) -> str:
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    return line


def tables(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in ("table.csv", "trajectories.csv")}


def tasks(slurm: Cluster, *states: str) -> list[str]:
    """Returns the jobs of the tasks in the queue, or of those in some states."""
    chosen = [f"--states={','.join(states)}"] if states else []
    return slurm.command("squeue", "--noheader", "--array", "--format=%A", *chosen).split()


def disturb(slurm: Cluster, chance: random.Random, kinds: list[str]) -> None:
    """Disturbs tasks at random moments until the queue is empty; takes what it did off the list."""
    while tasks(slurm):
        time.sleep(chance.uniform(0.05, 0.5))
        running = tasks(slurm, "RUNNING")
        # A task may end before it is hit.
        with contextlib.suppress(NoSlurmError, ProcessLookupError, IndexError):
            if kinds and running:
                hit(slurm, kinds[-1], chance.choice(running))
                kinds.pop()


def hit(slurm: Cluster, kind: str, job: str) -> None:
    if kind == "program":
        os.kill(programs(slurm)[0], signal.SIGKILL)
    elif kind == "task":
        slurm.command("scancel", "--full", "--signal=KILL", job)
    elif kind == "requeue":
        slurm.command("scontrol", "requeue", job)
    else:
        slurm.kill_node()
        time.sleep(0.5)
        slurm.start_node()


def command_of(pid: int) -> str:
    """Returns the words of a process's command, with zeros between; nothing if it has ended."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8")
    return ""


def programs(slurm: Cluster) -> list[int]:
    """Returns the ids of the pendulums that swing."""
    return [pid for pid in slurm.processes() if command_of(pid).partition("\0")[0].endswith("/pendulum")]


def test_table_equals_that_of_an_undisturbed_sweep(slurm: Cluster, sweep: Sweep, tmp_path: Path) -> None:
    path = write_sweep(tmp_path, gravities=20, lengths=10)
    good(sweep("run", path, "--results", "local"))
    good(sweep("collect", path, "--results", "local"))

    results = tmp_path / "through slurm"
    chance = random.Random(20)
    kinds = ["program", "task", "requeue"] * 7
    chance.shuffle(kinds)
    kinds.insert(10, "node")
    # Submitted from elsewhere; arrays of 25 tasks hold 100 runs.
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    submit = ("run", "../swings.toml", "--results", results, "--slurm", "--runs-per-task", "4")
    said = good(sweep(*submit, given=slurm.environment, cwd=elsewhere))
    assert "200 to submit" in said
    assert said.count("submitted job") == 2
    disturb(slurm, chance, kinds)
    for _ in range(10):
        said = good(sweep(*submit, given=slurm.environment, cwd=elsewhere))
        if "to submit" not in said:
            break
        disturb(slurm, chance, kinds)
    assert len(kinds) <= 2, "too few were killed"
    assert "200 done" in said
    good(sweep("collect", path, "--results", results))
    assert tables(results / "sweeps/swings") == tables(tmp_path / "local/sweeps/swings")
    assert len((results / "sweeps/swings/table.csv").read_text().splitlines()) == 201


def test_queued_runs_are_not_submitted_again(slurm: Cluster, sweep: Sweep, tmp_path: Path) -> None:
    more = '[slurm]\ncomment = "it\'s of two words"\nhold = true\nmem = 100\nexclusive = false\n'
    path = write_sweep(tmp_path, gravities=4, lengths=2, more=more)
    given = slurm.environment
    assert "8 to submit" in good(sweep("run", path, "--slurm", "--runs-per-task", "3", given=given))
    assert slurm.command("squeue", "--noheader", "--format=%k %m %r").strip() == (
        "it's of two words 100M JobHeldUser"
    )
    assert good(sweep("run", path, "--slurm", given=given)) == "swings: 8 in Slurm's queue\n"
    assert good(sweep("status", path, given=given)).splitlines() == [
        "swings: 8 runs: 0 done, 0 running, 0 failed, 8 missing",
        "slurm: tasks in the queue: 3 pending; 8 runs wait in them",
    ]
    # What is no longer in the queue is submitted again, and only that.
    (job,) = set(slurm.command("squeue", "--noheader", "--format=%F").split())
    slurm.command("scancel", f"{job}_1")
    said = good(sweep("run", path, "--slurm", "--runs-per-task", "9", "--", "--comment=third", given=given))
    assert said.startswith("swings: 5 in Slurm's queue, 3 to submit\nsubmitted job")
    tasks = sorted((tmp_path / "results/sweeps/swings/slurm").glob("*/tasks"))
    assert [path.read_text() for path in tasks] == ["1:3\n4:6\n7:8\n", "4:6\n"]
    assert "third" in slurm.command("squeue", "--noheader", "--format=%k")


def test_two_calls_at_once_submit_each_run_once(slurm: Cluster, sweep: Sweep, tmp_path: Path) -> None:
    path = write_sweep(tmp_path, gravities=5, lengths=2, more="[slurm]\nhold = true\n")
    with ThreadPoolExecutor() as pool:
        calls = [pool.submit(sweep, "run", path, "--slurm", given=slurm.environment) for _ in range(4)]
    done = [call.result() for call in calls]
    assert sum(one.stdout.count("submitted job") for one in done) == 1
    for one in done:
        assert one.returncode == 0 or refused(one).endswith("is being submitted by another process")
    assert len(tasks(slurm)) == 10


def test_finished_runs_are_not_submitted(slurm: Cluster, sweep: Sweep, tmp_path: Path) -> None:
    path = write_sweep(tmp_path, gravities=4, lengths=2)
    good(sweep("run", path))
    good(sweep("collect", path))
    folder = tmp_path / "results/sweeps/swings"
    before = tables(folder)
    for number in (2, 5, 7):
        (run,) = (folder / "runs").glob(f"000{number}-*")
        shutil.rmtree(run)
    assert good(sweep("run", path, "--slurm", given=slurm.environment)).startswith(
        "swings: 5 done, 3 to submit"
    )
    # They take moments, as those that are done tell: one task is enough.
    assert (folder / "slurm/0001/tasks").read_text() == "2:7\n"
    wait(lambda: not tasks(slurm))
    assert (folder / "slurm/0001/0.log").read_text().startswith("3 runs in")
    assert good(sweep("run", path, "--slurm", given=slurm.environment)) == "swings: 8 done\n"
    good(sweep("collect", path))
    assert tables(folder) == before


def test_time_limit_requeues_and_cancel_does_not(slurm: Cluster, sweep: Sweep, tmp_path: Path) -> None:
    path = write_sweep(tmp_path, gravities=1, lengths=1)
    case = tmp_path / "swings.nml"
    case.write_text(CASE.replace("t_end = 10.0", "t_end = 1e6"), encoding="utf-8")
    good(sweep("run", path, "--slurm", given=slurm.environment))
    wait(lambda: any(map(listens, programs(slurm))))
    (job,) = tasks(slurm)
    # What Slurm sends a minute before the time limit.
    slurm.command("scancel", "--batch", "--signal=USR1", job)
    wait(lambda: tasks(slurm, "PENDING") == [job])
    assert "Restarts=1" in slurm.command("scontrol", "show", "job", job)
    assert "1 interrupted" in good(sweep("status", path, given=slurm.environment))
    # It starts again by itself; then it is canceled for good.
    wait(lambda: any(map(listens, programs(slurm))))
    slurm.command("scancel", job)
    wait(lambda: not tasks(slurm))
    assert not slurm.processes()
    assert "1 interrupted" in good(sweep("status", path, given=slurm.environment))
    record = json.loads(next(tmp_path.glob("results/sweeps/swings/runs/*/record.json")).read_text())
    assert (record["exit_code"], record["restarted"], record["attempts"]) == (75, True, 2)


def test_sbatch_refuses(slurm: Cluster, sweep: Sweep, tmp_path: Path) -> None:
    path = write_sweep(tmp_path, gravities=1, lengths=2, more='[slurm]\npartition = "nowhere"\nhold = true\n')
    line = refused(sweep("run", path, "--slurm", given=slurm.environment))
    assert line.startswith("sweep: sbatch: error:")
    assert "invalid partition" in line
    folder = tmp_path / "results/sweeps/swings/slurm"
    assert not list(folder.glob("0*"))
    assert not tasks(slurm)
    # The command line overrides the file.
    good(sweep("run", path, "--slurm", "--", "--partition=main", given=slurm.environment))
    assert len(tasks(slurm)) == 2


def test_options_that_do_not_go_together(slurm: Cluster, sweep: Sweep, tmp_path: Path) -> None:
    path = write_sweep(tmp_path, gravities=1, lengths=2)
    line = refused(sweep("run", path, "--slurm", "--", "--array=0-3", given=slurm.environment))
    assert "'--array=0-3': the array is made here" in line
    assert "go with run --slurm" in refused(sweep("run", path, "--", "--partition=main"))
    write_sweep(tmp_path, gravities=1, lengths=2, more="[slurm]\ntime = [1]\n")
    assert "[slurm] 'time' must be a number" in refused(sweep("plan", path))


def test_without_slurm(sweep: Sweep, environment: dict[str, str], tmp_path: Path) -> None:
    path = write_sweep(tmp_path, gravities=1, lengths=2)
    bare = tmp_path / "bin"
    bare.mkdir()
    (bare / "python3").symlink_to(sys.executable)
    line = refused(sweep("run", path, "--slurm", given=environment | {"PATH": str(bare)}))
    assert line.startswith("sweep: there is no sbatch here")
    assert not (tmp_path / "results/sweeps/swings/slurm").exists()


def test_a_slurm_that_does_not_answer(sweep: Sweep, environment: dict[str, str], tmp_path: Path) -> None:
    path = write_sweep(tmp_path, gravities=1, lengths=2)
    for name in ("sbatch", "squeue", "scontrol"):
        command = tmp_path / name
        command.write_text(
            f"#!/bin/sh\nprintf '{name}: error: no server\\n{name}: fatal: no configuration\\n' >&2\nexit 1\n"
        )
        command.chmod(0o755)
    there = environment | {"PATH": f"{tmp_path}:{environment['PATH']}"}
    line = refused(sweep("run", path, "--slurm", given=there))
    assert (
        line == "sweep: Slurm does not answer here (squeue: fatal: no configuration); go where 'squeue' works"
    )


def test_accounting_tells_how_tasks_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Slurm's accounting needs a database; this one says what the manual of sacct shows.
    sacct = tmp_path / "sacct"
    sacct.write_text("#!/bin/sh\nprintf 'COMPLETED\\nCANCELLED by 0\\nCOMPLETED\\nRUNNING\\nTIMEOUT\\n'\n")
    sacct.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    assert ended(["7"]) == {"completed": 2, "cancelled": 1, "timeout": 1}
    assert not ended([])
    sacct.write_text("#!/bin/sh\necho Slurm accounting storage is disabled >&2\nexit 1\n")
    assert not ended(["7"])


def test_tasks_leave_room_for_what_is_queued() -> None:
    assert sliced([1, 2, 3, 4, 5], set(), 2) == [(1, 2), (3, 4), (5, 5)]
    assert sliced([1, 2, 9, 10, 11], {4}, 3) == [(1, 2), (9, 11)]
    assert sliced([1, 9], set(), 3) == [(1, 9)]


def test_one_long_case_goes_on_from_its_checkpoint(
    slurm: Cluster, pendulum: Path, environment: dict[str, str], tmp_path: Path
) -> None:
    case = tmp_path / "long.nml"
    case.write_text(CASE.replace("t_end = 10.0", "t_end = 600.0"), encoding="utf-8")
    folders = [tmp_path / name for name in ("straight", "stopped", "canceled")]
    for folder in folders:
        folder.mkdir()
    subprocess.run([pendulum, case, "--quiet"], cwd=folders[0], env=environment, check=True)

    def submitted(folder: Path) -> str:
        script = ROOT / "scripts/slurm_one_case.sh"
        options = ("--parsable", f"--chdir={folder}", "--output=job.log")
        job = slurm.command("sbatch", *options, str(script), str(pendulum), "../long.nml").strip()
        wait(lambda: any(map(listens, programs(slurm))))
        time.sleep(0.5)
        return job

    checkpoint = "results/long/checkpoint.taut"
    slurm.command("scancel", "--batch", "--signal=USR1", submitted(folders[1]))
    wait(lambda: tasks(slurm, "PENDING"))
    assert (folders[1] / checkpoint).exists()
    wait(lambda: any(f"--restart\0{checkpoint}" in command_of(pid) for pid in slurm.processes()))
    wait(lambda: not tasks(slurm))
    assert not (folders[1] / checkpoint).exists()
    straight, stopped = ((folder / "results/long/present.csv").read_bytes() for folder in folders[:2])
    assert stopped == straight
    # A job that is canceled is not queued again, but keeps its checkpoint.
    slurm.command("scancel", submitted(folders[2]))
    wait(lambda: not tasks(slurm))
    assert (folders[2] / checkpoint).exists()
