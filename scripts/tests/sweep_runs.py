"""A sweep in a folder of its own, and what is looked up of it."""

import csv
import json
import subprocess
import time
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[1] / "sweep"
# scripts/sweep to its end, and begun only.
Sweep = Callable[..., subprocess.CompletedProcess[str]]
Begin = Callable[..., subprocess.Popen[str]]

CASE = """&pendulum mass = 1.0 /
&integration t_end = 0.5 /
&output dt = 0.1 /
&method name = "present" /
&method name = "baseline" /
"""
MASSES = 'case = "base.nml"\napp = "{app}"\n[[parameter]]\nname = "mass"\nentry = "pendulum.mass"\n'


def program(folder: Path, name: str, text: str) -> None:
    path = folder / name
    path.write_text(f'#!/bin/sh\n[ "$1" = --version ] && {{ echo "taut test"; exit; }}\n{text}')
    path.chmod(0o755)


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
    deadline = time.monotonic() + 180
    while not happened():
        assert time.monotonic() < deadline
        time.sleep(0.01)
