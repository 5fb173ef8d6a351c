"""The pendulum's closed form, and what is measured on a run to compare with it and with the paper."""

import math

import numpy as np

from taut.results import Array, Run

# The problem as the paper states it: m = 1 kg, L = 1 m, g = 9.81 m/s^2, at rest at {x, z} = {1, 0}.
MASS = 1.0
LENGTH = 1.0
GRAVITY = 9.81
# The paper's reference: potential and kinetic energy change by m g L during a swing [J].
ENERGY_SCALE = MASS * GRAVITY * LENGTH


def elliptic_k(k: float) -> float:
    """Returns the complete elliptic integral of the first kind of modulus k (arithmetic-geometric mean)."""
    a, b = 1.0, math.sqrt(1.0 - k * k)
    while abs(a - b) > 1e-15 * a:
        a, b = (a + b) / 2.0, math.sqrt(a * b)
    return math.pi / (a + b)


# Released from the horizontal, the modulus is sin(90 deg / 2).
PERIOD = 4.0 * elliptic_k(math.sqrt(0.5)) * math.sqrt(LENGTH / GRAVITY)
MAX_TENSION = 3.0 * MASS * GRAVITY


def crossings(run: Run) -> Array:
    """Returns the times at which the mass passes under the pivot."""
    t, x, v = run["t"], run["x"], run["vx"]
    times = []
    for i in np.flatnonzero(x[:-1] * x[1:] < 0.0):
        h = t[i + 1] - t[i]
        # The cubic through both ends with their velocities, in powers of s from 0 to 1.
        d0, d1, rise = h * v[i], h * v[i + 1], x[i + 1] - x[i]
        roots = np.roots([d0 + d1 - 2 * rise, 3 * rise - 2 * d0 - d1, d0, x[i]])
        inside = [r.real for r in roots if abs(r.imag) < 1e-9 and -1e-9 <= r.real <= 1 + 1e-9]
        times.append(t[i] + h * inside[0])
    return np.array(times)


def period(run: Run) -> float:
    """Returns the period: twice the mean time between two passages under the pivot [s]."""
    times = crossings(run)
    return 2.0 * float(times[-1] - times[0]) / (len(times) - 1) if len(times) > 1 else math.nan


def tension_error(run: Run) -> float:
    """Returns the largest difference between the multiplier and 3 m g sin(angle below the horizontal) [N]."""
    return float(np.max(np.abs(run["lambda"] + MAX_TENSION * run["z"] / LENGTH)))


def energy_change(run: Run) -> float:
    """Returns the energy at the end less that at the start [J]."""
    return float(run["energy"][-1] - run["energy"][0])


def energy_per_period(run: Run) -> float:
    """Returns the energy change in one period, that of the period in which it is largest [J]."""
    whole = np.arange(0.0, float(run["t"][-1]) + 1e-9, PERIOD)
    if len(whole) < 2:
        return energy_change(run)
    changes = np.diff(np.interp(whole, run["t"], run["energy"]))
    return float(changes[np.argmax(np.abs(changes))])


def end_distance(run: Run, other: Run) -> float:
    """Returns how far apart two runs end [m]."""
    return math.hypot(*(float(run[c][-1] - other[c][-1]) for c in ("x", "z")))
