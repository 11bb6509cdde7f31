"""Schemes of the study in OpenSees, a finite element code, as an optional comparison.

OpenSees' material ``ElasticPowerFunc`` is exactly the cubic spring. On this spring, all schemes except Houbolt's agree
with the study to round-off: OpenSees starts Houbolt's method by two steps of average acceleration. OpenSees' α-method
evaluates one internal force at the weighted displacement, p((1 + α) u₁ − α u₀), while the form of Xie (1996) weights
two forces. Bathe's method is called TRBDF2, and each of its two sub-steps is a step of OpenSees. OpenSees'
generalized-α method with non-zero α_m is left out, because at a step of a twentieth of the period its motion grows to a
hundred times the amplitude within five periods.
"""

import tempfile
import time
from collections.abc import Callable
from types import ModuleType

import numpy as np
from jaxtyping import Float, Int

from reference.solution import Solution, Times
from study.materials import BoucWen, Elastoplastic, ViscousDamper
from study.mechanics.definition import Problem
from study.mechanics.ground import GroundMotion
from study.problem.named import problems as problems_by_name
from study.problem.springs import CubicSpring
from study.program import opensees_run

#: Integrators of OpenSees for schemes that are compared.
INTEGRATORS = {
    name: integrator
    for name, integrator in opensees_run.INTEGRATORS.items()
    if name not in ("generalized_alpha", "CentralDifference", "ExplicitDifference")
}

_Positions = Float[np.ndarray, "joints directions"]
_Velocities = Float[np.ndarray, "joints*directions"]
_Bars = Int[np.ndarray, "bars 2"]
_PerStorey = Float[np.ndarray, "storeys"]


def _spring(problem: Problem) -> CubicSpring:
    spring = getattr(problem.force, "__self__", None)
    if not isinstance(spring, CubicSpring):
        raise ValueError(f"OpenSees has no material for the spring of '{problem.title}', only for a cubic spring.")
    return spring


def _nodes(places: np.ndarray) -> ModuleType:
    """OpenSees with a node of unit mass at each of the ``places`` (nodes, directions)."""
    ops = opensees_run.interpreter()
    ops.wipe()
    directions = places.shape[1]
    ops.model("basic", "-ndm", directions, "-ndf", directions)
    for node, place in enumerate(places.tolist(), start=1):
        ops.node(node, *place)
        ops.mass(node, *[1.0] * directions)
    return ops


def _line(nodes: int) -> ModuleType:
    """OpenSees with nodes of unit mass in one dimension, all at the origin; the first node is fixed."""
    ops = _nodes(np.zeros((nodes, 1)))
    ops.fix(1, 1)
    return ops


def _choose(ops: ModuleType, scheme: str) -> None:
    """Choose the integrator of a scheme, its solution algorithm, and the equation solver of a transient analysis."""
    if scheme not in INTEGRATORS:
        raise ValueError(f"OpenSees has no integrator for '{scheme}', only for {', '.join(INTEGRATORS)}.")
    integrator = INTEGRATORS[scheme]
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-13, 50)
    ops.algorithm(integrator.algorithm)
    ops.integrator(*integrator.words)
    ops.analysis("Transient")


def _prepared(problem: str, scheme: str) -> ModuleType:
    """OpenSees with the spring in its initial state and the integrator of a scheme."""
    definition = problems_by_name[problem]
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
    """Run time in seconds of ``steps`` steps in one call without output. Raises as :func:`trajectory` does."""
    ops, parts = _prepared(problem, scheme), INTEGRATORS[scheme].parts
    start = time.perf_counter()
    failed = ops.analyze(steps * parts, dt / parts)
    elapsed = time.perf_counter() - start
    if failed:
        raise ValueError(f"OpenSees failed on '{problem}' with '{scheme}'.")
    return elapsed


def trajectory(problem: str, scheme: str, dt: float, steps: int) -> Solution:
    """Displacement and velocity of a cubic spring after every step, each (steps,).

    OpenSees does not count force evaluations, so ``evaluations`` is −1.

    Raises
    ------
    ImportError
        If OpenSees is not installed.
    ValueError
        If the problem is not a cubic spring, OpenSees lacks the scheme, or a step fails.
    """
    ops = _prepared(problem, scheme)
    return _stepped(ops, scheme, dt, steps, lambda function: function(2, 1))


def variable_steps(
    problem: str, scheme: str, duration: float, dt: float, longest: float, iterations: int
) -> tuple[Times, Solution]:
    """Times, displacement and velocity of a cubic spring after every step, whose size OpenSees chooses.

    ``VariableTransient`` multiplies the step size by the ratio of ``iterations`` to the number of convergence tests in
    the last step. The last step of the run is not shortened, so the run may end after its duration. Raises as
    :func:`trajectory` does.

    Parameters
    ----------
    dt, longest
        First step size and largest step size, in seconds.
    iterations
        Target number of convergence tests in a step.
    """
    ops = _prepared(problem, scheme)
    ops.wipeAnalysis()
    _choose(ops, scheme)
    ops.analysis("VariableTransient")
    with tempfile.TemporaryDirectory() as folder:
        files = {quantity: f"{folder}/{quantity}" for quantity in ("disp", "vel")}
        for quantity, file in files.items():
            ops.recorder("Node", "-file", file, "-precision", 16, "-time", "-node", 2, "-dof", 1, quantity)
        start = time.perf_counter()
        steps = round(duration / dt)
        failed = ops.analyze(steps, duration / steps, 1e-6 * dt, longest, iterations)
        elapsed = time.perf_counter() - start
        ops.wipe()  # closes the files
        (t, u), (_, v) = (np.loadtxt(file).T for file in files.values())
    if failed:
        raise ValueError(f"OpenSees failed on '{problem}' with '{scheme}'.")
    return t, Solution(u, v, -1, elapsed)


def stiff_soft(scheme: str, dt: float, steps: int) -> Solution:
    """Displacement and velocity of the problem ``stiff_soft`` after every step, each (steps, 2).

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
    return _stepped(ops, scheme, dt, steps, lambda function: [function(node, 1) for node in (2, 3)])


def truss(
    joints: _Positions, bars: _Bars, rigidity: float, v0: _Velocities, scheme: str, dt: float, steps: int
) -> Solution:
    """Displacement and velocity of a free truss after every step, each (steps, joints · directions).

    The joints have unit mass and start undeformed. The bars rotate with their joints (OpenSees' ``corotTruss``) and
    have the energy EA (l − L)²/(2L). Raises as :func:`trajectory` does.

    Parameters
    ----------
    joints
        Positions of the joints.
    bars
        The two joints of every bar, by number from 0 on.
    rigidity
        EA of every bar.
    v0
        Initial velocities, joint by joint.
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
        ops, scheme, dt, steps, lambda function: [x for node in range(1, len(joints) + 1) for x in function(node)]
    )


def shear_frame(
    storeys: Elastoplastic | BoucWen,
    mass: _PerStorey,
    scheme: str,
    dt: float,
    steps: int,
    *,
    dampers: ViscousDamper | None = None,
    ground: GroundMotion | None = None,
    v0: _PerStorey | None = None,
) -> Solution:
    """Displacement and velocity relative to the ground of a frame of storeys, after every step, each (steps, storeys).

    Storeys that yield have OpenSees' material ``Steel01``, storeys with smooth hysteresis ``BoucWen``, and dampers
    ``Viscous``. ``BoucWen`` integrates the rate of its law implicitly, so its force has an error of first order in Δt.

    Parameters
    ----------
    storeys, dampers
        A spring and a damper in every storey; their parameters are arrays (storeys,).
    mass
        Mass of each floor.
    ground
        Acceleration of the ground.
    v0
        Initial velocities.

    Raises as :func:`trajectory` does.
    """
    floors = len(mass)
    ops = _line(nodes=floors + 1)
    for number in range(1, floors + 1):
        ops.mass(number + 1, float(mass[number - 1]))
        stiffness, bound, hardening = (
            float(np.broadcast_to(value, floors)[number - 1])
            for value in (storeys.stiffness, storeys.yield_force, storeys.hardening)
        )
        if isinstance(storeys, Elastoplastic):
            ops.uniaxialMaterial("Steel01", number, bound, stiffness, hardening)
        else:
            # z in OpenSees is the displacement u_y y of ``BoucWen``, so β and γ in OpenSees are 1/(2 u_yⁿ)
            n, scale = storeys.exponent, 0.5 * (stiffness / bound) ** storeys.exponent
            ops.uniaxialMaterial("BoucWen", number, hardening, stiffness, n, scale, scale, 1.0, 0.0, 0.0, 0.0)
        ops.element("zeroLength", number, number, number + 1, "-mat", number, "-dir", 1)
        if dampers is not None:
            coefficient, exponent = (
                float(np.broadcast_to(value, floors)[number - 1]) for value in (dampers.coefficient, dampers.exponent)
            )
            ops.uniaxialMaterial("Viscous", floors + number, coefficient, exponent)
            ops.element("zeroLength", floors + number, number, number + 1, "-mat", floors + number, "-dir", 1)
    if ground is not None:
        samples = np.asarray(ground.acceleration).tolist()
        ops.timeSeries("Path", 1, "-dt", float(ground.dt), "-values", *samples)
        ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    _choose(ops, scheme)
    for number, speed in enumerate([] if v0 is None else np.asarray(v0).tolist(), start=2):
        ops.setNodeVel(number, 1, speed, "-commit")
    return _stepped(ops, scheme, dt, steps, lambda function: [function(node, 1) for node in range(2, floors + 2)])


def _stepped(ops: ModuleType, scheme: str, dt: float, steps: int, read: Callable) -> Solution:
    """Displacement and velocity after every step; ``read`` calls OpenSees' function of a node at all free nodes."""
    u, v, parts = [], [], INTEGRATORS[scheme].parts
    start = time.perf_counter()
    for step in range(steps):
        if ops.analyze(parts, dt / parts):
            raise ValueError(f"OpenSees failed at step {step + 1} with '{scheme}'.")
        u.append(read(ops.nodeDisp))
        v.append(read(ops.nodeVel))
    return Solution(np.array(u), np.array(v), -1, time.perf_counter() - start)
