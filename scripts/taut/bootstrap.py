"""Finds the Python that has the packages; needs only the standard library itself."""

import importlib.util
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# What the scripts import, as far as it does not come with another of these.
PACKAGES = ("f90nml", "jinja2", "matplotlib", "scipy", "tqdm")


def use_venv() -> None:
    """Starts the calling script again under the project's .venv when this Python lacks a package."""
    if all(importlib.util.find_spec(name) for name in PACKAGES):
        return
    prefix, python = ROOT / ".venv", ROOT / ".venv" / "bin" / "python"
    # Comparing prefixes, not programs: .venv/bin/python is often a link to the very Python that runs now.
    # os.path's, for Path's raises where the way there is barred.
    if not os.path.exists(python) or Path(sys.prefix).resolve() == prefix.resolve():
        sys.exit(f"{Path(sys.argv[0]).name}: a Python package is not installed: run scripts/setup first")
    sys.stdout.flush()
    try:
        os.execv(python, [str(python), *sys.argv])
    except OSError as error:
        sys.exit(f"{Path(sys.argv[0]).name}: {python} cannot be started: {error.strerror}")


def print_any(text: str) -> None:
    """Prints text on any terminal: signs that its encoding lacks become question marks."""
    encoding = sys.stdout.encoding or "ascii"
    print(text.encode(encoding, "replace").decode(encoding))
