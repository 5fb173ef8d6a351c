"""Pinocchio's constrained dynamics, called from Python: a tree of hinges, closed by contacts; RK4.

The cut joints drift; Pinocchio corrects them by Baumgarte's method, whose gains are tuned by hand.
"""

import math
import time
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as version_of

import numpy as np

from taut.benchmark.entrant import Array, Entrant, Peer, Problem, Run
from taut.errors import TautError

PACKAGE = "pin"
PIN = "4.1.0"
GRAVITY = 9.81
# Steps [s] in the place of tolerances.
STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1.25e-3)
# Gains of the correction of the cut joints [1/s^2, 1/s], of those tried the ones with the least error, and
# the proximal method, which copes with redundant equations across the plane and in the singular positions.
KP, KD = 100.0, 20.0
ACCURACY, MU, ITERATIONS = 1e-12, 1e-6, 20


def version() -> str | None:
    """Returns the installed version, or None."""
    try:
        return version_of(PACKAGE)
    except PackageNotFoundError:
        return None


def system(size: int) -> tuple[Array, Callable[[Array, Array], Array], Callable[[Array, Array], Array]]:
    """Returns angles and rates at the start, the accelerations, and the map to the points {B; rates}."""
    import pinocchio as pin

    model = pin.Model()
    model.gravity.linear = np.array([0.0, -GRAVITY, 0.0])
    tip = pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
    rod = pin.Inertia(1.0, np.array([0.5, 0.0, 0.0]), np.diag([0.0, 1 / 12, 1 / 12]))
    cranks, couplers = [], []
    for i in range(size + 1):
        foot = pin.SE3(np.eye(3), np.array([float(i), 0.0, 0.0]))
        cranks.append(model.addJoint(0, pin.JointModelRZ(), foot, f"crank{i}"))
        model.appendBodyToJoint(cranks[i], rod, pin.SE3.Identity())
        if i < size:
            couplers.append(model.addJoint(cranks[i], pin.JointModelRZ(), tip, f"coupler{i}"))
            model.appendBodyToJoint(couplers[i], rod, pin.SE3.Identity())
    data = model.createData()
    contacts = pin.StdVec_RigidConstraintModel()
    contact_data = pin.StdVec_RigidConstraintData()
    for i in range(size):
        contact = pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D,
            model,
            couplers[i],
            tip,
            cranks[i + 1],
            tip,
            pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
        )
        contact.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(KP, KD))
        contacts.append(contact)
        contact_data.append(contact.createData())
    pin.initConstraintDynamics(model, data, contacts, contact_data)
    settings = pin.ProximalSettings(ACCURACY, MU, ITERATIONS)
    none = np.zeros(model.nv)
    upright = np.zeros(model.nq)
    rate = np.zeros(model.nv)
    for joint in cranks:
        upright[model.joints[joint].idx_q] = math.pi / 2
        rate[model.joints[joint].idx_v] = -1.0
    for joint in couplers:
        upright[model.joints[joint].idx_q] = -math.pi / 2
        rate[model.joints[joint].idx_v] = 1.0

    def acceleration(q: Array, v: Array) -> Array:
        return pin.constraintDynamics(model, data, q, v, none, contacts, contact_data, settings)

    def points(q: Array, v: Array) -> Array:
        at = [model.joints[joint].idx_q for joint in cranks]
        a, w = q[at], v[at]
        place = np.column_stack((np.arange(size + 1) + np.cos(a), np.sin(a)))
        return np.concatenate((place.ravel(), np.column_stack((-w * np.sin(a), w * np.cos(a))).ravel()))

    return np.array([upright, rate]), acceleration, points


def integrate(problem: Problem, size: int, step: float) -> tuple[float, int, Array]:
    """Returns processor time [s], steps and the last state of one run."""
    (q, v), acceleration, points = system(size)
    steps = round(problem.t_end / step)
    h = problem.t_end / steps
    before = time.process_time()
    for _ in range(steps):
        a1 = acceleration(q, v)
        v2 = v + 0.5 * h * a1
        a2 = acceleration(q + 0.5 * h * v, v2)
        v3 = v + 0.5 * h * a2
        a3 = acceleration(q + 0.5 * h * v2, v3)
        v4 = v + h * a3
        a4 = acceleration(q + h * v3, v4)
        q = q + h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    taken = time.process_time() - before
    if not np.isfinite(q).all():
        raise TautError("Pinocchio: the angles are no numbers")
    return taken, steps, points(q, v)


def entrants(problem: Problem, size: int) -> Sequence[Entrant]:
    """Returns Pinocchio with its steps, for the loops alone."""
    if problem.name != "four-bar":
        return []

    def run(step: float, seconds: float) -> Run:
        best, spent = math.inf, 0.0
        while True:
            taken, steps, state = integrate(problem, size, step)
            best, spent = min(best, taken), spent + taken
            if spent >= seconds:
                return Run(best, steps, 4 * steps, 0, state)

    return [Entrant("Pinocchio", "pinocchio", STEPS, run)]


PEER = Peer("pinocchio", version, entrants, pypi=(f"{PACKAGE}=={PIN}",))
