"""Runs a sweep on this machine: as many programs at a time as there are cores."""

import signal
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from tqdm import tqdm

from taut.errors import TautError
from taut.sweep.execute import Executor, Outcome, Stop
from taut.sweep.plan import Run
from taut.sweep.store import ENDED_EARLY

# How often another process is asked whether it is finished [s].
POLL = 0.5
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)


@dataclass
class Report:
    """What came of some runs."""

    workers: int
    seconds: float = 0.0
    # Of all runs together: from beginning to end, and what of it were integrations.
    run_seconds: float = 0.0
    own_seconds: float = 0.0
    started: int = 0
    stopped: bool = False
    states: Counter[str] = field(default_factory=Counter)
    # What the programs said that failed or ended early, by state and message: how often, and where first.
    messages: Counter[tuple[str, str]] = field(default_factory=Counter)
    examples: dict[tuple[str, str], Path] = field(default_factory=dict)

    def add(self, outcome: Outcome) -> None:
        """Counts a run."""
        self.states[outcome.state] += 1
        self.started += outcome.ran
        self.run_seconds += outcome.seconds
        self.own_seconds += outcome.own_seconds
        if outcome.ran and outcome.state in ("failed", ENDED_EARLY):
            said = outcome.state, outcome.message
            self.messages[said] += 1
            self.examples.setdefault(said, outcome.folder)

    @property
    def overhead(self) -> float:
        """Everything but the integrations themselves, per run that was started [s]."""
        return (self.run_seconds - self.own_seconds) / max(self.started, 1)


def run_all(executor: Executor, runs: Iterable[Run], workers: int, patient: bool) -> Report:
    """Runs what is not finished; signals stop it.

    What other processes have is asked for again at the end: once, or, if it is patient, until it is finished.
    """
    waiting = list(runs)
    report = Report(workers)
    start = time.monotonic()
    with (
        stopping(executor.stop),
        ThreadPoolExecutor(workers) as pool,
        tqdm(total=sum(run.count for run in waiting), unit="run", disable=not sys.stderr.isatty()) as bar,
    ):
        try:
            busy = []
            futures = {pool.submit(executor.execute, run): run for run in waiting}
            finished = 0
            for future in _completed(futures):
                if future is None:
                    if not bar.disable:
                        bar.update(finished + sum(map(executor.reached, futures.values())) - bar.n)
                    continue
                outcome = future.result()
                run = futures.pop(future)
                if outcome.state == "busy":
                    busy.append(run)
                else:
                    report.add(outcome)
                    finished += run.count
                    bar.update(max(0, finished - bar.n))
            asked = 0
            while busy and not executor.stop.asked and (patient or asked == 0):
                if asked == 1:
                    print(
                        f"sweep: waiting for {executor.plan.counted(len(busy))} of another process",
                        file=sys.stderr,
                    )
                if asked:
                    time.sleep(POLL)
                outcomes = list(zip(busy, pool.map(executor.execute, busy), strict=True))
                # Those that are not asked any more, once all is to stop, are still with the other process.
                busy = [run for run, outcome in outcomes if outcome.state in ("busy", "stopped")]
                for run, outcome in outcomes:
                    if outcome.state not in ("busy", "stopped"):
                        report.add(outcome)
                        bar.update(run.count)
                asked += 1
            report.states["busy"] += len(busy)
        except OSError as error:
            # Without room, or without the right to write, no other run would fare better.
            executor.stop.ask()
            pool.shutdown(cancel_futures=True)
            raise TautError(
                f"{error.filename or executor.store.root}: {error.strerror}; runs that are done are kept"
            ) from None
    report.stopped = executor.stop.asked
    report.seconds = time.monotonic() - start
    return report


def _completed(futures: Iterable[Future[Outcome]]) -> Iterator[Future[Outcome] | None]:
    """Returns what is finished as it is; None now and then between, for the progress."""
    pending = set(futures)
    while pending:
        done, pending = wait(pending, timeout=POLL, return_when=FIRST_COMPLETED)
        yield from done or (None,)


@contextmanager
def stopping(stop: Stop) -> Iterator[None]:
    """Passes signals on to the programs instead of dying of them."""
    # What is ignored already, as the end of the terminal is under nohup, stays ignored.
    numbers = [number for number in SIGNALS if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, lambda *_: stop.ask()) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
