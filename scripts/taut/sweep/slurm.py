"""Slurm's commands, as far as sweeps need them: what may be submitted, what waits, what ended."""

import os
import re
import shlex
import shutil
import subprocess
from collections import Counter
from pathlib import Path
from typing import Any

from taut.errors import TautError

# What the arrays are made of is not for others to say.
OURS = ("array", "wrap", "parsable", "test-only")
# Slurm shows tasks for a moment after they ended.
ENDED = ("COMPLETING", "COMPLETED")


def check_there() -> None:
    """Refuses to go on without Slurm."""
    if not shutil.which("sbatch"):
        raise TautError("there is no sbatch here; --slurm needs a machine where Slurm's commands are")


def check_options(options: list[str]) -> None:
    """Refuses options of sbatch that would make something else of the array."""
    for option in options:
        if not option.startswith("-"):
            continue
        name = option.lstrip("-").partition("=")[0]
        if name in OURS or re.match(r"-a\b|-a\d", option):
            raise TautError(f"sbatch option '{option}': the array is made here; leave it out")


def check_table(table: dict[str, Any]) -> None:
    """Refuses what is no option of sbatch in a sweep file's [slurm]."""
    for key, value in table.items():
        if not re.fullmatch(r"[a-z][a-z-]*", key):
            raise TautError(f"[slurm] has '{key}'; write sbatch's long options, as in cpus-per-task = 1")
        if not isinstance(value, bool | int | float | str) or not str(value).isprintable():
            raise TautError(f"[slurm] '{key}' must be a number, true, or a text as in \"02:00:00\"")
    check_options([f"--{key}" for key in table])


def directives(table: dict[str, Any]) -> str:
    """Returns the lines of a script that give sbatch the options of a table; false leaves one out."""
    lines = [
        f"#SBATCH --{key}" + ("" if value is True else f"={shlex.quote(str(value))}")
        for key, value in table.items()
        if value is not False
    ]
    return "".join(f"{line}\n" for line in lines)


def submit(script: Path, options: list[str]) -> str:
    """Submits a script and returns the job's number."""
    said = _command("sbatch", "--parsable", *options, str(script))
    # The cluster's name follows after a semicolon where there are several.
    return said.strip().splitlines()[-1].partition(";")[0]


def array_limit() -> int:
    """Returns how many tasks an array may have."""
    found = re.search(r"^MaxArraySize\s*=\s*(\d+)", _command("scontrol", "show", "config"), re.MULTILINE)
    limit = int(found[1]) if found else 1001
    if limit < 2:
        raise TautError("this Slurm has no job arrays (MaxArraySize in 'scontrol show config')")
    return limit


def queue() -> dict[Path, dict[int, str]]:
    """Returns the state of the user's tasks that wait or run, by script and number in the array."""
    found: dict[Path, dict[int, str]] = {}
    said = _command("squeue", f"--user={os.getuid()}", "--noheader", "--array", "--format=%K|%T|%o")
    for line in said.splitlines():
        number, state, script = line.split("|", 2)
        if number.isdecimal() and state not in ENDED:
            found.setdefault(Path(script.strip()), {})[int(number)] = state.lower()
    return found


def ended(jobs: list[str]) -> Counter[str]:
    """Returns how the tasks of jobs ended, from Slurm's accounting; nothing where there is none."""
    if not jobs or not shutil.which("sacct"):
        return Counter()
    try:
        said = _command(
            "sacct",
            "--noheader",
            "--parsable2",
            "--allocations",
            f"--jobs={','.join(jobs)}",
            "--format=State",
        )
    except TautError:
        return Counter()
    # CANCELLED is followed by who did it.
    states = (line.split()[0].lower() for line in said.splitlines() if line.strip())
    return Counter(state for state in states if state not in ("pending", "running", "requeued", "suspended"))


def _command(*words: str) -> str:
    """Runs a command and returns what it says."""
    try:
        done = subprocess.run(
            words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300, check=False
        )
    except FileNotFoundError:
        raise TautError(f"there is no {words[0]} here") from None
    except subprocess.TimeoutExpired:
        raise TautError(f"{words[0]} timed out") from None
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines() or [f"exit code {done.returncode}"]
        lines = [line if words[0] in line else f"{words[0]}: {line}" for line in lines]
        # Why a job is refused may take lines; of a Slurm that is not there the last one says it.
        if words[0] == "sbatch":
            raise TautError("; ".join(lines))
        raise TautError(f"Slurm does not answer here ({lines[-1]}); go where '{words[0]}' works")
    return done.stdout
