"""Files that are whole or not there, and the one kind of error that a user sees."""

import json
import os
import tempfile
from pathlib import Path
from typing import Any


class SweepError(Exception):
    """What is wrong, in one line that says what to do."""


def write_whole(path: Path, text: str, *, sync: bool = True) -> None:
    """Writes a file under a temporary name and renames it, so that no half of it is ever seen."""
    handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with open(handle, "w", encoding="utf-8", newline="") as file:
            os.fchmod(file.fileno(), 0o644)
            file.write(text)
            file.flush()
            if sync:
                os.fsync(file.fileno())
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise


def write_json(path: Path, value: Any, *, sync: bool = True) -> None:
    """Writes a value as JSON."""
    write_whole(path, json.dumps(value, indent=1) + "\n", sync=sync)


def read_json(path: Path) -> dict[str, Any] | None:
    """Returns what a JSON file holds; None if it is missing or damaged."""
    try:
        value = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None
    return value if isinstance(value, dict) else None
