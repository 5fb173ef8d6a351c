"""Instruction counts of short runs under callgrind: unlike times they are the same on a busy machine."""

import argparse
import csv
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from taut.benchmark.peers.program import call
from taut.bootstrap import ROOT
from taut.case_file import Entry, Template
from taut.errors import TautError
from taut.programs import release
from taut.results import read_table

BASELINE = Path(__file__).with_name("instructions.csv")
COLUMNS = ("run", "instructions", "compiler")
# Growth that is an error [%].
THRESHOLD = 3.0
# Counting begins and ends with a procedure: loading a program costs as much as integrating a pendulum.
COUNTED = "__taut_ode_integrate_MOD_run"
# All that an app does; reading and assembling a mechanism; all runs of a sweep.
APPLICATION = "__taut_case_application_MOD_run_application"
READING = "__taut_case_mechanism_MOD_read_loaded"
SWEEPING = "__taut_case_variants_MOD_run_variants"
# Loops of hinges in space that share their cranks, three redundant constraints each.
LOOPS = """
&gravity /
&body
   name = "crank#", shape = "rod", thickness = 0.1, mass = 1.0, from = 0.0, 0.0, 0.0, to = 0.0, 1.0, 0.0
   from_step = 1.0, 0.0, 0.0, to_step = 1.0, 0.0, 0.0, repeat = {cranks}, first = 0
   velocity = 0.5, 0.0, 0.0, angular_velocity = 0.0, 0.0, -1.0
/
&body
   name = "bar#", shape = "rod", thickness = 0.1, mass = 1.0, from = 0.0, 1.0, 0.0, to = 1.0, 1.0, 0.0
   from_step = 1.0, 0.0, 0.0, to_step = 1.0, 0.0, 0.0, repeat = {loops}, velocity = 1.0, 0.0, 0.0
/
&joint
   name = "A#", type = "revolute", body_2 = "crank#", point = 0.0, 0.0, 0.0
   point_step = 1.0, 0.0, 0.0, axis = 0.0, 0.0, 1.0, repeat = {cranks}, first = 0
/
&joint
   name = "left#", type = "revolute", body_1 = "crank#-1", body_2 = "bar#", point = 0.0, 1.0, 0.0
   point_step = 1.0, 0.0, 0.0, axis = 0.0, 0.0, 1.0, repeat = {loops}
/
&joint
   name = "right#", type = "revolute", body_1 = "bar#", body_2 = "crank#", point = 1.0, 1.0, 0.0
   point_step = 1.0, 0.0, 0.0, axis = 0.0, 0.0, 1.0, repeat = {loops}
/
&integration t_end = 1e-3 /
&output dt = 1e-3 /
"""


@dataclass(frozen=True)
class Short:
    """A short run: the app, and its arguments given a folder of its own."""

    app: str
    arguments: Callable[[Path], Sequence[str]]
    counted: str = COUNTED


def written(text: str) -> Callable[[Path], Sequence[str]]:
    """Returns what writes a case of its own and returns the arguments."""

    def write(folder: Path) -> Sequence[str]:
        case = folder / "own.nml"
        case.write_text(text, encoding="utf-8")
        return [str(case), "--out", str(folder), "--quiet"]

    return write


def loops(number: int) -> Callable[[Path], Sequence[str]]:
    """Returns what writes a case of so many loops and returns the arguments."""
    return written(LOOPS.format(loops=number, cranks=number + 1))


def listed(folder: Path) -> Sequence[str]:
    """Writes a case with a blank and a list of twenty runs, and returns the arguments."""
    path = folder / "runs.tsv"
    path.write_text("".join(f"{i}\t{0.5 + 0.1 * i}\n" for i in range(20)), encoding="utf-8")
    case, *_ = written("&pendulum mass = @1@ /\n")(folder)
    return [case, "--runs", str(path), "--quiet"]


def shortened(path: str, end: float) -> Callable[[Path], Sequence[str]]:
    """Returns what writes a shipped case with an early end [s] and returns the arguments."""

    def write(folder: Path) -> Sequence[str]:
        template = Template(ROOT / "cases" / path, [Entry.read("integration.t_end")])
        case = folder / "short.nml"
        case.write_text(template.fill([end]), encoding="utf-8")
        return [str(case), "--out", str(folder), "--quiet"]

    return write


RUNS: dict[str, Short] = {
    "pendulum": Short("taut_benchmark", lambda _: "pendulum 1 present 1e-6 1e-6 0.1 10 0".split()),
    "chain-100": Short("taut_benchmark", lambda _: "chain 100 present 1e-6 1e-8 0 1 0".split()),
    "four-bar-2": Short("taut_benchmark", lambda _: "four-bar 2 present 1e-8 1e-8 0 2 0".split()),
    "swing-1b": Short("swing", shortened("swing/1b.nml", 2e-3)),
    # Without output points: of what turns about the ground only the angle is computed.
    "andrews-motion": Short(
        "taut_benchmark", lambda _: "andrews 1 present-stage-none 1e-8 1e-8 0 0.03 0".split()
    ),
    "andrews": Short("mechanism", shortened("mechanism/andrews.nml", 1e-3)),
    "bricard": Short("mechanism", shortened("mechanism/bricard.nml", 0.05)),
    # Twice as many loops are to cost twice as much, from reading the file to the first steps.
    "loops-50": Short("mechanism", loops(50), APPLICATION),
    "loops-100": Short("mechanism", loops(100), APPLICATION),
    "bricard-dop853": Short("taut_benchmark", lambda _: "bricard 1 present-dop853 1e-9 1e-9 0 1 0".split()),
    "spring-radau": Short("taut_benchmark", lambda _: "spring 8 present-radau 1e-6 1e-9 0 1 0".split()),
    "read-chain": Short("mechanism", shortened("mechanism/chain.nml", 1e-6), READING),
    "csv": Short("pendulum", written("&output dt = 1e-2 /\n")),
    "sweep": Short("pendulum", listed, SWEEPING),
}


def count(program: Path, arguments: Sequence[str], output: Path, counted: str = COUNTED) -> int:
    """Returns the instructions of a procedure under callgrind; the output keeps where they were."""
    # OpenBLAS chooses its kernels by the processor, and the count must not.
    command = ["env", "OPENBLAS_CORETYPE=Haswell", "valgrind", "--tool=callgrind", "--quiet"]
    command += [f"--toggle-collect={counted}", f"--callgrind-out-file={output}", str(program), *arguments]
    call(command)
    found = re.search(r"(?m)^(?:totals|summary): (\d+)", output.read_text(encoding="utf-8"))
    if found is None or found[1] == "0":
        raise TautError(f"callgrind counted nothing in {counted}")
    return int(found[1])


def functions(annotated: str, most: int) -> list[tuple[float, str]]:
    """Returns shares [%] and names of the functions that cost most, from what callgrind_annotate prints."""
    rows = re.findall(r"(?m)^\s*[\d,]+ \(\s*([\d.]+)%\)\s+(?!PROGRAM)\S*?:(\S+)(?: \[.*\])?$", annotated)
    return [(float(share), readable(name)) for share, name in rows[:most]]


def readable(symbol: str) -> str:
    """Returns a function's name as its source has it, without what the compiler adds."""
    name = re.sub(r"(\.(isra|part|constprop|cold)?\.?\d+)+$", "", symbol)
    name = re.sub(r"\.\d+$", "", name)
    return re.sub(r"^__(\w+?)_MOD_", r"\1: ", name)


def compiler() -> str:
    """Returns the compiler's name and version."""
    return call(["gfortran", "--version"]).splitlines()[0]


def read_baseline(path: Path = BASELINE) -> dict[str, tuple[int, str]]:
    """Returns the stored counts and their compilers."""
    table = read_table(path, rows_needed=False, remedy="scripts/instructions --update makes it")
    try:
        return {name: (int(value), by) for name, value, by in zip(*map(table.column, COLUMNS), strict=True)}
    except (TautError, ValueError) as error:
        raise TautError(f"{path} is not a table of {','.join(COLUMNS)}") from error


def write_baseline(counts: dict[str, int], version: str, path: Path = BASELINE) -> None:
    """Stores counts."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows((name, value, version) for name, value in counts.items())


def compare(
    counts: dict[str, int], baseline: dict[str, tuple[int, str]], version: str, threshold: float
) -> tuple[list[str], list[str]]:
    """Returns the table, and a line for each run that grew above the threshold [%] or has no baseline."""
    lines = ["| run | instructions | baseline | change |", "| --- | --- | --- | --- |"]
    complaints = []
    for name, value in counts.items():
        if name not in baseline:
            lines.append(f"| {name} | {value:,} | | |")
            complaints.append(f"{name} has no baseline; scripts/instructions --update stores one")
            continue
        stored, by = baseline[name]
        change = 100 * (value - stored) / stored
        lines.append(f"| {name} | {value:,} | {stored:,} | {change:+.2f} % |")
        if change > threshold:
            why = "" if by == version else f" (the baseline is of {by}, this is {version})"
            complaints.append(f"{name} takes {change:.2f} % more instructions than its baseline{why}")
    return lines, complaints


def main() -> int:
    """Counts, and compares with what is stored or stores it."""
    parser = argparse.ArgumentParser(
        prog="instructions",
        description="Counts the instructions of short runs (callgrind) and compares them with those in "
        f"{BASELINE.relative_to(ROOT)}; the exit code is 1 if one grew by more than the threshold.",
    )
    parser.add_argument("runs", nargs="*", metavar="RUN", help=f"of {', '.join(RUNS)}; default: all")
    parser.add_argument("--update", action="store_true", help="store the counts")
    parser.add_argument("--threshold", type=float, default=THRESHOLD, metavar="PERCENT", help="default: 3")
    parser.add_argument(
        "--profile",
        type=int,
        nargs="?",
        const=12,
        metavar="K",
        help="also show the K functions that cost most",
    )
    arguments = parser.parse_args()
    try:
        unknown = [name for name in arguments.runs if name not in RUNS]
        if unknown:
            raise TautError(f"there is no run '{unknown[0]}'; there are {', '.join(RUNS)}")
        if shutil.which("valgrind") is None:
            raise TautError("valgrind is not installed: apt-get install valgrind")
        counts, profiles = {}, {}
        with tempfile.TemporaryDirectory() as folder:
            for name in arguments.runs or RUNS:
                output = Path(folder) / f"{name}.callgrind"
                short = RUNS[name]
                given = short.arguments(Path(folder))
                counts[name] = count(release(short.app), given, output, short.counted)
                if arguments.profile:
                    profiles[name] = functions(call(["callgrind_annotate", output]), arguments.profile)
        version = compiler()
        stored = read_baseline() if BASELINE.exists() else {}
        lines, complaints = compare(counts, stored, version, arguments.threshold)
        print("\n".join(lines))
        for name, rows in profiles.items():
            print(f"\n| {name}: function | share |\n| --- | --- |")
            print("\n".join(f"| {function} | {share:.1f} % |" for share, function in rows))
        if arguments.update:
            kept = {name: value for name, (value, _) in stored.items() if name in RUNS}
            write_baseline(kept | counts, version)
            print(f"\nstored in {BASELINE.relative_to(ROOT)}")
            return 0
        for line in complaints:
            print(f"instructions: {line}", file=sys.stderr)
        return 1 if complaints else 0
    except (TautError, OSError) as error:
        print(f"instructions: {error}", file=sys.stderr)
        return 1
