"""Exudyn's generalized-alpha of index 3, called from Python: mass points on rods or a spring."""

import time
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as version_of

import numpy as np

from taut.benchmark.entrant import Array, Entrant, Peer, Problem, Run
from taut.errors import TautError

PACKAGE = "exudyn"
EXUDYN = "1.13.6"
GRAVITY = 9.81
# Steps [s] in the place of tolerances.
STEPS = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5)
# Damping of what is not resolved, the least with which all problems come to their end, and where Newton's
# iteration ends: positions are good to 1e-12 m.
SPECTRAL_RADIUS = 0.99
RELATIVE, ABSOLUTE = 1e-10, 1e-12
# From so many masses on its sparse solver is faster than the dense one.
SPARSE = 10


def version() -> str | None:
    """Returns the installed version, or None."""
    try:
        return version_of(PACKAGE)
    except PackageNotFoundError:
        return None


def integrate(problem: Problem, size: int, step: float) -> Run:
    """Returns one run; its numbers of right-hand sides are those of Newton's iterations."""
    import exudyn as exu
    from exudyn import itemInterface as items

    masses = 1 if problem.name == "spring" else size
    system = exu.SystemContainer().AddSystem()
    ground = system.AddObject(items.ObjectGround())
    before = system.AddMarker(items.MarkerBodyPosition(bodyNumber=ground))
    nodes = []
    for i in range(masses):
        nodes.append(system.AddNode(items.NodePoint2D(referenceCoordinates=[i + 1.0, 0.0])))
        system.AddObject(items.ObjectMassPoint2D(physicsMass=1.0, nodeNumber=nodes[i]))
        marker = system.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[i]))
        system.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=[0.0, -GRAVITY, 0.0]))
        between = {"markerNumbers": [before, marker]}
        if problem.name == "spring":
            stiff = {"referenceLength": 1.0, "stiffness": 10.0**size}
            system.AddObject(items.ObjectConnectorSpringDamper(**between, **stiff))
        else:
            system.AddObject(items.ObjectConnectorDistance(**between, distance=1.0))
        before = marker
    system.Assemble()

    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime = problem.t_end
    integration.numberOfSteps = round(problem.t_end / step)
    integration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance = RELATIVE
    integration.newton.absoluteTolerance = ABSOLUTE
    integration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.parallel.numberOfThreads = 1
    kinds = exu.LinearSolverType
    settings.linearSolverType = kinds.EigenSparse if masses > SPARSE else kinds.EXUdense

    start = time.process_time()
    try:
        done = system.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
    except ValueError as error:
        raise TautError(f"Exudyn: {error}") from error
    taken = time.process_time() - start
    if not done:
        raise TautError("Exudyn: the integration failed")
    kind = exu.OutputVariableType
    state = [
        system.GetNodeOutput(node, which)[:2] for which in (kind.Position, kind.Velocity) for node in nodes
    ]
    count = system.sys["dynamicSolver"].it
    return Run(
        taken, integration.numberOfSteps, count.newtonStepsCount, count.newtonJacobiCount, joined(state)
    )


def joined(parts: Sequence[Array]) -> Array:
    """Returns the parts as one state, all of it numbers."""
    state = np.concatenate(parts)
    if not np.isfinite(state).all():
        raise TautError("Exudyn: the positions are no numbers")
    return state


def entrants(problem: Problem, size: int) -> Sequence[Entrant]:
    """Returns Exudyn with its steps, for mass points on rods and on a spring."""
    if problem.name not in ("pendulum", "chain", "spring"):
        return []

    def run(step: float, seconds: float) -> Run:
        best, spent = None, 0.0
        while best is None or spent < seconds:
            one = integrate(problem, size, step)
            spent += one.seconds
            if best is None or one.seconds < best.seconds:
                best = one
        return best

    return [Entrant("Exudyn, generalized-alpha", "exudyn", STEPS, run)]


PEER = Peer("exudyn", version, entrants, pypi=(f"{PACKAGE}=={EXUDYN}",))
