"""The kinematics of the blade, Eqs (28) and (29), and what is measured on a run."""

import numpy as np

from taut.results import Array, Case, Run

Model = dict[str, float]
# Flap decays as exp(-gamma Omega t / 32), within 0.1 s: after 1 s the motion is periodic.
SETTLED = 1.0


def point_a(model: Model, beta: Array, theta: Array) -> Array:
    """Returns the upper end of the pitch link, Eq. (28), in the last index [m]."""
    x, y = model["x_theta"], model["y_theta"]
    cb, sb, ct, st = np.cos(beta), np.sin(beta), np.cos(theta), np.sin(theta)
    return np.stack([model["x_beta"] + x * cb - y * sb * st, y * ct, x * sb + y * cb * st], axis=-1)


def point_b(model: Model, t: Array) -> Array:
    """Returns the lower end of the pitch link, on the swashplate, in the last index [m]."""
    angle = model["omega"] * np.asarray(t)
    return np.stack(
        [
            model[f"{i}_b"] + model[f"b_cosine_{i}"] * np.cos(angle) + model[f"b_sine_{i}"] * np.sin(angle)
            for i in "xyz"
        ],
        axis=-1,
    )


def violation(model: Model, run: Run) -> tuple[Array, Array]:
    """Returns phi [m], Eq. (29), and its rate [m/s] with their signs; the swashplate is at rest."""
    beta, theta, p, q = (run[name] for name in ("beta", "theta", "beta_rate", "theta_rate"))
    x, y = model["x_theta"], model["y_theta"]
    cb, sb, ct, st = np.cos(beta), np.sin(beta), np.cos(theta), np.sin(theta)
    link = point_a(model, beta, theta) - point_b(model, run["t"])
    length = np.linalg.norm(link, axis=-1)
    by_beta = np.stack([-x * sb - y * cb * st, 0 * sb, x * cb - y * sb * st], axis=-1)
    by_theta = np.stack([-y * sb * ct, -y * st, y * cb * ct], axis=-1)
    speed = by_beta * p[:, None] + by_theta * q[:, None]
    return length - model["length"], (link * speed).sum(axis=-1) / length


def fill(run: Run, angle: str, pieces: int = 12) -> tuple[Array, Array, Array]:
    """Returns time, angle and rate, each step filled in by the cubic that has its end values and rates."""
    t, x, v = run["t"], run[angle], run[f"{angle}_rate"]
    s = np.linspace(0.0, 1.0, pieces, endpoint=False)[None, :]
    h = np.diff(t)[:, None]
    value = x[:-1, None] * (1 + 2 * s) * (1 - s) ** 2 + x[1:, None] * s**2 * (3 - 2 * s)
    value = value + h * (v[:-1, None] * s * (1 - s) ** 2 - v[1:, None] * s**2 * (1 - s))
    rate = 6 * s * (1 - s) * (x[1:, None] - x[:-1, None]) / h
    rate = rate + v[:-1, None] * (1 - s) * (1 - 3 * s) + v[1:, None] * s * (3 * s - 2)
    time = t[:-1, None] + h * s
    return tuple(np.append(a.ravel(), end) for a, end in ((time, t[-1]), (value, x[-1]), (rate, v[-1])))


def fitted(model: Model, run: Run, column: str, count: int = 5) -> tuple[float, Array, Array]:
    """Returns mean, cosines and sines of multiples of the rotor speed in a column after the start."""
    late = run["t"] > SETTLED
    angle = model["omega"] * run["t"][late][:, None] * np.arange(1, count + 1)
    basis = np.hstack([np.ones((len(angle), 1)), np.cos(angle), np.sin(angle)])
    found = np.linalg.lstsq(basis, run[column][late], rcond=None)[0]
    return float(found[0]), found[1 : count + 1], found[count + 1 :]


def harmonics(model: Model, run: Run, column: str) -> Array:
    """Returns the amplitudes of once, twice, ... per revolution in a column after the start."""
    _, cosine, sine = fitted(model, run, column)
    return np.hypot(cosine, sine)


def third_harmonic(model: Model, flap: float) -> float:
    """Returns the third harmonic of the link's force for a flap of this amplitude, to the third order [N].

    The link is vertical at rest, so that sin(theta) = -K_p tan(beta) up to the fourth order: theta has no
    second harmonic, and its third is amplified by the blade's own frequency of once per revolution, 1 - 3^2.
    """
    k_p = model["k_p"]
    pitch = k_p * (1 / 3 + k_p**2 / 6) * flap**3 / 4
    return 8 * model["i_f"] * model["omega"] ** 2 * pitch / model["y_theta"]


def dominant_frequency(model: Model, run: Run) -> float:
    """Returns the frequency at which the violation oscillates [rad/s], by least squares on uneven steps."""
    value, _ = violation(model, run)
    frequencies = np.linspace(1.5, 25.0, 2351) * model["omega"]
    angle = frequencies[:, None] * run["t"]
    power = np.abs((np.exp(1j * angle) * ((value - value.mean()) * np.gradient(run["t"]))).sum(axis=1))
    return float(frequencies[np.argmax(power)])


def drift(model: Model, run: Run) -> tuple[float, float, float]:
    """Returns the mean violation in the first and in the last fifth of a run, and its largest size [m]."""
    value, _ = violation(model, run)
    t = run["t"]
    weight = np.gradient(t)
    parts = t <= t[-1] / 5, t >= 0.8 * t[-1]
    first, last = (float((value * weight)[part].sum() / weight[part].sum()) for part in parts)
    return first, last, float(np.abs(value).max())


def largest(run: Run, column: str, after: float = 0.0) -> float:
    """Returns the largest size of a column from a time on."""
    return float(np.abs(run[column][run["t"] >= after]).max())


def tries(case: Case, method: str) -> int:
    """Returns the accepted steps and the rejected tries together."""
    return case.steps(method) + int(case.number(method, "rejected"))
