"""OpenSees, a finite element code that steps the same schemes: an optional peer.

The cubic spring is its material ``ElasticPowerFunc`` exactly. All but two schemes are the same to round-off: Houbolt's
method is started by two steps of average acceleration, and the α-method evaluates one internal force at the weighted
displacement, p((1 + α) u₁ − α u₀), where that of 1996 weights two. Bathe's method goes by the name of TRBDF2, its two
sub-steps taken as steps. Its generalized-α method with α_m other than zero is left out: at a twentieth of the period
its motion of this spring grows to a hundred times the amplitude within five periods.
"""

import importlib
import time
from collections.abc import Callable
from types import ModuleType

import numpy as np

from reference.solution import Solution
from study.problem.definition import Problem
from study.problem.named import problems
from study.problem.springs import CubicSpring

#: Scheme: the integrator of the same name and parameters, and the solution algorithm that it takes.
INTEGRATORS = {
    "average_acceleration": (("Newmark", 0.5, 0.25), "Newton"),
    "central_difference": (("NewmarkExplicit", 0.5), "Linear"),
    "newmark_dissipative": (("Newmark", 0.6, 0.3025), "Newton"),
    "wilson_theta": (("WilsonTheta", 1.4), "Newton"),
    "houbolt": (("Houbolt",), "Newton"),
    "hht_alpha": (("HHT", 0.9, 0.6, 0.3025), "Newton"),
    "linear_acceleration": (("Newmark", 0.5, 1 / 6), "Newton"),
    "fox_goodwin": (("Newmark", 0.5, 1 / 12), "Newton"),
    "hht_alpha_one_force": (("HHT", 0.9, 0.6, 0.3025), "Newton"),
    "bathe": (("TRBDF2",), "Newton"),
    "kr_alpha": (("KRAlphaExplicit", 0.8), "Linear"),
}
#: How many steps of OpenSees are one.
SUB_STEPS = {"bathe": 2}


class NotInstalled(ImportError):
    """OpenSees is not there; the message says how to get it."""


def load() -> ModuleType:
    """OpenSees' interpreter.

    Raises
    ------
    NotInstalled
        If the extra ``opensees`` of this package, or a library that it needs, is not installed.
    """
    try:
        return importlib.import_module("openseespy.opensees")
    except (ImportError, RuntimeError) as error:
        raise NotInstalled(
            "OpenSees is left out: install the extra 'opensees' of this package, and the system's BLAS and LAPACK "
            f"({error})."
        ) from None


def _spring(problem: Problem) -> CubicSpring:
    spring = getattr(problem.force, "__self__", None)
    if not isinstance(spring, CubicSpring):
        raise ValueError(f"OpenSees has no material that is the spring of '{problem.title}'; it has the cubic one.")
    return spring


def _nodes(places: np.ndarray) -> ModuleType:
    """OpenSees with a node of unit mass at every place (nodes, directions)."""
    ops = load()
    ops.wipe()
    directions = places.shape[1]
    ops.model("basic", "-ndm", directions, "-ndf", directions)
    for node, place in enumerate(places.tolist(), start=1):
        ops.node(node, *place)
        ops.mass(node, *[1.0] * directions)
    return ops


def _line(nodes: int) -> ModuleType:
    """As many of them in one place on a line, the first fixed."""
    ops = _nodes(np.zeros((nodes, 1)))
    ops.fix(1, 1)
    return ops


def _choose(ops: ModuleType, scheme: str) -> None:
    """The integrator of this name, and the rest of an analysis."""
    if scheme not in INTEGRATORS:
        raise ValueError(f"OpenSees does not step '{scheme}'; it steps {', '.join(INTEGRATORS)}.")
    integrator, algorithm = INTEGRATORS[scheme]
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-13, 50)
    ops.algorithm(algorithm)
    ops.integrator(*integrator)
    ops.analysis("Transient")


def _prepared(problem: str, scheme: str) -> ModuleType:
    """OpenSees with the spring at its start and the integrator chosen."""
    definition = problems[problem]
    spring = _spring(definition)
    ops = _line(nodes=2)
    ops.uniaxialMaterial("ElasticPowerFunc", 1, "-coeff", spring.S1, spring.S1 * spring.S2, "-exp", 1.0, 3.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    _choose(ops, scheme)
    u0 = float(definition.u0)
    ops.setNodeDisp(2, 1, u0, "-commit")
    ops.setNodeVel(2, 1, float(definition.v0), "-commit")
    ops.setNodeAccel(2, 1, -float(spring.force(u0)), "-commit")
    return ops


def seconds(problem: str, scheme: str, dt: float, steps: int) -> float:
    """Time of ``steps`` steps in one call, with nothing recorded. Raises as :func:`trajectory` does."""
    ops, parts = _prepared(problem, scheme), SUB_STEPS.get(scheme, 1)
    start = time.perf_counter()
    failed = ops.analyze(steps * parts, dt / parts)
    elapsed = time.perf_counter() - start
    if failed:
        raise ValueError(f"OpenSees failed on '{problem}' with '{scheme}'.")
    return elapsed


def trajectory(problem: str, scheme: str, dt: float, steps: int) -> Solution:
    """Displacement and velocity at every step after the start; ``evaluations`` are not told and −1.

    Raises
    ------
    NotInstalled
        If OpenSees is not there.
    ValueError
        If the problem is no cubic spring, or OpenSees has no such scheme or fails.
    """
    ops = _prepared(problem, scheme)
    return _stepped(ops, scheme, dt, steps, lambda of_node: of_node(2, 1))


def stiff_soft(scheme: str, dt: float, steps: int) -> Solution:
    """The system of :func:`study.structures.stiff_soft`, two unknowns, at every step after the start.

    Raises as :func:`trajectory` does.
    """
    stiffness, soft, frequency = 1e7, 1.0, 1.2
    ops = _line(nodes=3)
    for number, modulus in enumerate((stiffness, soft), start=1):
        ops.uniaxialMaterial("Elastic", number, modulus)
        ops.element("zeroLength", number, number, number + 1, "-mat", number, "-dir", 1)
    ops.timeSeries("Trig", 1, 0.0, 2 * dt * steps, 2 * np.pi / frequency)
    ops.pattern("Plain", 1, 1)
    ops.load(2, stiffness)
    _choose(ops, scheme)
    return _stepped(ops, scheme, dt, steps, lambda of_node: [of_node(node, 1) for node in (2, 3)])


def truss(
    joints: np.ndarray, bars: np.ndarray, rigidity: float, v0: np.ndarray, scheme: str, dt: float, steps: int
) -> Solution:
    """A free truss of bars (bars, 2) between joints (joints, directions) of unit mass, in motion from its own form.

    Its bars turn with their joints (``corotTruss``) and have the energy EA (l − L)²/(2L). Displacement
    and velocity are (steps, joints · directions). Raises as :func:`trajectory` does.
    """
    ops = _nodes(joints)
    ops.uniaxialMaterial("Elastic", 1, rigidity)
    for number, (first, second) in enumerate(bars.tolist(), start=1):
        ops.element("corotTruss", number, first + 1, second + 1, 1.0, 1)
    _choose(ops, scheme)
    for node, velocity in enumerate(np.reshape(v0, joints.shape).tolist(), start=1):
        for direction, component in enumerate(velocity, start=1):
            ops.setNodeVel(node, direction, component, "-commit")
    return _stepped(
        ops, scheme, dt, steps, lambda of_node: [x for node in range(1, len(joints) + 1) for x in of_node(node)]
    )


def _stepped(ops: ModuleType, scheme: str, dt: float, steps: int, read: Callable) -> Solution:
    """Displacement and velocity after every step, as ``read`` takes them from OpenSees' nodes."""
    u, v, parts = [], [], SUB_STEPS.get(scheme, 1)
    start = time.perf_counter()
    for step in range(steps):
        if ops.analyze(parts, dt / parts):
            raise ValueError(f"OpenSees failed at step {step + 1} with '{scheme}'.")
        u.append(read(ops.nodeDisp))
        v.append(read(ops.nodeVel))
    return Solution(np.array(u), np.array(v), -1, time.perf_counter() - start)
