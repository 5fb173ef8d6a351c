from importlib.metadata import version
from pathlib import Path

REQUIREMENTS = Path(__file__).parents[1] / "requirements.txt"


def test_environment_holds_the_pinned_versions() -> None:
    lines = REQUIREMENTS.read_text(encoding="utf-8").splitlines()
    pins = dict(line.split("==") for line in lines if line and not line.startswith("#"))
    assert {name: version(name) for name in pins} == pins
