"""Closed forms of three problems, how far a run is off them, and what examples print."""

import numpy as np

from taut.report.pendulum.measures import GRAVITY
from taut.results import Array, Results, Run

# As in the case file rolling_disc: the center's circle [m] and the rate of turning [rad/s].
TURNING_RATE = 2.0
ROLLING_RADIUS = 1.804602046916743 / TURNING_RATE
CENTER = -0.25 - ROLLING_RADIUS
# As in the case file slider_crank: crank and rod [m], the crank's rate [rad/s].
CRANK, ROD, CRANK_RATE = 0.1, 0.3, 10.0


def circle_error(run: Run) -> float:
    """Returns how far the disc's center is from where steady rolling takes it, at most [m]."""
    angle = TURNING_RATE * run["t"]
    x = CENTER + ROLLING_RADIUS * np.cos(angle)
    return float(np.max(np.hypot(run["disc.x"] - x, run["disc.y"] - ROLLING_RADIUS * np.sin(angle))))


def slider_error(run: Run) -> float:
    """Returns how far the slider is from r cos(w t) + sqrt(l^2 - r^2 sin^2(w t)), at most [m]."""
    angle = CRANK_RATE * run["t"]
    x = CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    return float(np.max(np.abs(run["slider.x"] - x)))


def rates(t: Array, values: Array) -> Array:
    """Returns the derivative at each inner time, by the polynomial through it and two to either side."""
    n = len(t) - 4
    near = np.array([t[i : i + n] for i in range(5)])
    at = near[2]
    slope = np.zeros(n)
    for j in range(5):
        others = [m for m in range(5) if m != j]
        span = np.prod([near[j] - near[m] for m in others], axis=0)
        weight = sum(np.prod([at - near[m] for m in others if m != k], axis=0) for k in others) / span
        slope += weight * values[j : j + n]
    return slope


def gaussians(run: Run) -> tuple[Array, Array]:
    """Returns G of Eq. (15), w = 1/s^2, of a pendulum's run, and the least that is allowed [J/s^2].

    Rates are differences of what the run has. What is least follows from the geometry alone: along the rod,
    vdot - a is what b'' = -|v|^2/L asks for, and all the rest can be none.
    """
    x, z, vx, vz = (run[name] for name in ("x", "z", "vx", "vz"))
    inner = slice(2, -2)
    off = np.array(
        [
            rates(run["t"], vx),
            rates(run["t"], vz) + GRAVITY,
            rates(run["t"], x) - vx[inner],
            rates(run["t"], z) - vz[inner],
        ]
    )
    length = np.hypot(x, z)[inner]
    given = -(vx**2 + vz**2)[inner] / length - (-GRAVITY * z[inner] / length)
    return 0.5 * np.sum(off**2, axis=0), 0.5 * given**2


def integrators(results: Results, name: str) -> list[dict[str, str]]:
    """Returns the rows of the table that an example prints in which the two calls serve an integrator."""
    lines = results.printed(name)
    columns = ("steps", "rhs", "jacobian", "time", "phi", "phidot", "phiddot", "error")
    rows = []
    for line in lines[1:]:
        problem, *words = line.split()
        integrator = " ".join(words[: -len(columns)])
        row = dict(zip(columns, words[-len(columns) :], strict=True))
        rows.append({"problem": problem, "integrator": integrator} | row)
    return rows
