"""The problems, one module each: a new one is a module with a `PROBLEM` and a line here."""

from taut.benchmark.entrant import Problem
from taut.benchmark.problems import (
    andrews,
    bricard,
    car_axis,
    chain,
    four_bar,
    heavy_top,
    pendulum,
    spring,
    swing,
)

PROBLEMS: dict[str, Problem] = {
    module.PROBLEM.name: module.PROBLEM
    for module in (pendulum, chain, four_bar, heavy_top, andrews, bricard, spring, car_axis, swing)
}
