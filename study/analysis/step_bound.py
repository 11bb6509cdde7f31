"""``study.step_bound``: the step that keeps the energy, the period and the displacement of a free oscillation."""

import math
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jaxtyping import Float

from study.algebra.jit import jit
from study.algebra.scalars import is_number
from study.analysis.modified_equation import ModifiedEnergy, ModifiedEquation, displacement_error, modified_equation
from study.marching.arguments import resolve
from study.mechanics.definition import Problem
from study.mechanics.internal_force import switches
from study.observer.outcome import OutcomeObserver
from study.problem.named import problems
from study.scheme.base import Scheme
from study.scheme.named import schemes

#: Largest ωΔt, largest change of the tangent within a step over its largest size, and mean part of a wave of the
#: tangent that a step may pass, in rad, at which the term of Δt² describes a run; no bound is larger. On a spring of
#: tanh form, errors exceed the term by up to 5 % there, and by more than a tenth once the tangent changes by 0.8. Steps
#: that pass over waves of the tangent meet many resonances, and with half a wave errors exceed the term by up to a
#: fifth.
LARGEST, LARGEST_CHANGE, LARGEST_WAVE = 0.5, 0.5, 1.6
#: Variation of the tangent along a motion, over its largest size, that counts as none.
CONSTANT = 1e-3
#: Factor by which the term of (ωΔt)⁴ in the delay may exceed that of a linear oscillator with the frequency ω. It
#: counts where the term of Δt² nearly cancels.
NEXT = 2
#: Round-off of displacement or potential over their changes in a motion, above which it may hide the period.
HIDDEN = 1e-12
#: Ratio of neighbouring distances from rest between which a turning point is sought, and their largest number.
GROWTH, DISTANCES = 1.002, 20_000
#: Largest number of hills between two such distances that are searched for a turning point.
HILLS = 10
#: Largest rise of a potential between the two farthest places, over its rise beyond the motion, of one with a limit.
FLAT = 1e-9
#: Largest part of the changes of the force along an orbit that its tangent may miss, and largest ratio of the tangent
#: at rest or at a turning point to that at all other points.
MISSED, STEEPER = 0.02, 1.1
#: Round-off of a difference of forces, over the largest force.
ROUND_OFF = 1e-14
#: Number of points before the ordered points of an orbit: its start, its turning points and rest.
ENDS = 4
#: Values at points of an orbit.
_Points = Float[np.ndarray, "points"]
#: Numbers of points of an orbit that are tried in turn, and the relative difference of two periods that is accepted.
POINTS, CONVERGED = tuple(2**n for n in range(9, 17)), 1e-8
#: Distance from a kink, relative to the size of the orbit, at which the force and the tangent on either side of it are
#: compared, and their relative difference from which on they jump.
BESIDE, JUMP = 1e-9, 1e-3
#: Factor to a larger distance from a kink, the power of the distance below which a change of the tangent means that its
#: slope is infinite at the kink, and the relative change from which on it is more than round-off.
FARTHER, LINEAR, CHANGE = 1e3, 0.97, 1e-9


class Orbit(NamedTuple):
    """One period of a free oscillation of one unknown.

    Attributes
    ----------
    u, v, force, tangent
        Displacement, size of the velocity, force p and tangent p′: first at the start, then at the turning points, at
        rest, and at points between the turning points, (points,).
    mass
        Mass M.
    period
        Period T.
    period_by_energy, acceleration_by_energy
        Derivatives with respect to the energy of T, and of the integral S of M ü² over a period.
    separatrix_distance
        Least difference of the energy from the barriers beyond the motion and the hills within it, over the height of
        the energy above rest.
    """

    u: _Points
    v: _Points
    force: _Points
    tangent: _Points
    mass: float
    period: float
    period_by_energy: float
    acceleration_by_energy: float
    separatrix_distance: float

    @property
    def highest_frequency(self) -> float:
        """Largest circular frequency of the tangent, by its size."""
        return math.sqrt(np.abs(self.tangent).max() / self.mass)

    @property
    def described_up_to(self) -> float:
        """Largest ωΔt at which the term of Δt² describes a run."""
        u, v, tangent = (values[ENDS:] for values in (self.u, self.v, self.tangent))
        time = np.diff(u) / ((v[1:] + v[:-1]) / 2)
        rate, omega, size = np.diff(tangent) / time, self.highest_frequency, np.abs(tangent).max()
        if np.ptp(tangent) <= CONSTANT * size:
            return LARGEST
        fastest = np.max(np.abs(rate))
        # the mean frequency of the waves, which a kink of the tangent does not raise as the largest one
        wave = np.abs(np.diff(rate)).sum() / np.abs(np.diff(tangent)).sum()
        return float(min(LARGEST, LARGEST_CHANGE * size * omega / fastest, LARGEST_WAVE * omega / wave))

    def _change(self, modified: ModifiedEnergy) -> _Points:
        """The coefficient g of Δt² in the modified energy."""
        by_velocity = modified.velocity_coefficient * self.tangent * self.v**2
        return by_velocity + modified.acceleration_coefficient * self.force**2 / self.mass

    def delay(self, modified: ModifiedEnergy) -> float:
        """The error of the period over Δt²."""
        change = self._change(modified)[0] * self.period_by_energy
        return float(change - modified.period_coefficient * self.acceleration_by_energy)

    def next_delay(self, equation: ModifiedEquation) -> float:
        """An estimate of the coefficient of (ωΔt)⁴ in the relative error of the period, see :func:`step_bound`."""
        (energy_error, _), height = self.coefficients(equation.energy), self.mass / 2 * np.max(self.v) ** 2
        by_energy = abs(self.period_by_energy) * height / self.period
        return NEXT * equation.next_term + by_energy * energy_error**2 * (1 + 1 / self.separatrix_distance) / 4

    def coefficients(self, modified: ModifiedEnergy) -> Float[np.ndarray, "2"]:
        """Errors of energy and period over (ωΔt)², see :func:`step_bound`."""
        g, delay = self._change(modified), self.delay(modified)
        energy_error = np.max(np.abs(g - g[0])) / (self.mass / 2 * np.max(self.v) ** 2)
        return np.array([energy_error, abs(delay) / self.period]) / self.highest_frequency**2


@partial(jit, compiler=eqx.filter_jit)
def _at(problem: Problem, places) -> tuple:
    """Potential, force and tangent at each place."""
    return tuple(
        jnp.vectorize(function)(places)
        for function in (problem.stored_energy, problem.static_force, jax.grad(problem.static_force))
    )


@partial(jit, compiler=eqx.filter_jit)
def _integrals(problem: Problem, energy, mass, ends, cosine, sine) -> tuple:
    """T and S, their derivatives by the energy, and displacement, velocity and force at the points of the orbit."""
    stored, force = jax.vmap(problem.stored_energy), jax.vmap(problem.static_force)
    stored_there, force_there = stored(ends), force(ends)

    def integrals(energy):
        # one step of Newton's method carries the derivative by the energy to the turning points
        low, high = ends - (stored_there - energy) / force_there
        u = (low + high) / 2 + (high - low) / 2 * cosine
        v, forces = jnp.sqrt(2 / mass * (energy - stored(u))), force(u)
        weights = np.pi / len(sine) * (high - low) * sine / v
        return (jnp.sum(weights), jnp.sum(weights * forces**2) / mass), (u, v, forces)

    return jax.jvp(integrals, (energy,), (jnp.ones(()),), has_aux=True)


def _places(rest: float, scale: float) -> _Points:
    """Displacements beyond rest, in the direction of ``scale``."""
    return rest + scale * GROWTH ** np.arange(-DISTANCES / 4, 3 * DISTANCES / 4)


def _turning_point(problem: Problem, energy: float, rest: float, scale: float) -> float:
    """Nearest displacement beyond rest, in the direction of ``scale``, at which the potential reaches the energy."""
    from scipy import optimize  # here, as this import takes a third of the time of importing the study

    def height(u):
        return float(_at(problem, np.float64(u))[0]) - energy

    places = _places(rest, scale)
    stored, force, _ = map(np.asarray, _at(problem, places))
    beyond = np.append(~(stored < energy), True).argmax()
    below, slope, gaps = stored[:beyond], force[:beyond] * np.sign(scale), abs(np.diff(places[:beyond]))
    # between two places the potential may rise above the energy and fall again
    hills = (slope[:-1] > 0) & ~(slope[1:] > 0) & (below[:-1] + slope[:-1] * gaps >= energy)
    tops = (_top(problem, *places[i : i + 2]) for i in np.flatnonzero(hills)[:HILLS])
    outer = next((top for top in tops if height(top) >= 0), places[beyond] if beyond < len(places) else np.nan)
    if not np.isfinite(outer) or not np.isfinite(height(outer)):
        raise ValueError(f"'{problem.title}' does not oscillate: no turning point is found on one side of rest.")
    inside = places[np.abs(places - rest) < abs(outer - rest)]
    return optimize.brentq(height, inside[-1] if len(inside) else rest, outer, xtol=1e-15 * abs(scale))


def _top(problem: Problem, inner: float, outer: float) -> float:
    """The displacement between two others at which the force changes its sign."""
    from scipy import optimize  # here, as this import takes a third of the time of importing the study

    return optimize.brentq(lambda u: float(_at(problem, np.float64(u))[1]), inner, outer)


def _barrier(problem: Problem, end: float, rest: float, scale: float) -> float:
    """Height of the potential at the barrier beyond a turning point, or its limit far away, or infinity."""
    places = _places(rest, scale)
    stored, force, _ = map(np.asarray, _at(problem, places))
    known = (np.abs(places - rest) > abs(end - rest)) & np.logical_and.accumulate(np.isfinite(stored))
    falls = np.flatnonzero(known & ~(force * np.sign(scale) > 0))
    if not len(falls):
        rise = np.diff(stored[known])
        return float(stored[known][-1]) if known[-1] and rise[-1] <= FLAT * rise.sum() else math.inf
    inner = places[falls[0] - 1] if known[falls[0] - 1] else end
    return float(_at(problem, np.float64(_top(problem, inner, places[falls[0]])))[0])


def _hill(problem: Problem, u: _Points, forces: _Points) -> float:
    """Height of the potential at the highest hill between rising places, or minus infinity."""
    tops = (_top(problem, *u[i : i + 2]) for i in np.flatnonzero((forces[:-1] > 0) & (forces[1:] <= 0)))
    return max((float(_at(problem, np.float64(top))[0]) for top in tops), default=-math.inf)


@partial(jit, compiler=eqx.filter_jit)
def _switches(problem: Problem, places):
    return jax.vmap(lambda u: switches(problem.static_force, u))(places)


def _check_tangent(problem: Problem, places: _Points) -> None:
    """Refuse a force or a tangent that jumps, or a tangent with an infinite slope, between two ordered places."""
    from scipy import optimize  # here, as this import takes a third of the time of importing the study

    for i, number in np.argwhere(np.diff(np.sign(_switches(problem, places)), axis=0)):
        kink = optimize.brentq(
            lambda u, number=number: float(_switches(problem, np.full(1, u))[0, number]), *places[i : i + 2]
        )
        beside = kink + BESIDE * np.ptp(places) * np.array([-FARTHER, -1, 0, 1, FARTHER])
        largest, values = (np.array(_at(problem, there)[1:]) for there in (places, beside))
        largest = np.abs(largest).max(axis=1)
        near, far = (np.abs(values[1, [2 - k, 2 + k]] - values[1, 2]).max() for k in (1, 2))
        if (np.abs(values[:, 3] - values[:, 1]) > JUMP * largest).any():
            reason = "the force of '{}' or its tangent jumps"
        elif CHANGE * largest[1] < far < near * FARTHER**LINEAR:
            reason = "the tangent of '{}' has an infinite slope"
        else:
            continue
        raise ValueError(
            f"{reason.format(problem.title)} at u = {kink:.6g}, and no step bound is known there; study.assess finds "
            "the step by runs."
        )


def _unresolved(u: _Points, forces: _Points, tangent: _Points) -> float | None:
    """A displacement near which the tangent at points of the orbit is not the slope of the force, or None.

    It is less than the slope somewhere between two points with a narrow peak between them, and more at a jump.
    """
    along, width, change = tangent[ENDS:], np.diff(u[ENDS:]), np.diff(forces[ENDS:])
    largest = np.abs(along).max()
    missed = np.abs(change - width * (along[1:] + along[:-1]) / 2)
    steep = np.abs(change) > STEEPER * largest * np.abs(width) + ROUND_OFF * np.abs(forces).max()
    if steep.any():
        return float(u[ENDS + steep.argmax()])
    if missed.sum() <= MISSED * np.abs(change).sum() and 0 < np.abs(tangent).max() <= STEEPER * largest:
        return None
    return float(u[ENDS + missed.argmax()])


@jax.enable_x64(True)
def orbit(problem: Problem) -> Orbit:
    r"""The oscillation of a free oscillator of one unknown, by quadrature.

    With the turning points :math:`m \pm r` and :math:`u = m + r \cos\theta`, the time between points is
    :math:`r \sin\theta\, d\theta / \dot u`, with :math:`\dot u` from the energy. The midpoint rule in θ converges
    exponentially; the number of points is doubled until the period does not change.

    Raises
    ------
    ValueError
        If the problem has several unknowns, damping, a load or no potential, if it does not oscillate or rests, if its
        force or tangent jumps or its tangent has an infinite slope, or if the motion is so near to a separatrix that
        the period does not converge.
    """
    well = OutcomeObserver.of(problem)
    rest, mass = float(well.rest_at), float(problem.momentum(1.0))
    at_start = float(problem.energy(problem.u0, problem.v0))
    if not at_start > float(well.rest):
        raise ValueError(f"'{problem.title}' rests at the start: a step bound needs a motion.")
    scale = abs(float(problem.u0) - rest) or 1.0
    ends = np.array([_turning_point(problem, at_start, rest, side * scale) for side in (-1, 1)])

    before, unresolved = math.nan, None
    for points in POINTS:
        angles = (np.arange(points) + 0.5) * np.pi / points
        (period, _), by_energy, (u, v, forces) = _integrals(
            problem, np.float64(at_start), np.float64(mass), ends, np.cos(angles), np.sin(angles)
        )
        if points == POINTS[0]:
            _check_tangent(problem, np.asarray(u))
        if math.isfinite(period) and abs(period - before) <= CONVERGED * period:
            places = np.concatenate([[float(problem.u0), ends[0], rest, ends[1]], u])
            fastest = math.sqrt(2 / mass * (at_start - float(well.rest)))
            v = np.concatenate([[abs(float(problem.v0)), 0.0, fastest, 0.0], v])
            forces = np.concatenate([_at(problem, places[:ENDS])[1], forces])
            tangent = np.asarray(_at(problem, places)[2])
            if (unresolved := _unresolved(places, forces, tangent)) is not None:
                continue
            barrier = min(_barrier(problem, end, rest, side * scale) for end, side in zip(ends, (-1, 1), strict=True))
            hill = _hill(problem, *(values[: ENDS - 1 : -1] for values in (places, forces)))
            distance = min(barrier - at_start, at_start - hill) / (at_start - float(well.rest))
            return Orbit(places, v, forces, tangent, mass, float(period), *map(float, (*by_energy, distance)))
        before = float(period)
    if unresolved is not None:
        raise ValueError(
            f"the tangent of '{problem.title}' is not the slope of its force near u = {unresolved:.6g}, as where one "
            "of them jumps, and no step bound is known there; study.assess finds the step by runs."
        )
    round_off = np.finfo(float).eps * max(abs(at_start) / (at_start - float(well.rest)), abs(rest) / np.ptp(ends))
    raise ValueError(
        f"the period of '{problem.title}' does not converge: "
        + (
            "the motion is so small against its displacement or its potential that round-off hides it; count u and the "
            "potential from rest."
            if round_off > HIDDEN
            else "the motion is too near to a separatrix, where any step changes the period by any factor."
        )
    )


def largest_omega_step(
    coefficients: np.ndarray,
    error: float,
    scheme: Scheme,
    described_up_to: np.ndarray | float,
    next_terms: np.ndarray | float = 0.0,
) -> np.ndarray:
    """The step times the highest frequency at which each error is reached, as far as Δt² describes a stable run.

    The errors are ``coefficients`` times (ωΔt)² and ``next_terms`` times (ωΔt)⁴.
    """
    limit = np.inf if scheme.stability_limit is None else scheme.stability_limit
    with np.errstate(divide="ignore"):
        square = 2 * error / (coefficients + np.sqrt(coefficients**2 + 4 * error * next_terms))
    return np.minimum(np.sqrt(square), np.minimum(described_up_to, limit))


def step_bound(
    problem: str | Problem, scheme: str | Scheme, allowed_error: float = 0.01, periods: float = 100
) -> xr.Dataset:
    r"""The step that keeps the energy, the period and the displacement of a free oscillation within an error.

    A scheme of second order that is (conjugate to) a symplectic one conserves a modified energy
    :math:`E + \Delta t^2 g + O(\Delta t^4)`. For Newmark's methods with γ = ½,
    :math:`g = \dot u^T p' \dot u / 12 + (\beta/2 - 1/24)\, \ddot u^T M \ddot u` and :math:`c = 1/24 - \beta/2`. With
    the integral S of :math:`\ddot u^T M \ddot u` over a period,

    .. math::

        |E - E_0| &\le \Delta t^2 \max |g - g_0| = C_E (\omega\Delta t)^2 (E_0 - E_\text{rest}) \\
        \tilde T - T &= \Delta t^2 (g_0 T'(E) - c S'(E)) = C_T (\omega\Delta t)^2 T

    with the highest frequency ω of the tangent along the motion. From rest, the error of the period of average
    acceleration is −2 times that of central difference, for every potential. The error e of the displacement follows
    from the linearised equation of motion, which the terms of Δt² of the scheme excite. For Newmark's methods

    .. math::

        M \ddot e + p' e = \Delta t^2 (\beta - 1/12) (p' M^{-1} p - p'' \dot u^2), \quad
        e(0) = 0, \quad \dot e(0) = \Delta t^2 (1/6 - \beta) M^{-1} p' \dot u(0)

    in the first period, and e − (n − 1) (T̃ − T) u̇ in the last of n periods. Because the terms of Δt² may cancel, an
    estimate of the next term of the delay is added to the errors of period and displacement,

    .. math::

        \left[2 a_4 + C_E^2 (1 + 1/s)\,(E_0 - E_\text{rest})\, |T'(E)| / (4 T)\right] (\omega\Delta t)^4\, T,
            \quad a_4 = 3\beta^2/8 - \beta/16 + 3/640

    with the distance s to the separatrix; a₄ is that of a linear oscillator. If
    :math:`0 \le p' \le \omega^2 M`, C_E is at most ¼ for central difference and 1/6 for average acceleration, with any
    number of unknowns.

    The bound excludes motions with a load or damping, forces whose tangent jumps or has an infinite slope, and schemes
    that dissipate. Terms of higher order count if a step is longer than ½/ω, or if the tangent changes within a step by
    more than half of its largest size, as on a spring that saturates far from rest, or by more than a quarter of a
    wave, as on a spring with ripples. No step is longer than that. A narrow peak of the tangent is seen if it adds a
    tenth to the change of the force between two of 512 points of the motion.

    In a narrow range of steps that resonate with the motion, the error can be several times the bound: a run with half
    the step shows this. The smoother the force and the shorter the step, the narrower is the range. Where the slope of
    the tangent jumps, as at a stop of quadratic force, there are many: the error was up to twice the allowed one in a
    few of a hundred steps. Near a separatrix C_T grows without bound. A step that keeps the energy may therefore be far
    too long for the period there: ``separatrix_distance`` measures how near the motion is.

    Parameters
    ----------
    problem
        A free oscillator of one unknown with a potential, or the name of one.
    scheme
        A Newmark method with γ = ½, the implicit midpoint rule, or the name of one.
    allowed_error
        Allowed error, a fraction.
    periods
        Number n of periods after which the displacement is within the error.

    Returns
    -------
    xarray.Dataset
        ``coefficient`` C of (ωΔt)², ``step_size`` in s and ``omega_step``, the step times ω, of shape (quantity).
        No step exceeds the stability limit. ``period``, ``highest_frequency`` ω, ``convex_coefficient``, the bound on C
        of the energy for a tangent that is nowhere negative, and ``separatrix_distance``, the least difference of the
        energy from the barriers of the potential beyond the motion and the hills within it, over the energy above rest;
        infinite without both.

    Raises
    ------
    KeyError
        If there is no problem or scheme of that name.
    TypeError
        If the problem or the scheme is of another kind.
    ValueError
        If the problem is not a free oscillator of one unknown with a potential, rests, does not oscillate, is too near
        to a separatrix, or has a force or a tangent that jumps, a tangent with an infinite slope, as where a Hertz
        contact closes, or one that is not the slope of the force; if the scheme has no modified energy; or if
        ``allowed_error`` or ``periods`` is not positive.

    References
    ----------
    E. Hairer, C. Lubich, G. Wanner, Geometric numerical integration, 2nd ed., Springer, 2006, chapter IX.
    """
    for name, value in (("allowed_error", allowed_error), ("periods", periods)):
        if not (is_number(value) and 0 < value < math.inf):
            raise ValueError(f"{name} must be a positive number, not {value!r}.")
    problem = resolve(problem, problems, Problem)
    scheme = resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
    equation, motion = modified_equation(scheme), orbit(problem)
    omega, farthest = motion.highest_frequency, np.max(np.abs(motion.u))
    velocity, error = displacement_error(problem, equation, motion.mass, motion.period, omega)
    in_last_period = error - max(periods - 1, 0) * motion.delay(equation.energy) * velocity
    displacement = np.max(np.abs([error, in_last_period])) / farthest / omega**2
    coefficients = np.append(motion.coefficients(equation.energy), displacement)
    next_delay = motion.next_delay(equation)
    next_terms = np.array([0.0, next_delay, periods * next_delay * motion.period * np.max(motion.v) / farthest])
    omega_step = largest_omega_step(coefficients, allowed_error, scheme, motion.described_up_to, next_terms)
    return xr.Dataset(
        {
            "coefficient": ("quantity", coefficients, {"long_name": "error over (ω Δt)²", "units": "1"}),
            "step_size": (
                "quantity",
                omega_step / omega,
                {"long_name": "largest step size that keeps the error", "units": "s"},
            ),
            "omega_step": (
                "quantity",
                omega_step,
                {"long_name": "step size times the highest frequency of the motion", "units": "1"},
            ),
            "period": ((), motion.period, {"long_name": "period", "units": "s"}),
            "highest_frequency": (
                (),
                omega,
                {"long_name": "largest circular frequency of the tangent along the motion", "units": "s-1"},
            ),
            "separatrix_distance": (
                (),
                motion.separatrix_distance,
                {
                    "long_name": "energy between the motion and the nearest barrier or hill over that above rest",
                    "units": "1",
                },
            ),
            "convex_coefficient": (
                (),
                equation.energy.convex,
                {"long_name": "largest coefficient of the energy where the tangent is nowhere negative", "units": "1"},
            ),
        },
        coords={
            "quantity": (
                "quantity",
                ["energy", "period", "displacement"],
                {"long_name": "quantity; the energy over its height above rest, the displacement over its largest"},
            )
        },
        attrs={
            "title": f"Step bound of '{scheme.title}' on '{problem.title}'",
            "allowed_error": allowed_error,
            "periods": periods,
        },
    )
