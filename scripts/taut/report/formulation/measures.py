"""Closed forms of the rolling disc and of the slider-crank, and how far a run is off them."""

import numpy as np

from taut.results import Run

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
