"""The command line of scripts/benchmark."""

import argparse
import math
import sys
from pathlib import Path

from taut.benchmark import figures, table
from taut.benchmark.entrant import Peer
from taut.benchmark.install import install
from taut.benchmark.measure import Measurement, measure
from taut.benchmark.peers import PEERS
from taut.benchmark.problems import PROBLEMS
from taut.errors import TautError
from taut.files import write_whole


def names(text: str, known: dict[str, object], what: str) -> list[str]:
    """Returns the names in a list with commas; each must be known."""
    chosen = [name.strip() for name in text.split(",") if name.strip()]
    for name in chosen:
        if name not in known:
            raise TautError(f"there is no {what} '{name}'; there are {', '.join(known)}")
    return chosen


def present(chosen: str | None) -> dict[str, str]:
    """Returns the peers that take part with their versions: taut, and those named, or all installed ones."""
    wanted = list(PEERS) if chosen is None else ["taut", *names(chosen, PEERS, "peer")]
    versions = {name: PEERS[name].version() for name in dict.fromkeys(wanted)}
    lacking = [name for name, version in versions.items() if version is None]
    if chosen is not None and lacking:
        raise TautError(
            f"{', '.join(lacking)}: not installed; --install {','.join(lacking)} would install it"
        )
    return {name: version for name, version in versions.items() if version is not None}


def absent(chosen: str | None) -> list[Peer]:
    """Returns the peers that would take part if they were installed; none where some were named."""
    return [peer for peer in PEERS.values() if chosen is None and peer.version() is None]


def run(
    problems: list[str], versions: dict[str, str], largest: float, rounds: int, path: Path
) -> list[Measurement]:
    """Measures every size of the problems, and writes the table after each."""

    def tell(text: str) -> None:
        print(f"benchmark: {text}", file=sys.stderr, flush=True)

    rows: list[Measurement] = []
    for name in problems:
        problem = PROBLEMS[name]
        for size in (*problem.sizes, *problem.large_sizes):
            if size > largest:
                continue
            peers = [PEERS[peer] for peer in versions if size in problem.sizes or peer == "taut"]
            entrants = [entrant for peer in peers for entrant in peer.entrants(problem, size)]
            if not any(entrant.peer == "taut" for entrant in entrants):
                tell(f"{name} {size}: left out, taut has no model of it")
                continue
            rows += measure(problem, size, entrants, rounds, tell)
            table.write_csv(rows, path)
    return rows


def main() -> int:
    """Measures, writes the table and draws the figures."""
    parser = argparse.ArgumentParser(
        prog="benchmark",
        description="Measures taut beside other codes on the same problems, at equal errors against "
        "independent references: DIR/benchmark.csv, benchmark.md, work_precision.png, cost_size.png, and "
        "pairs_rhs.png and pairs_time.png of the two explicit pairs.",
    )
    parser.add_argument(
        "--with", dest="peers", metavar="PEER,...", help=f"of {', '.join(PEERS)}; default: all installed"
    )
    parser.add_argument(
        "--install", metavar="PEER,...", help="first install these, from PyPI into .venv or from Debian"
    )
    parser.add_argument(
        "--problems", default=",".join(PROBLEMS), metavar="NAME,...", help="default: %(default)s"
    )
    parser.add_argument(
        "--largest", type=float, default=math.inf, metavar="N", help="leave out sizes above N"
    )
    parser.add_argument(
        "--rounds", type=int, default=3, metavar="K", help="timed rounds, default: %(default)s"
    )
    parser.add_argument(
        "--draw", action="store_true", help="measure nothing: page and figures from DIR/benchmark.csv"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("results/benchmark"), metavar="DIR", help="default: %(default)s"
    )
    arguments = parser.parse_args()
    path = arguments.out / "benchmark.csv"
    try:
        problems = names(arguments.problems, PROBLEMS, "problem")
        if arguments.install:
            install(PEERS[name] for name in names(arguments.install, PEERS, "peer"))
        versions = present(arguments.peers)
        if arguments.draw:
            rows = table.read_csv(path)
        else:
            rows = run(problems, versions, arguments.largest, arguments.rounds, path)
        if not rows:
            raise TautError("nothing was measured")
        page = table.markdown(rows, PROBLEMS, versions, absent(arguments.peers))
        write_whole(path.with_suffix(".md"), page + "\n")
        for written in (path, path.with_suffix(".md"), *figures.save(rows, arguments.out)):
            print(written)
        wrong = table.missed(rows, PROBLEMS)
        for line in wrong:
            print(f"benchmark: {line}", file=sys.stderr)
        return 1 if wrong else 0
    except (TautError, OSError) as error:
        print(f"benchmark: {error}", file=sys.stderr)
        return 1
