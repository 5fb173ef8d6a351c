"""Installs peers that were asked for by name, and nothing else."""

import os
import shutil
import site
import sys
import sysconfig
from collections.abc import Iterable

from taut.benchmark.entrant import Peer
from taut.benchmark.peers.program import call
from taut.bootstrap import ROOT
from taut.errors import TautError


def install(peers: Iterable[Peer]) -> None:
    """Installs what the peers need: from PyPI into .venv, pinned; from Debian through apt-get, as root."""
    for peer in peers:
        if peer.pypi:
            # What the project pins stays as it is.
            pins = ROOT / "scripts" / "requirements.txt"
            call([sys.executable, "-m", "pip", "install", "--only-binary", ":all:", "-c", pins, *peer.pypi])
            # What has just come is found without a new start.
            site.addsitedir(sysconfig.get_path("purelib"))
        if peer.debian:
            if shutil.which("apt-get") is None:
                raise TautError(f"{peer.name} needs {' '.join(peer.debian)}, and there is no apt-get here")
            sudo = [] if os.geteuid() == 0 else ["sudo"]
            call([*sudo, "apt-get", "update"])
            call([*sudo, "apt-get", "install", "--yes", "--no-install-recommends", *peer.debian])
