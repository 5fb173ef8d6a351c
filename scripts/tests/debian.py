"""Debian's packages that a test needs: installed where that may be done, asked for where not."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import NoReturn

import pytest

from taut.files import locked

# Where Debian has daemons; an ordinary user's PATH may lack it.
PATH = os.pathsep.join([os.environ.get("PATH", "/usr/bin:/bin"), "/usr/sbin", "/sbin"])

# The lists of packages have no lock that waits.
INSTALLING = Path(tempfile.gettempdir()) / "taut-apt.lock"


class NoPackageError(Exception):
    """A package is missing and cannot be had."""


def install(*packages: str) -> None:
    """Installs packages, or raises NoPackageError."""
    if not shutil.which("apt-get"):
        raise NoPackageError(f"{' '.join(packages)}: there is no apt-get to install it")
    if os.getuid() != 0:
        raise NoPackageError(f"as root: apt-get install {' '.join(packages)}")
    with locked(INSTALLING):
        apt_get("update", check=False)
        apt_get("-o", "DPkg::Lock::Timeout=300", "install", "--yes", "--no-install-recommends", *packages)


def apt_get(*arguments: str, check: bool = True) -> None:
    """Calls apt-get, which asks nothing."""
    done = subprocess.run(
        ["apt-get", *arguments],
        env=os.environ | {"DEBIAN_FRONTEND": "noninteractive", "PATH": PATH},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    if check and done.returncode:
        raise NoPackageError(f"apt-get {' '.join(arguments)}: {done.stderr.strip()[-500:]}")


def nothing_to_test(why: object) -> NoReturn:
    """Ends a test on a machine without what it needs; but CI must have it."""
    if os.environ.get("CI"):
        pytest.fail(str(why))
    pytest.skip(str(why))
