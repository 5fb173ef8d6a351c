"""Processes that a test leaves behind: they are found and killed, whoever started them."""

import contextlib
import ctypes
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

# prctl's number for a process that inherits the orphans among its descendants (Linux).
PR_SET_CHILD_SUBREAPER = 36


def children() -> set[int]:
    """Returns the processes whose parent this one is."""
    lists = (path.read_text() for path in Path("/proc/self/task").glob("*/children"))
    return {int(number) for text in lists for number in text.split()}


@contextlib.contextmanager
def adopting_orphans() -> Iterator[None]:
    """Kills, at the end, every process that was started inside, also those whose parent has died."""
    prctl = ctypes.CDLL(None).prctl
    before = children()
    prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    try:
        yield
    finally:
        # The children of those that are killed are adopted and found in the next round.
        while left := children() - before:
            for number in left:
                with contextlib.suppress(ProcessLookupError, ChildProcessError):
                    os.kill(number, signal.SIGKILL)
                    os.waitpid(number, 0)
        prctl(PR_SET_CHILD_SUBREAPER, 0, 0, 0, 0)


def listens(pid: int) -> bool:
    """Returns whether a program has got as far as to catch SIGTERM."""
    with contextlib.suppress(OSError):
        status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
        caught = int(status.partition("SigCgt:")[2].split()[0], 16)
        return bool(caught >> (signal.SIGTERM - 1) & 1)
    return False


def let_run(process: subprocess.Popen[str], seconds: float) -> None:
    """Lets a program run for some time after it has got as far as to catch signals, or until it ends."""
    while process.poll() is None and not listens(process.pid):
        time.sleep(0.01)
    time.sleep(seconds)
