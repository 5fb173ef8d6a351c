"""One run: claimed by its lock, run by the program, recorded."""

import os
import shutil
import signal
import socket
import subprocess
import threading
import time
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Any

from taut.errors import TautError
from taut.files import write_json, write_whole
from taut.programs import ONE_THREAD, Program, last_line
from taut.results import read_table
from taut.sweep.plan import Plan, Run
from taut.sweep.store import (
    CASE,
    CHECKPOINT,
    ENDED_EARLY,
    FINISHED,
    LOG,
    RECORD,
    RESULTS,
    Store,
    lock,
    record_of,
)

# The statuses of an integration that came to its end.
COMPLETE = ("reached-end", "stopped-by-event")
# The program's exit code when a signal made it write a checkpoint and end.
INTERRUPTED = 75
# Not SIGTERM: a cluster sends that to programs itself, and a second one of a kind would end them at once.
ASK = signal.SIGUSR1


@dataclass(frozen=True)
class Outcome:
    """How a run ended: a state of the store, or 'busy' (another process has it) or 'stopped' (not begun)."""

    state: str
    folder: Path
    message: str = ""
    # How many runs the program was started for, how long this took, and how long of it it integrated [s].
    ran: int = 0
    seconds: float = 0.0
    own_seconds: float = 0.0


@dataclass(frozen=True)
class Work:
    """What came of a run's program: a state of the store, the exit code, and what is to be said of it."""

    state: str
    code: int
    message: str = ""
    # How long the program integrated [s]; whether it went on from a checkpoint; how many runs it made.
    own_seconds: float = 0.0
    restarted: bool = False
    runs: int = 1


class Stop:
    """Ends the programs that run, once asked to, and keeps others from starting."""

    def __init__(self) -> None:
        self.asked = False
        # Each program is asked once (a second signal ends it); a signal may come while another is handled.
        self._lock = threading.RLock()
        self._children: set[subprocess.Popen[bytes]] = set()

    def ask(self) -> None:
        """Asks the programs to write a checkpoint and end; asked again, kills them."""
        with self._lock:
            number = signal.SIGKILL if self.asked else ASK
            self.asked = True
            for child in list(self._children):
                child.send_signal(number)

    def wait_for(self, child: subprocess.Popen[bytes]) -> int:
        """Waits for a program that is ended when asked."""
        with self._lock:
            self._children.add(child)
            if self.asked:
                child.send_signal(ASK)
        code = child.wait()
        self._children.discard(child)
        return code


class Executor:
    """What all runs of a sweep have in common."""

    def __init__(self, plan: Plan, store: Store, program: Program) -> None:
        self.plan = plan
        self.store = store
        self.program = program
        self._environment = os.environ | ONE_THREAD
        self._host = socket.gethostname()
        self.stop = Stop()

    def execute(self, run: Run) -> Outcome:
        """Runs a run unless it is done or another process has it; OSError if its files cannot be written."""
        folder = self.store.folder(run)
        if self.stop.asked:
            return Outcome("stopped", folder)
        folder.mkdir(exist_ok=True)
        with lock(folder) as held:
            if held is None:
                return Outcome("busy", folder)
            before = record_of(folder, run)
            if before and before["state"] in FINISHED:
                return Outcome(before["state"], folder)
            return self._run(run, folder, held, before)

    def _run(self, run: Run, folder: Path, held: int, before: dict[str, Any] | None) -> Outcome:
        """Runs the program and records it."""
        begun = time.monotonic()
        record = {
            "state": "running",
            "hash": run.hash,
            "sweep": str(self.plan.sweep.path),
            "app": self.plan.sweep.app,
            "case": str(self.plan.sweep.case),
            "parameters": self.plan.parameters(run),
            "program": str(self.program.path),
            "version": self.program.version.splitlines(),
            "host": self._host,
            "attempts": (before["attempts"] if before else 0) + 1,
            "start": _now(),
            "end": None,
            "exit_code": None,
            "message": "",
            "restarted": False,
        }
        write_json(folder / RECORD, record, sync=False)
        started = time.monotonic()
        done = self._work(run, folder, held, before is not None)
        record |= {
            "restarted": done.restarted,
            "state": done.state,
            "exit_code": done.code,
            "message": done.message,
            "end": _now(),
        }
        write_json(folder / RECORD, record)
        # The program's account covers all attempts of a run that it continues.
        own = min(done.own_seconds, time.monotonic() - started)
        return Outcome(done.state, folder, done.message, done.runs, time.monotonic() - begun, own)

    def _work(self, run: Run, folder: Path, held: int, begun: bool) -> Work:
        """Runs the program, from its checkpoint if there is one."""
        write_whole(folder / CASE, self.plan.text(run), sync=False)
        restart = begun and (folder / CHECKPOINT).exists()
        if not restart:
            shutil.rmtree(folder / RESULTS, ignore_errors=True)
        code, said = self._integrate(folder, held, restart)
        if restart and code not in (0, INTERRUPTED) and _refused(said) and (folder / CHECKPOINT).exists():
            # Kept for a look at it, but the run begins anew.
            os.replace(folder / CHECKPOINT, folder / "refused_checkpoint.taut")
            shutil.rmtree(folder / RESULTS, ignore_errors=True)
            restart = False
            code, said = self._integrate(folder, held, False)
        state, message = "failed", last_line(said, code)
        if code == 0:
            state, message = "done", ""
        elif code == INTERRUPTED or (self.stop.asked and code < 0):
            state, message = "interrupted", ""
        elif code == 1 and _ended_early(folder):
            state = ENDED_EARLY
        own = sum(map(float, _summary(folder, "wall_seconds")))
        return Work(state, code, message, own, restart)

    def _integrate(self, folder: Path, held: int, restart: bool) -> tuple[int, str]:
        """Starts the program on the run's case."""
        arguments = [CASE, "--out", ".", "--quiet", *self.plan.sweep.options]
        if restart:
            # The program compares the folders of both options letter by letter.
            arguments += ["--restart", f"./{CHECKPOINT}"]
        return self._start(folder, held, arguments)

    def _start(
        self, folder: Path, held: int, arguments: list[str], out: IO[bytes] | None = None
    ) -> tuple[int, str]:
        """Starts the program in a folder and waits; returns its exit code and what it said."""
        with open(folder / LOG, "w+b") as log:
            child = subprocess.Popen(
                [str(self.program.path), *arguments],
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=out or log,
                stderr=log,
                env=self._environment,
                # As long as the program runs the lock is held, even if this process is killed.
                pass_fds=(held,),
                # Ctrl-C on the terminal is for this process, which passes it on.
                process_group=0,
            )
            code = self.stop.wait_for(child)
            log.seek(0)
            return code, log.read().decode(errors="replace")

    def reached(self, run: Run) -> int:  # noqa: ARG002
        """Returns how many runs of a batch are made so far; a single run is not counted before its end."""
        return 0


def _refused(said: str) -> bool:
    """Returns whether a program would not go on from a checkpoint; to fail writing one is something else."""
    return Path(CHECKPOINT).name in said and "cannot be written" not in said


def _ended_early(folder: Path) -> bool:
    """Returns whether a program went through its case, though an integration did not reach its end.

    The summary is written last: a program that fails in another way leaves none, or that of an interruption.
    """
    statuses = _summary(folder, "status")
    return "interrupted" not in statuses and any(status not in COMPLETE for status in statuses)


def _summary(folder: Path, column: str) -> list[str]:
    """Returns a column of the summary; nothing if there is none."""
    try:
        return read_table(folder / RESULTS / "summary.csv", rows_needed=False).column(column)
    except TautError:
        return []


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
