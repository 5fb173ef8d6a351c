"""Exudyn's generalized-alpha of index 3, called from Python: mass points on rods or a spring, the swing."""

import time
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as version_of
from itertools import pairwise
from typing import Any

import numpy as np

from taut.benchmark.entrant import Array, Entrant, Peer, Problem, Run
from taut.benchmark.problems.swing import (
    BEAM,
    DENSITY,
    FORCE,
    LINKS,
    MID_MASS,
    POISSON,
    RISE,
    THICKNESS,
    WIDTH,
    YOUNG,
)
from taut.errors import TautError

PACKAGE = "exudyn"
EXUDYN = "1.13.6"
GRAVITY = 9.81
# Steps [s] in the place of tolerances.
STEPS = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5)
# Damping of what is not resolved, the least with which all problems come to their end, and where Newton's
# iteration ends: positions are good to 1e-12 m.
SPECTRAL_RADIUS = 0.99
RELATIVE, ABSOLUTE, ABSOLUTE_BEAM = 1e-10, 1e-12, 1e-6
# From so many masses on its sparse solver is faster than the dense one.
SPARSE = 10


def version() -> str | None:
    """Returns the installed version, or None."""
    try:
        return version_of(PACKAGE)
    except PackageNotFoundError:
        return None


def points(system: Any, items: Any, problem: Problem, size: int) -> list[Any]:
    """Adds mass points on rods or on a spring, and returns their nodes."""
    before = system.AddMarker(items.MarkerBodyPosition(bodyNumber=system.AddObject(items.ObjectGround())))
    nodes = []
    for i in range(1 if problem.name == "spring" else size):
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
    return nodes


def beam(system: Any, items: Any, _problem: Problem, size: int) -> list[Any]:
    """Adds the swing of two-node elements with the shear stiffness of taut's; returns the markers' nodes."""
    length, area, second = BEAM / size, THICKNESS * WIDTH, WIDTH * THICKNESS**3 / 12
    shear = 5 / 6 * YOUNG / (2 * (1 + POISSON)) * area
    section = {
        "length": length,
        "massPerLength": DENSITY * area,
        "crossSectionInertia": DENSITY * second,
        "bendingStiffness": YOUNG * second,
        "axialStiffness": YOUNG * area,
        "shearStiffness": 1 / (1 / shear + length**2 / (12 * YOUNG * second)),
    }
    ground = system.AddObject(items.ObjectGround())
    nodes = [
        system.AddNode(items.NodeRigidBody2D(referenceCoordinates=[length * i, 0.0, 0.0]))
        for i in range(size + 1)
    ]
    for pair in pairwise(nodes):
        system.AddObject(items.ObjectBeamGeometricallyExact2D(nodeNumbers=list(pair), **section))
    middle = nodes[size // 2]
    system.AddObject(items.ObjectRigidBody2D(nodeNumber=middle, mass=MID_MASS, inertia=0.0))
    for node, (support, far) in zip((nodes[0], nodes[-1]), LINKS, strict=True):
        fixed = items.MarkerBodyPosition(bodyNumber=ground, localPosition=[*support, 0.0])
        ends = [system.AddMarker(fixed), system.AddMarker(items.MarkerNodePosition(nodeNumber=node))]
        system.AddObject(items.ObjectConnectorDistance(markerNumbers=ends, distance=far))
    marker = system.AddMarker(items.MarkerNodePosition(nodeNumber=middle))

    def pulse(_system: Any, t: float, load: list[float]) -> list[float]:
        return [max(0.0, 1 - abs(t / RISE - 1)) * one for one in load]

    load = {"loadVector": [FORCE, 0.0, 0.0], "loadVectorUserFunction": pulse}
    system.AddLoad(items.LoadForceVector(markerNumber=marker, **load))
    return nodes[:: size // 4]


def integrate(problem: Problem, size: int, step: float) -> Run:
    """Returns one run; its numbers of right-hand sides are those of Newton's iterations."""
    import exudyn as exu
    from exudyn import itemInterface as items

    system = exu.SystemContainer().AddSystem()
    swing = problem.name == "swing"
    nodes = (beam if swing else points)(system, items, problem, size)
    system.Assemble()

    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime = problem.t_end
    integration.numberOfSteps = round(problem.t_end / step)
    integration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance = RELATIVE
    # Of an axial force of 3.7e5 N per unit strain less is round-off.
    integration.newton.absoluteTolerance = ABSOLUTE_BEAM if swing else ABSOLUTE
    integration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.parallel.numberOfThreads = 1
    kinds = exu.LinearSolverType
    settings.linearSolverType = (
        kinds.EigenSparse if system.systemData.NumberOfNodes() > SPARSE else kinds.EXUdense
    )

    start = time.process_time()
    try:
        done = system.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
    except (ValueError, exu.SolverError) as error:
        raise TautError(f"Exudyn: {error}") from error
    taken = time.process_time() - start
    if not done:
        raise TautError("Exudyn: the integration failed")
    kind = exu.OutputVariableType
    told = (kind.Position,) if swing else (kind.Position, kind.Velocity)
    state = [system.GetNodeOutput(node, which)[:2] for which in told for node in nodes]
    count = system.sys["dynamicSolver"].it
    return Run(
        taken, int(integration.numberOfSteps), count.newtonStepsCount, count.newtonJacobiCount, joined(state)
    )


def joined(parts: Sequence[Array]) -> Array:
    """Returns the parts as one state, all of it numbers."""
    state = np.concatenate(parts)
    if not np.isfinite(state).all():
        raise TautError("Exudyn: the positions are no numbers")
    return state


def entrants(problem: Problem, size: int) -> Sequence[Entrant]:
    """Returns Exudyn with its steps, for mass points on rods and on a spring, and for the swing."""
    if problem.name not in ("pendulum", "chain", "spring", "swing"):
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
