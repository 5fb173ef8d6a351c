"""Files that are whole or not there."""

import fcntl
import json
import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def whole(path: Path, *, sync: bool = True) -> Iterator[Path]:
    """Gives a temporary path to write to and renames it in the end: no half of a file is ever seen."""
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}")
    try:
        yield part
        if sync:
            handle = os.open(part, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)
        os.replace(part, path)
    except BaseException as error:
        part.unlink(missing_ok=True)
        if isinstance(error, OSError):
            # What is wrong is wrong with the file that was wanted; a full disk names none at all.
            error.filename = str(path)
        raise


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Lets one process at a time pass; the others wait."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield


def write_whole(path: Path, text: str, *, sync: bool = True) -> None:
    """Writes a text."""
    with whole(path, sync=sync) as part:
        part.write_text(text, encoding="utf-8")


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
