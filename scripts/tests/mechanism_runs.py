"""The app mechanism, started from outside, and its tables: what its tests share."""

import csv
import re
import subprocess
from pathlib import Path

import numpy as np
from conftest import ROOT

CASES = ROOT / "cases" / "mechanism"


def start(mechanism: Path, folder: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [mechanism, *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def table(path: Path) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        values = np.loadtxt(file, delimiter=",", ndmin=2)
    return {name: values[:, i] for i, name in enumerate(names)}


def blocks(page: str) -> list[str]:
    """Returns the indented blocks of a page."""
    return [
        "\n".join(line[4:] for line in block.splitlines()).strip("\n") + "\n"
        for block in re.findall(r"(?:^(?:    .*|)\n)+", page, re.MULTILINE)
        if block.strip()
    ]
