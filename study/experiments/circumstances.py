"""Problems with exact motions, on which the order of schemes is measured, and the errors of runs at their end."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import xarray as xr
from scipy.integrate import solve_ivp

from study.control.controllers import Prescribed
from study.marching.run import sweep
from study.materials import elastoplastic
from study.mechanics.balance import acceleration
from study.mechanics.definition import Problem
from study.mechanics.loads import HarmonicLoad
from study.mechanics.newton import ending_at
from study.mechanics.terms import StrainEnergy
from study.observer.base import Reduction
from study.scheme.base import Scheme, Wrapper
from study.words import printed

#: Quantities that are compared.
QUANTITIES = ("displacement", "velocity", "acceleration")

#: Duration of every run. Initial velocities of the runs or, on a moving support, amplitudes of the slow mode. An
#: error is the root mean square over these runs.
DURATION, SPEEDS = 6.0, np.linspace(0.6, 1.4, 12)

#: Deviation of unequal steps from their mean, relative to the mean. Larger and smaller steps alternate.
UNEQUAL = 1 / 3

#: Relative and absolute tolerance of the reference motions, computed by Dormand and Prince's method of eighth order.
TOLERANCES = {"rtol": 1e-13, "atol": 1e-14}


def carries(state: Any) -> bool:
    """Whether a state contains one acceleration; the states of some schemes contain the accelerations of all stages."""
    return hasattr(state, "a") and state.a.shape == state.u.shape


class AtTheEnd(Reduction):
    """Displacement, velocity and acceleration at the end of a run.

    The acceleration is part of the state. If the state contains none, or the accelerations of all stages, the
    acceleration follows from the equation of motion.
    """

    variables: ClassVar = {name: {"long_name": name, "units": "1"} for name in QUANTITIES}

    def start(self, problem, state):
        """The initial time, zero."""
        return jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        """The time at the end of the step."""
        return t

    def result(self, carried, problem, state):
        """Displacement, velocity and acceleration of the last state."""
        inner = state
        while hasattr(inner, "inner"):
            inner = inner.inner
        a = inner.a if carries(inner) else acceleration(problem, carried, state.u, state.v)
        return dict(zip(QUANTITIES, (state.u, state.v, a), strict=True))


class FromNoAcceleration(Wrapper):
    """A scheme that starts with zero acceleration instead of the acceleration from the equation of motion.

    References
    ----------
    G. M. Hulbert, T. J. R. Hughes, An error analysis of truncated starting conditions in step-by-step time integration:
    consequences for structural dynamics, Earthquake Eng. Struct. Dyn. 15(7), 1987, 901-910.
    """

    scheme: Scheme
    title: str = eqx.field(default="From no acceleration", static=True)

    family: ClassVar[str] = "From no acceleration"
    source: ClassVar[str] = "Hulbert and Hughes (1987)"
    doi: ClassVar[str] = "10.1002/eqe.4290150710"

    def start(self, problem, u0, v0, dt):
        """State of the wrapped scheme at t = 0, with zero acceleration."""
        state, effort = self.scheme.start(problem, u0, v0, dt)
        return state._replace(a=jnp.zeros_like(state.a)), effort

    def step(self, problem, state, t, dt):
        """A step of the wrapped scheme."""
        return self.scheme.step(problem, state, t, dt)


class LooselyBalanced(Wrapper):
    """A scheme whose Newton iterations end at a given tolerance, as is usual in practice.

    References
    ----------
    M. A. Crisfield, Non-linear finite element analysis of solids and structures, vol. 1, Wiley, 1991.
    """

    scheme: Scheme
    tolerance: float = eqx.field(static=True)
    title: str = eqx.field(default="Loosely balanced", static=True)

    family: ClassVar[str] = "Loosely balanced"
    source: ClassVar[str] = "Crisfield (1991)"
    doi: ClassVar[str] = ""

    def start(self, problem, u0, v0, dt):
        """State of the wrapped scheme at t = 0."""
        with ending_at(self.tolerance):
            return self.scheme.start(problem, u0, v0, dt)

    def step(self, problem, state, t, dt):
        """A step of the wrapped scheme."""
        with ending_at(self.tolerance):
            return self.scheme.step(problem, state, t, dt)


@dataclass(frozen=True)
class Circumstance:
    """A problem, the initial motions of its runs, and its exact motions.

    Attributes
    ----------
    title
        Name in figures.
    problem
        The problem, whose initial displacement and velocity the runs replace.
    u0, v0
        Initial displacements and velocities, each of shape (runs, ...).
    exact
        Displacement, velocity and acceleration at the end, each of the shape of ``u0``.
    unequal, inconsistent
        Whether steps alternate between two sizes, and whether the initial acceleration is set to zero.
    tolerance
        Tolerance of Newton's iteration; with None the iteration ends at round-off.
    """

    title: str
    problem: Problem
    u0: np.ndarray
    v0: np.ndarray
    exact: Mapping[str, np.ndarray]
    unequal: bool = False
    inconsistent: bool = False
    tolerance: float | None = None

    def final(self, scheme: Scheme, counts: list[int]) -> tuple[xr.Dataset, np.ndarray]:
        """Motions at the end for each number of steps, and whether each run was completed, (steps, runs)."""
        runs, most = len(self.u0), len(counts)
        if self.inconsistent:
            scheme = FromNoAcceleration(scheme=scheme)
        if self.tolerance is not None:
            scheme = LooselyBalanced(scheme=scheme, tolerance=self.tolerance)
        shared: dict[str, Any] = {"observe": [AtTheEnd()]}
        if self.unequal:
            each = [
                sweep(
                    self.problem,
                    scheme,
                    controller=Prescribed(DURATION / count * np.array([1 + UNEQUAL, 1 - UNEQUAL])),
                    duration=DURATION,
                    u0=self.u0,
                    v0=self.v0,
                    **shared,
                )
                for count in counts
            ]
            ds = xr.concat(each, "lane")
        else:
            steps = np.repeat(counts, runs)
            starts = (np.tile(start, (most, *[1] * (start.ndim - 1))) for start in (self.u0, self.v0))
            u0, v0 = starts
            ds = sweep(self.problem, scheme, dt=DURATION / steps, steps=steps, u0=u0, v0=v0, **shared)
        return ds, (ds.status.values == 0).reshape(most, runs)

    def errors(self, scheme: Scheme, counts: list[int]) -> np.ndarray:
        """Errors relative to the root mean square of the motion, (quantities, steps); NaN if a run did not complete."""
        ds, completed = self.final(scheme, counts)
        relative = np.full((len(QUANTITIES), len(counts)), np.nan)
        for q, name in enumerate(QUANTITIES):
            exact = self.exact[name]
            difference = ds[name].values.reshape(len(counts), *exact.shape) - exact
            squares = (difference**2).reshape(len(counts), -1).mean(axis=1)
            relative[q] = np.where(completed.all(axis=1), np.sqrt(squares / (exact**2).mean()), np.nan)
        return relative


def _by_adaptive_steps(rates: Callable, u0: np.ndarray, v0: np.ndarray, *internal: float) -> dict[str, np.ndarray]:
    """Exact motions at ``DURATION`` by the equations y' = rates(t, y), with y = (u, u̇, internal variables)."""
    ends = []
    for u, v in zip(u0, v0, strict=True):
        y = solve_ivp(rates, (0.0, DURATION), [u, v, *internal], "DOP853", **TOLERANCES).y[:, -1]
        ends.append([y[0], y[1], rates(DURATION, y)[1]])
    return dict(zip(QUANTITIES, np.array(ends).T, strict=True))


# These functions are defined once, so that problems that differ only in numbers share the compiled program.


def _hardening(u):
    return u + u * u * u


def _energy_of_hardening(u):
    return u * u / 2 + u**4 / 4


def _stretches(u):
    return jnp.stack([u[0], u[1] - u[0]])


def _densities(stiffness, stretches):
    return stiffness * stretches**2 / 2


def _smooth(title: str, damping: float = 0.0, amplitude: float = 0.0, **more: Any) -> Circumstance:
    """The oscillator ü + c u̇ + u + u³ = f cos(1.5t − 0.7) from u₀ = 1."""
    u0, v0, load = np.ones(len(SPEEDS)), SPEEDS, HarmonicLoad(amplitude, frequency=1.5, phase=0.7)

    def rates(t, y):
        return [y[1], amplitude * np.cos(1.5 * t - 0.7) - damping * y[1] - y[0] - y[0] ** 3]

    problem = Problem(
        _hardening, 1.0, potential=_energy_of_hardening, damping=damping, load=load, title="hardening oscillator"
    )
    return Circumstance(title, problem, u0, v0, _by_adaptive_steps(rates, u0, v0), **more)


def _contact() -> Circumstance:
    """The oscillator ü + u + 20 max(u − ½, 0) = 0 from u₀ = 0, a mass that meets a stop."""
    u0, v0 = np.zeros(len(SPEEDS)), SPEEDS

    def rates(t, y):
        return [y[1], -y[0] - 20 * max(y[0] - 0.5, 0.0)]

    problem = Problem(
        lambda u: u + 20 * jnp.maximum(u - 0.5, 0.0),
        0.0,
        potential=lambda u: u * u / 2 + 10 * jnp.maximum(u - 0.5, 0.0) ** 2,
        title="contact",
    )
    return Circumstance("contact", problem, u0, v0, _by_adaptive_steps(rates, u0, v0))


def _hysteresis() -> Circumstance:
    """An elastoplastic spring with k = 1, a yield force of ½ and b = 0.1, from u₀ = 0."""
    limit, hardening, u0, v0 = 0.5, 0.1, np.zeros(len(SPEEDS)), SPEEDS

    def rates(t, y):
        u, v, elastic = y
        yields = abs(elastic) >= limit and elastic * v > 0
        return [v, -hardening * u - (1 - hardening) * np.clip(elastic, -limit, limit), 0.0 if yields else v]

    problem = Problem(elastoplastic(stiffness=1.0, yield_force=limit, hardening=hardening), 0.0, title="hysteresis")
    return Circumstance("hysteresis", problem, u0, v0, _by_adaptive_steps(rates, u0, v0, 0.0))


def _support(ratio: float) -> Circumstance:
    r"""Two masses in a row on a support that moves by g = cos(1.5t − 0.7); a spring of stiffness κ holds the first.

    .. math::

        \ddot u_1 + (\kappa + 1)\,u_1 - u_2 = \kappa g, \quad \ddot u_2 + u_2 - u_1 = 0

    The exact motion is the sum of the slow mode and the response to the load. The fast mode is at rest.
    """
    load_frequency, phase = 1.5, 0.7
    soft = 1 - load_frequency**2  # by the second equation the response has u₁ = soft · u₂
    second = ratio / ((ratio + soft) * soft - 1)
    response = np.array([soft * second, second])
    # the smaller root ω² of ω⁴ − (κ + 2) ω² + κ = 0, in a form without cancellation
    square = 2 * ratio / (ratio + 2 + np.sqrt(ratio**2 + 4))
    mode, frequency = np.array([1 - square, 1.0]), np.sqrt(square)

    def motion(t: float, derivative: int) -> np.ndarray:
        turn = derivative * np.pi / 2
        forced = load_frequency**derivative * np.cos(load_frequency * t - phase + turn) * response
        free = frequency**derivative * np.cos(frequency * t + turn) * mode
        return forced + np.outer(SPEEDS, free)

    problem = Problem(
        potential=StrainEnergy(_stretches, eqx.Partial(_densities, np.array([ratio, 1.0]))),
        u0=np.zeros(2),
        load=HarmonicLoad(np.array([ratio, 0.0]), frequency=load_frequency, phase=phase),
        title="moving support",
    )
    exact = {name: motion(DURATION, derivative) for derivative, name in enumerate(QUANTITIES)}
    return Circumstance(f"support {printed(f'{ratio:.0e}')}", problem, motion(0.0, 0), motion(0.0, 1), exact)


def circumstances_with(ratios: list[float], tolerances: Sequence[float] = ()) -> dict[str, Circumstance]:
    """All circumstances, by name."""
    return {
        "plain": _smooth("plain"),
        "damping": _smooth("damping", damping=0.2),
        "load": _smooth("load", amplitude=1.0),
        **{f"support_{i}": _support(ratio) for i, ratio in enumerate(ratios)},
        "hysteresis": _hysteresis(),
        "contact": _contact(),
        "inconsistent_start": _smooth("inconsistent start", inconsistent=True),
        "unequal_steps": _smooth("unequal steps", unequal=True),
        **{
            f"tolerance_{i}": _smooth(f"Newton {printed(f'{tolerance:.0e}')}", tolerance=tolerance)
            for i, tolerance in enumerate(tolerances)
        },
    }
