import contextlib
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
from animate_cases import HANGING, PENDULUM, made
from debian import nothing_to_test
from processes import adopting_orphans
from slurm_cluster import Cluster, NoSlurmError, running_cluster
from sweep_runs import SCRIPT, Begin, Sweep

from taut.files import locked
from taut.programs import BUILDING, release

ROOT = Path(__file__).parents[2]

# Groups of tests, longest first.
LONGEST = (
    "test_flang",
    "cluster",
    "test_report",
    "test_swing",
    "test_sweep_rows",
    "test_swing_runs",
    "test_readme",
)

Run = Callable[..., subprocess.CompletedProcess[str]]


def pytest_configure() -> None:
    """Lets signals end what the tests start, also where nohup or a shell in the background ignores them."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1):
        if signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Keeps what shares something slow on one worker: the tests of a file, and all that need a cluster.

    Those that take longest come first, lest one worker is left with them at the end.
    """
    groups = {}
    for item in items:
        shared = {"cluster", "slurm"} & set(getattr(item, "fixturenames", ()))
        groups[item] = "cluster" if shared else item.path.stem
        item.add_marker(pytest.mark.xdist_group(groups[item]))
    items.sort(key=lambda item: LONGEST.index(groups[item]) if groups[item] in LONGEST else len(LONGEST))


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where taut is installed for others to use."""
    folder = tmp_path_factory.mktemp("installed")
    with locked(BUILDING):
        done = subprocess.run([ROOT / "scripts/install", folder], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def pendulum() -> Path:
    return release("pendulum")


@pytest.fixture(scope="session")
def swing() -> Path:
    return release("swing")


@pytest.fixture(scope="session")
def mechanism() -> Path:
    return release("mechanism")


@pytest.fixture(scope="session")
def environment() -> dict[str, str]:
    return os.environ | {"OPENBLAS_NUM_THREADS": "1"}


@pytest.fixture
def run(pendulum: Path, environment: dict[str, str], tmp_path: Path) -> Run:
    """Runs the pendulum in a folder of its own, with any arguments."""

    def run_in_folder(*arguments: str | Path, **options: object) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [pendulum, *arguments],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=120,
            check=False,
            **options,
        )

    return run_in_folder


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    folder = tmp_path / "out"
    folder.mkdir()
    mount = shutil.which("mount")
    if os.geteuid() != 0 or mount is None:
        pytest.skip("only root can mount a small disk")
    command = [mount, "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)]
    if subprocess.run(command, capture_output=True, check=False).returncode != 0:
        pytest.skip("a small disk cannot be mounted here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.fixture(scope="session")
def cluster() -> Iterator[Cluster]:
    """A real Slurm whose arrays hold 25 tasks."""
    with contextlib.ExitStack() as stack:
        try:
            cluster = stack.enter_context(running_cluster(array_size=25, cpus=4))
        except NoSlurmError as why:
            no_slurm(why)
        yield cluster


@pytest.fixture
def slurm(cluster: Cluster) -> Iterator[Cluster]:
    """The same with an empty queue."""
    yield cluster
    cluster.empty()


def no_slurm(why: NoSlurmError) -> NoReturn:
    """Ends a test that needs Slurm: on a machine without it there is nothing to test, but CI must have it."""
    nothing_to_test(f"Slurm cannot be started: {why}")


@pytest.fixture
def sweep_environment(pendulum: Path) -> dict[str, str]:
    return os.environ | {"TAUT_BIN": str(pendulum.parent)}


@pytest.fixture
def sweep(sweep_environment: dict[str, str], tmp_path: Path) -> Sweep:
    """Runs scripts/sweep on sweep.toml, or another file, in a folder of its own."""

    def command(
        name: str,
        *arguments: str,
        cwd: Path = tmp_path,
        results: Path | None = None,
        file: str = "sweep.toml",
        **more: str,
    ) -> subprocess.CompletedProcess[str]:
        where = [] if results is None else ["--results", results]
        return subprocess.run(
            [sys.executable, SCRIPT, name, file, *where, *arguments],
            cwd=cwd,
            env=sweep_environment | more,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    return command


@pytest.fixture
def begin(sweep_environment: dict[str, str], tmp_path: Path) -> Iterator[Begin]:
    """Starts scripts/sweep run on sweep.toml; what still runs after the test is killed, programs included."""

    def command(*arguments: str, **more: str) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [sys.executable, SCRIPT, "run", "sweep.toml", *arguments],
            cwd=tmp_path,
            env=sweep_environment | more,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        stack.enter_context(process)
        stack.callback(process.kill)
        return process

    with adopting_orphans(), contextlib.ExitStack() as stack:
        yield command


@pytest.fixture
def drawn_modes(mechanism: Path, tmp_path: Path) -> Path:
    """A folder with a hanging pendulum, its made up mode of 0.5 Hz and the case that asks for it."""
    folder = made(mechanism, tmp_path, '&analysis kind = "modes" /\n' + HANGING)
    (folder / "equilibrium.csv").write_text(f"name,value\nrod.x,0\nrod.y,-0.5\nrod.angle,{-np.pi / 2}\n")
    (folder / "modes.csv").write_text("mode,frequency,growth,rod.vx,rod.vy,rod.wz\n1,0.5,0,0.5,0,1\n")
    return tmp_path


@pytest.fixture
def drawn_pendulum(mechanism: Path, tmp_path: Path) -> Path:
    """A folder with a pendulum that turns at 2 rad/s, as made up results."""
    folder = made(mechanism, tmp_path, PENDULUM)
    rows = ["t,rod.x,rod.y,rod.angle,hinge.fx,hinge.fy,energy"]
    for t in np.linspace(0, 2, 41):
        rows.append(f"{t},{0.5 * np.cos(2 * t)},{0.5 * np.sin(2 * t)},{2 * t},{np.sin(t)},1.0,0.0")
    (folder / "present.csv").write_text("\n".join(rows) + "\n")
    (folder / "summary.csv").write_text("case,method,status\ncase,present,reached-end\n")
    return tmp_path
