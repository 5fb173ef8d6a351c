"""The problems, one module each: a new one is a module with a `PROBLEM` and a line here."""

from taut.benchmark.entrant import Problem
from taut.benchmark.problems import chain, four_bar, pendulum, spring, swing

PROBLEMS: dict[str, Problem] = {
    problem.name: problem
    for problem in (pendulum.PROBLEM, chain.PROBLEM, four_bar.PROBLEM, spring.PROBLEM, swing.PROBLEM)
}
