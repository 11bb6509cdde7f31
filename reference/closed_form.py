"""Closed forms of motions and periods in arbitrary precision.

The cubic springs and the pendulum are solved by elliptic functions, the period of the tanh spring by quadrature, and
linear structures under a harmonic load by their modes.
"""

from collections.abc import Iterable
from typing import cast

import jax
import mpmath
import numpy as np

from reference.solution import History
from study.mechanics.definition import Problem
from study.mechanics.loads import HarmonicLoad
from study.problem.springs import CubicSpring, TanhSpring

#: Number of decimal digits of the arithmetic; 30 digits of a period are then exact.
DIGITS = 50


def is_known(problem: Problem) -> bool:
    """Whether the period has a closed form: a free, undamped cubic or tanh spring of unit mass, released from rest."""
    terms = problem.damping, problem.load, problem.mass, problem.stiffness
    free = all(term is None for term in terms)
    spring = getattr(problem.force, "__self__", None)
    return free and isinstance(spring, CubicSpring | TanhSpring) and float(problem.v0) == 0.0


def _spring(problem: Problem) -> CubicSpring | TanhSpring:
    if not is_known(problem):
        raise ValueError(f"no closed form is known for '{problem.title}': it must be a free spring released from rest.")
    return problem.force.__self__  # type: ignore[attr-defined]


def _cubic(spring: CubicSpring, u0):
    """Amplitude A, rate κ, parameter m, phase φ and Jacobi function of the solution of ü + S1 u (1 + S2 u²) = 0.

    For a hardening spring, and a double well released above its barrier, u = A cn(κt) with κ² = S1 (1 + S2 A²) and
    m = S2 A² / (2 (1 + S2 A²)). Within one well of the double well, u = A dn(κt + φ) with κ² = S1 S2 A²/2 and
    m = 1 − (a/A)², where a and A are the inner and the outer turning point.

    Source: P. F. Byrd, M. D. Friedman, Handbook of Elliptic Integrals for Engineers and Scientists, 1971.
    """
    S1, S2 = mpmath.mpf(spring.S1), mpmath.mpf(spring.S2)
    stiffness = 1 + S2 * u0**2
    if (S1 > 0 and S2 > 0) or (S1 < 0 and S2 < 0 and -S2 * u0**2 > 2):
        return u0, mpmath.sqrt(S1 * stiffness), S2 * u0**2 / (2 * stiffness), mpmath.mpf(0), "cn"
    if S1 < 0 and S2 < 0 and 0 < -S2 * u0**2 < 2:
        squares = sorted([u0**2, -2 / S2 - u0**2])  # squares of the turning points, at which the potential is equal
        m = 1 - squares[0] / squares[1]
        phase = mpmath.ellipk(m) if u0**2 == squares[0] else mpmath.mpf(0)
        amplitude = mpmath.sign(u0) * mpmath.sqrt(squares[1])
        return amplitude, mpmath.sqrt(S1 * S2 * squares[1] / 2), m, phase, "dn"
    raise ValueError(f"no closed form is implemented for {spring} released at {u0}.")


def _tanh_period(spring: TanhSpring, u0):
    """T = 4 ∫ du / √(2S ln(cosh u₀ / cosh u)) over 0 ≤ u ≤ u₀; u = u₀ (1 − x²) removes the singularity at u₀."""

    def integrand(x):
        drop = u0 * x**2
        # ln(cosh u₀ / cosh(u₀ − drop)) in a form that is accurate for small drops and does not overflow for large u₀
        tail = mpmath.exp(-2 * u0) * mpmath.expm1(2 * drop) / (1 + mpmath.exp(2 * (drop - u0)))
        logarithm = drop + mpmath.log1p(-tail)
        return 2 * u0 * x / mpmath.sqrt(2 * spring.S * logarithm)

    return 4 * mpmath.quad(integrand, mpmath.linspace(0, 1, 5))


def period(problem: Problem, u0: float | None = None, digits: int = DIGITS) -> mpmath.mpf:
    """Exact period of a spring released from rest.

    The period of a cubic spring is 4 K(m)/κ, with the complete elliptic integral K of the first kind. Within one well
    of the double well it is 2 K(m)/κ. :func:`_cubic` describes m and κ.

    Parameters
    ----------
    u0
        Initial displacement; by default, the initial displacement of the problem.
    digits
        Number of decimal digits of the arithmetic.

    Raises
    ------
    ValueError
        If the period has no closed form.
    """
    spring = _spring(problem)
    with mpmath.workdps(digits):
        start = mpmath.mpf(float(problem.u0 if u0 is None else u0))
        if isinstance(spring, TanhSpring):
            return _tanh_period(spring, abs(start))
        _, kappa, m, _, function = _cubic(spring, start)
        return (4 if function == "cn" else 2) * mpmath.ellipk(m) / kappa


def turning_points(problem: Problem, u0: float) -> tuple[float, float]:
    """Least and largest displacement of the motion of a spring released from rest at ``u0``.

    Raises
    ------
    ValueError
        If the period has no closed form.
    """
    spring = _spring(problem)
    if isinstance(spring, TanhSpring):
        return -abs(u0), abs(u0)
    amplitude, _, m, _, function = _cubic(spring, mpmath.mpf(u0))
    ends = float(amplitude), float(-amplitude if function == "cn" else amplitude * mpmath.sqrt(1 - m))
    return min(ends), max(ends)


def has_trajectory(problem: Problem) -> bool:
    """Whether the trajectory has a closed form: the problem is a cubic spring whose period has a closed form."""
    return is_known(problem) and isinstance(_spring(problem), CubicSpring)


def trajectory(problem: Problem, t: Iterable) -> tuple[list[mpmath.mpf], list[mpmath.mpf]]:
    r"""Exact displacement and velocity of a cubic spring at the times ``t``, with ``DIGITS`` digits.

    With x = κt + φ and the constants of :func:`_cubic`, the motion with the Jacobi function cn or dn is

    .. math::

        u &= A \operatorname{cn} x, \quad \dot u = -A\kappa \operatorname{sn} x \operatorname{dn} x \\
        u &= A \operatorname{dn} x, \quad \dot u = -A\kappa m \operatorname{sn} x \operatorname{cn} x

    Parameters
    ----------
    t
        Times as floats, which are taken to be exact, or as numbers of mpmath.

    Raises
    ------
    ValueError
        If the trajectory has no closed form.
    """
    spring = _spring(problem)
    if not isinstance(spring, CubicSpring):
        raise ValueError(f"the trajectory of '{problem.title}' has no closed form; only its period has.")
    u, v = [], []
    with mpmath.workdps(DIGITS):
        amplitude, kappa, m, phase, function = _cubic(spring, mpmath.mpf(float(problem.u0)))
        for time in t:
            x = kappa * mpmath.mpf(time) + phase
            sn, cn, dn = (mpmath.ellipfun(name, x, m=m) for name in ("sn", "cn", "dn"))
            value, slope = (cn, -sn * dn) if function == "cn" else (dn, -m * sn * cn)
            u.append(amplitude * value)
            v.append(amplitude * kappa * slope)
    return u, v


def _pendulum(problem: Problem, t: Iterable) -> tuple[list, list]:
    """Motion of the plane pendulum ü + sin u = 0 from u = 0 with the velocity u̇₀ < 2.

    u = 2 arcsin(k sn(t)) and u̇ = 2k cn(t), with the modulus k = u̇₀/2. Source: Byrd and Friedman (1971), see
    :func:`_cubic`.
    """
    k = mpmath.mpf(float(problem.v0)) / 2
    sn, cn = ([mpmath.ellipfun(name, mpmath.mpf(time), m=k**2) for time in t] for name in ("sn", "cn"))
    return [2 * mpmath.asin(k * s) for s in sn], [2 * k * c for c in cn]


def _modes(problem: Problem, t: Iterable) -> tuple[list, list]:
    r"""Motion Σ φ q(t) of a linear structure of unit masses from rest under the load f cos(Ωt − α).

    The modes are K φ = ω² φ with φᵀφ = 1. Each modal coordinate solves q̈ + ω² q = φᵀf cos(Ωt − α), so that

    .. math::

        q = \frac{\varphi^T f}{\omega^2 - \Omega^2} (\cos(\Omega t - \alpha) - \cos\alpha \cos\omega t
            - \frac{\Omega}{\omega} \sin\alpha \sin\omega t)
    """
    load = cast(HarmonicLoad, problem.load)
    stiffness = mpmath.matrix(np.asarray(jax.jit(jax.jacobian(problem.static_force))(problem.u0)).tolist())
    squares, shapes = mpmath.eigsy(stiffness)
    frequency, phase = mpmath.mpf(float(load.frequency)), mpmath.mpf(float(load.phase))
    forces = shapes.T * mpmath.matrix(np.asarray(load.amplitude).tolist())
    u, v = [], []
    for time in map(mpmath.mpf, t):
        q, rate = [], []
        for square, force in zip(squares, forces, strict=True):
            omega, angle = mpmath.sqrt(square), frequency * time - phase
            c, s = mpmath.cos(omega * time), mpmath.sin(omega * time)
            start, speed = mpmath.cos(phase), frequency * mpmath.sin(phase)
            response = force / (square - frequency**2)
            q.append(response * (mpmath.cos(angle) - start * c - speed / omega * s))
            rate.append(response * (-frequency * mpmath.sin(angle) + omega * start * s - speed * c))
        u.append(list(shapes * mpmath.matrix(q)))
        v.append(list(shapes * mpmath.matrix(rate)))
    return u, v


#: Functions that compute a trajectory in closed form, by name of the structure.
STRUCTURE_TRAJECTORIES = {"pendulum": _pendulum, "stiff_soft": _modes}


def structure_trajectory(name: str, problem: Problem, t: Iterable) -> tuple[History, History]:
    """Exact displacement and velocity of a structure at the times ``t``, rounded to doubles.

    Parameters
    ----------
    name
        Name of the structure in ``STRUCTURE_TRAJECTORIES``.
    problem
        The structure itself.
    """
    with mpmath.workdps(DIGITS):
        u, v = STRUCTURE_TRAJECTORIES[name](problem, t)
        return np.array(u, dtype=float), np.array(v, dtype=float)
