"""All unit tests and an example, built by flang: some minutes.

Run by name: pytest -c scripts/pytest.ini scripts/tests/study_flang.py
"""

import re
import subprocess
from pathlib import Path

from conftest import ROOT
from test_flang import fpm, need_flang, project


def test_unit_tests_pass() -> None:
    need_flang()
    said = fpm(ROOT, "test")
    found = re.search(r"(\d+) passed, 0 failed", said)
    assert found and int(found[1]) > 400


def test_system_without_derivatives(tmp_path: Path) -> None:
    chain = project(tmp_path, "cases/examples/hanging_chain.f90")
    ran = subprocess.run([chain], capture_output=True, text=True, check=False, timeout=300)
    assert ran.returncode == 0, ran.stderr
    lines = [line for line in ran.stdout.splitlines() if "reached-end" in line]
    assert [line.split()[0] for line in lines] == ["5", "20"]
    assert all(abs(float(line.split()[-1])) < 1e-4 for line in lines)
