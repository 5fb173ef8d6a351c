"""The command `animate`."""

import argparse
import shutil
import sys
import zlib
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.figure import Figure

from taut import style
from taut.animate import gallery
from taut.animate.geometry import FILE, Mechanism, read_geometry
from taut.animate.motion import Motion, of_mode, of_run
from taut.animate.pictures import Shown, curves, frames, still
from taut.animate.scene import Look
from taut.errors import TautError
from taut.gif import write_gif
from taut.results import Results, Run, read_run, read_table

# Frames a second, and how long an animation lasts at least and at most unless it is said.
RATE, SHORT, LONG = 20, 3.0, 10.0


def parser() -> argparse.ArgumentParser:
    """Returns what the command understands."""
    made = argparse.ArgumentParser(
        prog="animate",
        description="Draws a mechanism from its case file and its results: an animation (default), "
        "a still (--still) or curves over time (--plot).",
    )
    made.add_argument("case", nargs="?", type=Path, metavar="CASE.nml", help="case file of the app mechanism")
    made.add_argument(
        "result",
        nargs="?",
        type=Path,
        metavar="RESULT.csv",
        help="default: results/CASE/METHOD.csv of its first method",
    )
    made.add_argument("--results", type=Path, default=Path("results"), metavar="DIR", help="default: results")
    made.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help=".gif, .mp4 (needs ffmpeg); default: results/figures/CASE.gif",
    )
    made.add_argument(
        "--still",
        nargs="+",
        metavar=("[TIME]", "FILE"),
        help="the mechanism at a time [s], as .png or .pdf; default: the last time; of a mode, which lasts "
        "one period, a quarter of it, where it goes farthest",
    )
    made.add_argument(
        "--plot", nargs="+", default=[], metavar="COLUMN", help="curves over time, such as hinge.fz tip.z"
    )
    made.add_argument("--below", nargs="+", default=[], metavar="COLUMN", help="curves below the animation")
    made.add_argument("--strobe", type=int, default=0, metavar="N", help="faint earlier positions in a still")
    made.add_argument(
        "--trace",
        nargs="*",
        metavar="NAME",
        help="bodies, points and joints that leave a trace; default: every &point",
    )
    made.add_argument("--names", action="store_true", help="write the names of bodies")
    made.add_argument(
        "--view",
        nargs=2,
        type=float,
        metavar=("TURN", "HEIGHT"),
        help="degrees; default: -60 18, or along the normal of the plane in which everything stays",
    )
    made.add_argument(
        "--window", nargs=4, type=float, metavar=("X1", "X2", "Y1", "Y2"), help="part of the picture [m]"
    )
    made.add_argument("--from", dest="start", type=float, metavar="T", help="first time [s]")
    made.add_argument("--to", dest="end", type=float, metavar="T", help="last time [s]")
    made.add_argument(
        "--seconds",
        type=float,
        metavar="S",
        help=f"how long the animation lasts; default: as the motion, {SHORT:g} to {LONG:g}",
    )
    made.add_argument(
        "--mode",
        type=int,
        metavar="K",
        help="which mode of a case with modes; 0: the equilibrium, as a still; default: 1",
    )
    made.add_argument(
        "--gallery", action="store_true", help="a still of each shipped case, to DIR/figures/gallery"
    )
    return made


def main(arguments: list[str] | None = None) -> int:
    """Draws what is asked for."""
    made = parser()
    chosen = made.parse_args(arguments)
    if bool(chosen.case) == chosen.gallery:
        made.error("give a case file, or --gallery")
    style.use()
    try:
        for path in gallery.make(Results(chosen.results)) if chosen.gallery else draw(chosen):
            print(path)
    except (TautError, OSError) as error:
        print(f"animate: {error}", file=sys.stderr)
        return 1
    return 0


def draw(chosen: argparse.Namespace) -> list[Path]:
    """Draws one case."""
    if chosen.result and not chosen.result.is_file():
        raise TautError(f"{chosen.result} is missing: {remedy(chosen)}")
    folder = chosen.result.parent if chosen.result else chosen.results / chosen.case.stem
    mechanism = read_geometry(folder / FILE, remedy(chosen))
    check_case(chosen, mechanism, folder)
    check_options(chosen, mechanism)
    figures = chosen.results / "figures"
    run = None
    if mechanism.static:
        first = 1 if mechanism.kind == "modes" else 0
        motion = of_mode(mechanism, folder, first if chosen.mode is None else chosen.mode)
    else:
        run = read_run(chosen.result or first_result(folder, remedy(chosen)), remedy=remedy(chosen))
        check_columns(run, [*chosen.plot, *chosen.below])
    if chosen.plot:
        path = chosen.out or figures / f"{mechanism.name}_plot.png"
        save(curves(mechanism.name, run, chosen.plot), path)
        return [path]
    if run is not None:
        motion = of_run(mechanism, run)
    look = Look(
        tuple(chosen.view) if chosen.view else None,
        None if chosen.trace is None else tuple(chosen.trace),
        names=chosen.names,
        window=tuple(chosen.window) if chosen.window else None,
    )
    for name in look.traces or ():
        mechanism.anchor(name)
    shown = Shown(mechanism, motion, look)
    if chosen.still:
        path = Path(chosen.still[-1])
        save(still(shown, time_of_still(chosen.still, shown), chosen.strobe), path)
        return [path]
    if mechanism.static and not shown.mode:
        path = chosen.out or figures / f"{mechanism.name}.png"
        save(still(shown, 0.0), path)
        return [path]
    return animation(chosen, shown, run, chosen.out or figures / f"{mechanism.name}.gif")


def check_options(chosen: argparse.Namespace, mechanism: Mechanism) -> None:
    """Complains of options that are no numbers to draw with, or do not fit the case."""
    if chosen.seconds is not None and not 0 < chosen.seconds < np.inf:
        raise TautError(f"--seconds {chosen.seconds:g}: an animation lasts longer than 0 s")
    if chosen.strobe < 0:
        raise TautError(f"--strobe {chosen.strobe}: the number of earlier positions is 0 or more")
    if chosen.window:
        x_1, x_2, y_1, y_2 = chosen.window
        if not (x_1 < x_2 and y_1 < y_2):
            text = " ".join(f"{value:g}" for value in chosen.window)
            raise TautError(f"--window {text}: X1 must be less than X2, and Y1 less than Y2")
    if mechanism.static:
        if chosen.plot or chosen.below or chosen.result:
            raise TautError(
                f"{chosen.case}: its results have no times: it takes no RESULT.csv, --plot or --below"
            )
        if chosen.mode and mechanism.kind != "modes":
            raise TautError(f"--mode {chosen.mode}: {chosen.case} is an equilibrium, without modes")
    elif chosen.mode is not None:
        raise TautError(f"--mode {chosen.mode}: {chosen.case} is a motion over time, without modes")


def remedy(chosen: argparse.Namespace) -> str:
    """Returns how to get results that are missing."""
    return (
        f"run `fpm run mechanism --profile release -- {chosen.case}` first, "
        "or name the folder of its results with --results"
    )


def check_case(chosen: argparse.Namespace, mechanism: Mechanism, folder: Path) -> None:
    """Refuses results of another case; says so if the case file has changed since its run."""
    if zlib.crc32(chosen.case.read_bytes()) == mechanism.checksum:
        return
    if mechanism.name != chosen.case.stem:
        raise TautError(f"{folder} has the results of another case, {mechanism.name}: {remedy(chosen)}")
    print(
        f"animate: {chosen.case} has changed since the run in {folder}, which is what is drawn",
        file=sys.stderr,
    )


def time_of_still(still: list[str], shown: Shown) -> float:
    """Returns the time of a still, which must be one that there is."""
    first, last = float(shown.motion.times[0]), float(shown.motion.times[-1])
    if len(still) > 2:
        raise TautError(f"--still takes [TIME] FILE, not {' '.join(still)}; the case file stands before it")
    if len(still) == 1:
        return last / 4 if shown.mode else last
    try:
        time = float(still[0])
    except ValueError:
        raise TautError(f"--still {still[0]}: the time is no number") from None
    # Times are written and typed with few digits.
    room = 1e-6 * (last - first)
    if not first - room <= time <= last + room:
        what = "the mode's period goes" if shown.mode else "the results go"
        raise TautError(f"--still {still[0]}: {what} from {first:g} to {last:.7g} s")
    return time


def check_columns(run: Run, names: list[str]) -> None:
    """Complains of a column that there is not, and names those that are written alike."""
    for name in names:
        if name not in run.columns:
            alike = get_close_matches(name, run.columns, n=6, cutoff=0.4) or list(run.columns)[:6]
            raise TautError(f"{run.path}: no column '{name}'; there are {', '.join(alike)} and others")


def first_result(folder: Path, remedy: str) -> Path:
    """Returns the table of a case's first method."""
    summary = read_table(folder / "summary.csv", remedy=remedy)
    return folder / f"{summary.column('method')[0]}.csv"


def animation(chosen: argparse.Namespace, shown: Shown, run: Run | None, path: Path) -> list[Path]:
    """Writes a GIF or an MP4, and says how much slower than the motion it is."""
    times = span(shown.motion, chosen.start, chosen.end)
    lasting = times[1] - times[0]
    seconds = chosen.seconds or float(np.clip(lasting, SHORT, LONG))
    pictures = frames(shown, np.linspace(*times, max(round(seconds * RATE), 2)), run, tuple(chosen.below))
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".gif":
        write_gif(pictures, path, 1000 // RATE)
    elif path.suffix == ".mp4":
        write_mp4(pictures, path)
    else:
        raise TautError(f"{path}: an animation is a .gif or an .mp4")
    print(f"{lasting:g} s in {seconds:g} s")
    return [path]


def span(motion: Motion, start: float | None, end: float | None) -> tuple[float, float]:
    """Returns the first and the last time that are shown."""
    first, last = float(motion.times[0]), float(motion.times[-1])
    start, end = first if start is None else max(start, first), last if end is None else min(end, last)
    if not start < end:
        raise TautError(
            f"there is nothing between {start:g} and {end:g} s; the results go from {first:g} to {last:g} s"
        )
    return start, end


def write_mp4(pictures: Iterable[Figure], path: Path) -> None:
    """Writes a film, for which ffmpeg must be installed."""
    if not shutil.which("ffmpeg"):
        raise TautError(f"{path}: an .mp4 needs the program ffmpeg: install it, or write a .gif")
    writer = FFMpegWriter(fps=RATE, bitrate=2400)
    for i, figure in enumerate(pictures):
        if i == 0:
            writer.setup(figure, str(path), dpi=160)
        writer.grab_frame()
    writer.finish()
    plt.close(figure)


def save(figure: Figure, path: Path) -> None:
    """Writes a picture."""
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        style.save(figure, path)
    except ValueError as error:
        raise TautError(f"{path}: {error}") from None
