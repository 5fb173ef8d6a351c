"""The swing's dimensions, its markers, and what is measured on a run to compare it with others."""

import math

import numpy as np

from taut.bootstrap import ROOT
from taut.errors import TautError
from taut.results import Array, Results, Run, read_run

MARKERS = "ABCDE"
# Length of the beam [m]; where its markers are; where the links are pinned to the ground, and their lengths.
BEAM = 0.72
START = np.array([[BEAM * i / 4, 0.0] for i in range(5)])
SUPPORTS = np.array([[0.0, 0.36], [1.08, 0.36]])
LINKS = np.array([0.36, 0.36 * np.sqrt(2.0)])
# The load: a triangle over time [N, s].
FORCE, RISE, PULSE = 2.0, 0.128, 0.256
# The motion is regular up to here: what is compared with the reference ends before the event [s].
BEFORE = 0.6
# The curves of analysis (0) by another program, and how far they can be trusted up to then [m].
REFERENCES = tuple(ROOT / "cases" / "swing" / "data" / f"mbdyn_{n}x3node.csv" for n in (2, 4))
TRUSTED = 1e-5


def reference(elements: int = 4) -> Run:
    """Returns the motion of analysis (0) by MBDyn with 2 or 4 three-node elements."""
    return read_run(REFERENCES[0 if elements == 2 else 1])


def analysis_0(results: Results, elements: int) -> Run:
    """Returns taut's analysis (0), with so many two-node elements."""
    return results.case(f"0_{elements}x").run("present")


def positions(run: Run) -> Array:
    """Returns x and y of the markers: one row a time, then one a marker [m]."""
    return np.stack([np.stack([run[f"{m}x"], run[f"{m}y"]], axis=-1) for m in MARKERS], axis=1)


def sample(t: Array, values: Array, times: Array) -> Array:
    """Returns values at times between, by cubics whose slopes are those of parabolas through three points."""
    keep = np.concatenate([[True], np.diff(t) > 0])
    t, values = t[keep], values[keep]
    slopes = np.gradient(values, t, axis=0, edge_order=min(2, len(t) - 1))
    i = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    shape = (-1,) + (1,) * (values.ndim - 1)
    h = (t[i + 1] - t[i]).reshape(shape)
    s = (times - t[i]).reshape(shape) / h
    found = values[i] * (1 + 2 * s) * (1 - s) ** 2 + values[i + 1] * s**2 * (3 - 2 * s)
    return found + h * (slopes[i] * s * (1 - s) ** 2 - slopes[i + 1] * s**2 * (1 - s))


def distances(run: Run, other: Run, step: float = 1e-3) -> tuple[Array, Array]:
    """Returns times and how far apart the markers of two runs are: one row a time, one column a marker."""
    # Neither run is known beyond its end.
    last = min(float(run["t"][-1]), float(other["t"][-1]))
    times = step * np.arange(int(last / step + 1e-6) + 1)
    ends = [sample(r["t"], positions(r), times) for r in (run, other)]
    return times, np.linalg.norm(ends[0] - ends[1], axis=-1)


def apart(run: Run, other: Run, start: float = 0.0, end: float = np.inf) -> float:
    """Returns how far apart two runs come in an interval, at the marker where it is most [m]."""
    times, distance = distances(run, other)
    return float(distance[(times >= start - 1e-9) & (times <= end + 1e-9)].max())


def paths_apart(path: Array, other: Array) -> float:
    """Returns how far a path goes from another one, whatever the times at which they are passed [m]."""
    start, along = other[:-1], np.diff(other, axis=0)
    length = np.maximum((along**2).sum(axis=1), 1e-300)
    most = 0.0
    for point in path:
        way = point - start
        part = np.clip(np.einsum("ij,ij->i", way, along) / length, 0.0, 1.0)
        way -= part[:, None] * along
        most = max(most, float(np.einsum("ij,ij->i", way, way).min()))
    return math.sqrt(most)


def violations(run: Run, column: str, end: float = np.inf) -> float:
    """Returns the largest size of a violation up to a time."""
    return float(np.abs(run[column][run["t"] <= end]).max())


def energy_kept(run: Run) -> tuple[float, float]:
    """Returns the energy when the load has ended, and at the end of the run [J]."""
    return float(run["energy"][np.searchsorted(run["t"], PULSE + 1e-9)]), float(run["energy"][-1])


def peak_tension(run: Run, start: float = 0.0, end: float = np.inf) -> tuple[float, float]:
    """Returns the largest force of the first link in an interval [N], and when it acts [s]."""
    inside = np.flatnonzero((run["t"] >= start) & (run["t"] <= end))
    place = inside[np.argmax(np.abs(run["lambda1"][inside]))]
    return float(abs(run["lambda1"][place])), float(run["t"][place])


def events(results: Results, name: str) -> dict[str, float]:
    """Returns when the first link is in line, by event; the first time counts, and there may be none."""
    if not results.has(name) or not (results.case(name).folder / "events.csv").is_file():
        return {}
    table = results.case(name).table("events.csv")
    found: dict[str, float] = {}
    try:
        for event, t in zip(table["event"], table["t"], strict=True):
            found[event] = min(float(t), found.get(event, np.inf))
    except (KeyError, ValueError):
        raise TautError(f"{results.case(name).folder / 'events.csv'}: no columns event and t") from None
    return found


def event_time(results: Results, *names: str) -> float | None:
    """Returns when link 1 comes in line with A-C in the first of some cases that tells [s]."""
    return next((found["link-AC"] for name in names if "link-AC" in (found := events(results, name))), None)


def largest_in_pieces(t: Array, values: Array, pieces: int = 500) -> tuple[Array, Array]:
    """Returns the largest size in each of so many intervals, placed at their middles."""
    if len(t) <= pieces:
        return t, np.abs(values)
    edges = np.linspace(t[0], t[-1], pieces + 1)
    index = np.clip(np.searchsorted(edges, t, side="right") - 1, 0, pieces - 1)
    found = np.full(pieces, -np.inf)
    np.maximum.at(found, index, np.abs(values))
    filled = np.isfinite(found)
    return ((edges[:-1] + edges[1:]) / 2)[filled], found[filled]


# The modes of Table 1: what the paper calls them, how they are told apart, and its frequencies [Hz].
TABLE_1 = (
    ("First symmetric bending", "bending", "symmetric", 1, "0.443"),
    ("First antisymmetric bending", "bending", "antisymmetric", 1, "18.17"),
    ("Second symmetric bending", "bending", "symmetric", 2, "28.46"),
    ("First antisymmetric axial", "axial", "antisymmetric", 1, "319.5"),
)


def modes(results: Results, case: str = "table1") -> list[tuple[int, float]]:
    """Returns number and frequency [Hz] of each mode of Table 1."""
    table = results.case(case).table("frequencies.csv")
    rows = list(zip(table["mode"], table["frequency"], table["motion"], table["symmetry"], strict=True))
    found = []
    for _, motion, symmetry, rank, _ in TABLE_1:
        alike = [(int(number), float(f)) for number, f, *kind in rows if kind == [motion, symmetry]]
        found.append(alike[rank - 1] if len(alike) >= rank else (0, np.nan))
    return found


def strain_energies(results: Results, name: str) -> tuple[Array, Array]:
    """Returns t and the energy with which each mode of Table 1 strains the beam: (modes, points) [J].

    Modes have unit mass: q^2 omega^2/2.
    """
    run = results.case(name).run("present")
    rates = [2 * np.pi * frequency for _, frequency in modes(results)]
    return run["t"], np.array([(rate * run[f"q{i}"]) ** 2 / 2 for i, rate in enumerate(rates, start=1)])


def mode_shape(results: Results, mode: int, column: str) -> tuple[Array, Array]:
    """Returns x [m] and a column of a mode's shape, scaled to a largest value of one, positive at first."""
    table = results.case("table1").table("shapes.csv")
    chosen = [i for i, number in enumerate(table["mode"]) if int(number) == mode]
    x, u = (np.array([float(table[name][i]) for i in chosen]) for name in ("x", column))
    first = u[np.abs(u) > 1e-3 * np.abs(u).max()][0]
    return x, u / np.abs(u).max() * np.sign(first)


def static_shape(x: Array, motion: str) -> Array:
    """Returns what a load at mid-span does to the beam, scaled to one: a cubic, or a triangle."""
    s = np.minimum(x, BEAM - x) / BEAM
    return 2 * s if motion == "axial" else 3 * s - 4 * s**3


def highest_frequency(results: Results, case: str = "free_free") -> float | None:
    """Returns the highest frequency of the free beam of the FE model [Hz], if it has been solved for."""
    if not results.has(case):
        return None
    return max(float(f) for f in results.case(case).table("frequencies.csv")["frequency"])


def links(points: Array) -> tuple[Array, Array]:
    """Returns both links as lines from the support to the end of the beam."""
    return np.stack([SUPPORTS[0], points[0]]), np.stack([SUPPORTS[1], points[-1]])
