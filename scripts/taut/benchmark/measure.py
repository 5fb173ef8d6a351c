"""Runs the entrants of a problem: first whether each is right, then in turns what each costs."""

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from taut.benchmark.entrant import Array, Entrant, Problem
from taut.benchmark.peers.program import WORK, TookTooLongError
from taut.errors import TautError

# Processor time that one entrant gets in one round [s]; a run that takes longer than SLOW is not repeated.
SHARE = 0.1
SLOW = 2.0
# A peer whose run took longer than this [s] is not asked for stricter tolerances: before and after it reached
# the smallest target.
TOO_SLOW = 20.0
ENOUGH = 1.0


@dataclass(frozen=True)
class Measurement:
    """What an entrant did with one setting: a row of the table."""

    problem: str
    size: int
    entrant: str
    peer: str
    setting: float
    steps: int
    rhs: int
    jacobians: int
    seconds: float
    error: float
    violation: float

    @property
    def microseconds_per_step(self) -> float:
        """Time of an accepted step."""
        return 1e6 * self.seconds / max(self.steps, 1)

    def reaches(self, target: float) -> bool:
        """Tells whether the error is small enough; one that is no number is not."""
        return self.error <= target


def kept(problem: Problem, size: int, folder: Path = WORK) -> Array:
    """Returns the reference, computed once; a file keeps it while the problem's module stays the same."""
    module = Path(problem.reference.__code__.co_filename).read_bytes()
    path = folder / f"{problem.name}-{size}-{hashlib.sha256(module).hexdigest()[:12]}.npy"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        np.save(path, problem.reference(size))
    return np.load(path)


def measure(
    problem: Problem,
    size: int,
    entrants: Sequence[Entrant],
    rounds: int,
    tell: Callable[[str], None],
) -> list[Measurement]:
    """Returns a measurement for each entrant and setting that ran to its end; what did not is told."""
    reference = kept(problem, size)
    found: dict[tuple[int, float], Measurement] = {}
    for index, entrant in enumerate(entrants):
        tell(f"{problem.name} {size}: {entrant.label}")
        for setting in entrant.settings:
            try:
                run = entrant.run(setting, 0.0)
                if run.state.shape != reference.shape:
                    raise TautError(f"{run.state.shape} numbers instead of {reference.shape}")
            except TautError as error:
                tell(f"{problem.name} {size}: {entrant.label} at {setting:.0e} failed: {error}")
                if isinstance(error, TookTooLongError):
                    break
                continue
            found[index, setting] = Measurement(
                problem.name,
                size,
                entrant.label,
                entrant.peer,
                setting,
                run.steps,
                run.rhs,
                run.jacobians,
                run.seconds,
                problem.error(size, run.state, reference),
                problem.violation(size, run.state),
            )
            reached = found[index, setting].reaches(min(problem.targets(size)))
            last = setting == entrant.settings[-1]
            if not last and entrant.peer != "taut" and run.seconds > (ENOUGH if reached else TOO_SLOW):
                tell(f"{problem.name} {size}: {entrant.label} is not run below {setting:.0e}")
                break

    # In turns, so that a spell in which the machine is slow meets everyone.
    for number in range(rounds):
        tell(f"{problem.name} {size}: round {number + 1} of {rounds}")
        for (index, setting), best in found.items():
            if best.seconds < SLOW:
                seconds = entrants[index].run(setting, SHARE).seconds
                found[index, setting] = replace(found[index, setting], seconds=min(best.seconds, seconds))
    return list(found.values())


def cheapest(rows: Sequence[Measurement], target: float) -> dict[str, Measurement | None]:
    """Returns for each entrant its cheapest setting that reaches a target error, or None if none does."""
    best: dict[str, Measurement | None] = {}
    for row in rows:
        held = best.setdefault(row.entrant, None)
        if row.reaches(target) and (held is None or row.seconds < held.seconds):
            best[row.entrant] = row
    return best


def exponent(sizes: Sequence[int], costs: Sequence[float]) -> float:
    """Returns the slope of the straight line through the logarithms; no number for less than two sizes."""
    if len(sizes) < 2:
        return math.nan
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])
