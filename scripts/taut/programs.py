"""The programs of taut: where they are, what they say of their version, and whether they take a case."""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from taut.bootstrap import ROOT
from taut.errors import TautError
from taut.files import locked

# The systems are small: more threads would cost time and make the last digits vary.
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OPENBLAS", "OMP", "MKL")}
# Who builds holds it: fpm does not see that another one is at work in the same folder.
BUILDING = ROOT / "build" / ".lock"
# A build that takes longer is announced [s].
SILENCE = 2.0


@dataclass(frozen=True)
class Program:
    """A program and everything that it prints with --version."""

    path: Path
    version: str


def find(app: str) -> Program:
    """Returns the program: in the folder TAUT_BIN, or the repository's release build, or on the PATH."""
    if folder := os.environ.get("TAUT_BIN"):
        path = Path(folder) / app
        if not os.access(path, os.X_OK):
            raise TautError(f"{path}: there is no such program in the folder that TAUT_BIN names")
    elif (ROOT / "app" / f"{app}.f90").is_file() and fpm():
        path = release(app)
    elif found := shutil.which(app):
        path = Path(found)
    else:
        raise TautError(
            f"there is no program '{app}'; 'app' in the sweep file names one, TAUT_BIN its folder"
        )
    return Program(path.resolve(), version_of(path))


def version_of(path: Path) -> str:
    """Returns what a program prints with --version."""
    try:
        done = subprocess.run([path, "--version"], capture_output=True, text=True, check=False)
    except OSError as error:
        raise TautError(f"{path}: the program cannot be started: {error.strerror}") from None
    if done.returncode != 0:
        raise TautError(f"{path} --version failed: {last_line(done.stderr, done.returncode)}")
    return done.stdout.strip()


def help_of(program: Path) -> str:
    """Returns what a program prints with --help."""
    return subprocess.run([program, "--help"], capture_output=True, text=True, check=False).stdout


def check_case(program: Path, text: str, options: Sequence[str] = ()) -> str | None:
    """Returns what a program has against a case or an option; nothing is integrated, nothing stays."""
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "case.nml"
        case.write_text(text, encoding="utf-8")
        # Programs read and check everything before they write; a folder below a file ends them there.
        command = [program, case.name, "--out", f"{case.name}/none", "--quiet", *options]
        done = subprocess.run(
            command,
            cwd=folder,
            capture_output=True,
            text=True,
            errors="replace",
            env=os.environ | ONE_THREAD,
            check=False,
        )
    said = last_line(done.stderr, done.returncode)
    return None if f"{case.name}/none/" in said else said


def last_line(text: str, code: int) -> str:
    """Returns the last line of what a program said, or how it ended if it said nothing."""
    lines = text.strip().splitlines()
    if lines:
        return lines[-1].strip()
    return f"ended by signal {-code}" if code < 0 else f"exit code {code}"


def cores() -> int:
    """Returns how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def fpm() -> str | None:
    """Returns where fpm is: in .venv, or on the PATH."""
    own = ROOT / ".venv" / "bin" / "fpm"
    return str(own) if own.is_file() else shutil.which("fpm")


def release(app: str) -> Path:
    """Builds a program of the repository in the release profile if need be, and returns where fpm puts it."""
    if (found := fpm()) is None:
        raise TautError("fpm is not installed; run scripts/setup first")
    # fpm itself tells, for a build folder may hold programs made with several sets of flags.
    kind = [] if (ROOT / "app" / f"{app}.f90").is_file() else ["--example"]
    command = [found, "run", *kind, app, "--profile", "release", "--runner", "echo"]
    with (
        locked(BUILDING),
        subprocess.Popen(
            command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as build,
    ):
        try:
            out, said = build.communicate(timeout=SILENCE)
        except subprocess.TimeoutExpired:
            print(f"{Path(sys.argv[0]).name}: building {app}", file=sys.stderr, flush=True)
            out, said = build.communicate()
    if build.returncode != 0:
        raise TautError(f"the build of {app} failed: {last_line(out + said, build.returncode)}")
    return ROOT / out.strip().splitlines()[-1].strip()
