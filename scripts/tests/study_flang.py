"""All unit tests, built by flang: some minutes.

Run by name: pytest -c scripts/pytest.ini scripts/tests/study_flang.py
"""

import re

from conftest import ROOT
from test_flang import fpm, need_flang


def test_unit_tests_pass() -> None:
    need_flang()
    said = fpm(ROOT, "test")
    found = re.search(r"(\d+) passed, 0 failed", said)
    assert found and int(found[1]) > 400
