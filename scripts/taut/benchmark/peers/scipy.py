"""SciPy's RK45 and DOP853, Radau and BDF where it is stiff, on Sect. 3.5 with every stage projected."""

import math
import time
from collections.abc import Callable, Sequence

import numpy as np
import scipy as installed
from scipy.integrate import solve_ivp
from scipy.linalg import solve_banded

from taut.benchmark.entrant import Array, Entrant, Peer, Problem, Run
from taut.benchmark.peers.program import PATIENCE, TookTooLongError
from taut.benchmark.problems import andrews, bricard, car_axis, heavy_top, swing
from taut.benchmark.problems.projected import TOLERANCE, Rates, System, solve
from taut.errors import TautError

GRAVITY = 9.81
METHODS = ("RK45", "DOP853")
# On problems with stiff springs.
STIFF = ("RK45", "Radau", "BDF")


def pendulum(_size: int) -> System:
    """Returns start, rates and projection, in plain Python numbers: faster here than arrays of two."""

    def projected(y: Sequence[float]) -> tuple[float, float, float, float, float]:
        x, z, vx, vz = (float(value) for value in y)
        while True:
            length = math.hypot(x, z)
            excess = length - 1.0
            if abs(excess) <= TOLERANCE:
                break
            x -= x / length * excess
            z -= z / length * excess
        nx, nz = x / length, z / length
        mu = nx * vx + nz * vz
        return x, z, vx - nx * mu, vz - nz * mu, length

    def rates(_time: float, y: Array) -> tuple[float, float, float, float]:
        x, z, vx, vz, length = projected(y)
        nx, nz = x / length, z / length
        tension = -nz * GRAVITY + (x * vz - z * vx) ** 2 / length**3
        return vx, vz, -nx * tension, -GRAVITY - nz * tension

    return np.array([1.0, 0.0, 0.0, 0.0]), rates, lambda y: np.array(projected(y)[:4])


def chain(size: int) -> System:
    """Returns start, rates and projection of the chain; S is tridiagonal, so that a solution costs O(n)."""
    bands = np.empty((3, size))
    bands[1] = 2.0
    bands[1, 0] = 1.0
    support = np.zeros((1, 2))

    def rods(place: Array) -> tuple[Array, Array]:
        along = np.diff(place, axis=0, prepend=support)
        length = np.hypot(along[:, 0], along[:, 1])
        return along / length[:, None], length

    def solve(unit: Array, right: Array) -> Array:
        cosine = np.einsum("ij,ij->i", unit[1:], unit[:-1])
        bands[0, 1:] = bands[2, :-1] = -cosine
        return solve_banded((1, 1), bands, right, check_finite=False)

    def spread(unit: Array, tension: Array) -> Array:
        """Returns A^T times the tensions."""
        pull = unit * tension[:, None]
        pull[:-1] -= pull[1:]
        return pull

    def projected(y: Array) -> tuple[Array, Array, Array, Array]:
        place, speed = y[: 2 * size].reshape(size, 2), y[2 * size :].reshape(size, 2)
        unit, length = rods(place)
        limit = max(TOLERANCE, 4 * np.spacing(abs(place).max()))
        for _ in range(25):
            if abs(length - 1.0).max() <= limit:
                break
            place = place - spread(unit, solve(unit, length - 1.0))
            unit, length = rods(place)
        drift = np.einsum("ij,ij->i", unit, np.diff(speed, axis=0, prepend=support))
        return place, speed - spread(unit, solve(unit, drift)), unit, length

    def rates(_time: float, y: Array) -> Array:
        _, speed, unit, length = projected(y)
        away = np.diff(speed, axis=0, prepend=support)
        across = unit[:, 0] * away[:, 1] - unit[:, 1] * away[:, 0]
        # Gravity cancels between neighbors, but not at the fixed end.
        right = across * across / length
        right[0] -= GRAVITY * unit[0, 1]
        pull = spread(unit, solve(unit, right))
        acceleration = -pull
        acceleration[:, 1] -= GRAVITY
        return np.concatenate((speed.ravel(), acceleration.ravel()))

    start = np.zeros(4 * size)
    start[0 : 2 * size : 2] = np.arange(1, size + 1)
    return start, rates, lambda y: np.concatenate([part.ravel() for part in projected(y)[:2]])


def four_bar(size: int) -> System:
    """Returns start, rates and projection of the loops: two points a rod, its exact mass matrix, dense."""
    points = size + 1
    ground = np.column_stack((np.arange(points), np.zeros(points)))
    mass = np.diag(np.full(points, 1.0))
    # A crank brings 1/3 to its free end, a rod 1/6 [2 1; 1 2] to its two ends.
    mass[0, 0] = mass[-1, -1] = 2 / 3
    mass += np.diag(np.full(size, 1 / 6), 1) + np.diag(np.full(size, 1 / 6), -1)
    inverse = np.kron(np.linalg.inv(mass), np.eye(2))
    weight = np.zeros((points, 2))
    weight[:, 1] = -1.5 * GRAVITY
    weight[0, 1] = weight[-1, 1] = -GRAVITY
    free = inverse @ weight.ravel()

    def rods(place: Array) -> tuple[Array, Array]:
        along = np.concatenate((place - ground, np.diff(place, axis=0)))
        length = np.hypot(along[:, 0], along[:, 1])
        return along / length[:, None], length

    crank, rod = np.arange(points), np.arange(size)

    def jacobian(unit: Array) -> Array:
        a = np.zeros((2 * size + 1, points, 2))
        a[crank, crank] = unit[:points]
        a[points + rod, rod] = -unit[points:]
        a[points + rod, rod + 1] = unit[points:]
        return a.reshape(2 * size + 1, 2 * points)

    def projected(y: Array) -> tuple[Array, Array, Array, Array, Array]:
        place, speed = y[: 2 * points].reshape(points, 2), y[2 * points :]
        for _ in range(25):
            unit, length = rods(place)
            a = jacobian(unit)
            if abs(length - 1.0).max() <= TOLERANCE:
                break
            place = place - (a.T @ solve(a @ a.T, length - 1.0)).reshape(points, 2)
        speed = speed - a.T @ solve(a @ a.T, a @ speed)
        return place, speed, unit, length, a

    def rates(_time: float, y: Array) -> Array:
        _, speed, unit, length, a = projected(y)
        v = speed.reshape(points, 2)
        away = np.concatenate((v, np.diff(v, axis=0)))
        across = unit[:, 0] * away[:, 1] - unit[:, 1] * away[:, 0]
        s = a @ inverse @ a.T
        right = a @ free + across * across / length
        return np.concatenate((speed, free - inverse @ (a.T @ solve(s, right))))

    start = np.zeros((2, points, 2))
    start[0] = ground
    start[0, :, 1] = 1.0
    start[1, :, 0] = 1.0
    return start.ravel(), rates, lambda y: np.concatenate([part.ravel() for part in projected(y)[:2]])


def spring(size: int) -> System:
    """Returns start and rates of a mass on a spring of 10^size N/m; there is nothing to project on."""
    stiffness = 10.0**size

    def rates(_time: float, y: Array) -> tuple[float, float, float, float]:
        x, z, vx, vz = (float(value) for value in y)
        length = math.hypot(x, z)
        pull = stiffness * (length - 1.0) / length
        return vx, vz, -pull * x, -GRAVITY - pull * z

    return np.array([1.0, 0.0, 0.0, 0.0]), rates, lambda y: y


SYSTEMS: dict[str, Callable[[int], System]] = {
    "pendulum": pendulum,
    "chain": chain,
    "four-bar": four_bar,
    "spring": spring,
    "heavy_top": heavy_top.system,
    "andrews": andrews.system,
    "bricard": bricard.system,
    "car-axis": car_axis.system,
    "swing": swing.system,
}


def patient(rates: Rates) -> Rates:
    """Returns rates that give up when as much time has passed as a program is given."""
    end = time.process_time() + PATIENCE

    def limited(t: float, y: Array) -> Sequence[float] | Array:
        if time.process_time() > end:
            raise TookTooLongError(f"SciPy took longer than {PATIENCE} s")
        return rates(t, y)

    return limited


def entrants(problem: Problem, size: int) -> Sequence[Entrant]:
    """Returns one entrant for each of SciPy's methods."""
    if problem.name not in SYSTEMS:
        return []

    def entrant(method: str) -> Entrant:
        def run(rtol: float, seconds: float) -> Run:
            start, rates, project = SYSTEMS[problem.name](size)
            best, spent = math.inf, 0.0
            while True:
                before = time.process_time()
                done = solve_ivp(
                    patient(rates) if problem.stiff else rates,
                    (0.0, problem.t_end),
                    start,
                    method=method,
                    rtol=rtol,
                    atol=problem.atol(rtol),
                    max_step=problem.max_step or math.inf,
                )
                last = project(done.y[:, -1])
                taken = time.process_time() - before
                best, spent = min(best, taken), spent + taken
                if not done.success:
                    raise TautError(f"SciPy {method}: {done.message}")
                if spent >= seconds:
                    return Run(best, len(done.t) - 1, done.nfev, done.njev, last)

        return Entrant(f"SciPy {method}", "scipy", problem.tolerances, run)

    return [entrant(method) for method in (STIFF if problem.stiff else METHODS)]


PEER = Peer("scipy", lambda: installed.__version__, entrants)
