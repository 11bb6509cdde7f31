"""Linear theory of a scheme, derived from its code.

On the linear oscillator ü + 2ξω u̇ + ω² u = 0, a step is a linear map of the scheme's state. Its matrix, the
amplification matrix, is the derivative of the step by automatic differentiation, so the code has no second set of
formulas. Here ω = 1, so Ω = ωΔt = 2π Δt/T is the step size.

References
----------
T. J. R. Hughes, The finite element method: linear static and dynamic finite element analysis, Prentice-Hall, 1987,
chapter 9.
"""

from functools import cache, partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jax.flatten_util import ravel_pytree
from jaxtyping import Complex, Float

from study.algebra.jit import jit
from study.algebra.scalars import is_number
from study.analysis.eigenvalues import Matrices, Points, Roots, eigenvalues, followed
from study.analysis.orders import observed_order
from study.marching.arguments import resolve
from study.marching.program import unlabelled
from study.marching.stability import amplification_matrix
from study.mechanics.definition import Problem
from study.scheme.base import Scheme
from study.scheme.contract import started
from study.scheme.named import schemes

#: Values that can be converted to an array of shape (points,).
PointsLike = Float[Any, "points"]

#: Values of displacement and velocity for each step size, shape (2, points).
Pairs = Float[np.ndarray, "2 points"]

#: Complex numbers for two starts and each step size, shape (2, points).
ComplexPairs = Complex[np.ndarray, "2 points"]

#: Exponents of growth, shape (2, 2): a row for each start (u₀ or u̇₀), one column for displacement, one for velocity.
Growth = Float[np.ndarray, "2 2"]

#: Largest ρ − 1 that counts as round-off, for a spectral radius ρ.
GROWTH = 1e-8

#: Largest ρ − 1 at half of the stability limit that the search finds. If ρ − 1 is larger there, the scheme counts as
#: unstable at every step size.
WEAK_GROWTH = 1e-11

#: Smallest error of the roots that enters the fit of the order.
ROUND_OFF = 1e-11

#: Number of steps in which overshoot is measured.
OVERSHOOT_STEPS = 64

#: Two large step sizes Ω. The ratio of the motions after one step of each size gives the exponents of growth for Ω → ∞.
LONG = (1e4, 1e6)

#: Δt/T that represents infinity.
INFINITE = 1e12

#: Values of Ω searched for the stability limit: dense up to 12, because explicit schemes have their limits there and
#: symmetric compositions have narrow windows of instability near multiples of π; coarse up to 10⁴.
SEARCHED = np.concatenate([np.linspace(3e-4, 12, 40_000), np.geomspace(12.01, 1e4, 2_000)])

#: Number of step sizes in one call of a compiled function.
TILE = 1024

#: Number of refinements of a stability limit, and number of values of Ω in each refinement.
REFINEMENTS, PARTS = 2, 1_000

#: Long names of the variables of :meth:`LinearTheory.dataset`: first the variables over step sizes, then the numbers.
_LONG_NAMES = {
    "spectral_radius": "spectral radius of the amplification matrix",
    "period_elongation": "relative elongation of the damped period; NaN without oscillation",
    "algorithmic_damping": "damping ratio of the numerical motion, with the oscillator's own; NaN without oscillation",
    "amplitude_decay": "relative loss of amplitude per period; NaN without oscillation",
    "displacement_overshoot": f"largest displacement of {OVERSHOOT_STEPS} steps from rest over the initial one, less "
    "one; NaN where unstable",
    "velocity_overshoot": f"largest velocity of {OVERSHOOT_STEPS} steps from rest over the undamped motion's, "
    "less one; NaN where unstable",
    "stability_limit": "largest ωΔt up to which the spectral radius is at most one; infinite where it always is",
    "infinite_frequency_radius": "spectral radius at infinite frequency",
    "linear_order": "order with which the principal roots approach the exact ones",
    "growth_u_from_u": "exponent of ωΔt with which the displacement of the first long step grows from u₀",
    "growth_v_from_u": "exponent of ωΔt with which the velocity of the first long step over ω grows from u₀",
    "growth_u_from_v": "exponent of ωΔt with which ω times the displacement of the first long step grows from u̇₀",
    "growth_v_from_v": "exponent of ωΔt with which the velocity of the first long step grows from u̇₀",
    "memory": "vectors of the size of u that a step passes to the next",
}


@cache
def _oscillator() -> Problem:
    return Problem(force=lambda u: u, potential=lambda u: u * u / 2, u0=1.0, damping=0.0)


def oscillator(damping_ratio=0.0) -> Problem:
    """The linear oscillator ü + 2ξ u̇ + u = 0, with ω = 1. The checks of a problem run only once, not for every ξ."""
    return eqx.tree_at(lambda problem: problem.damping, _oscillator(), 2 * damping_ratio)


def _matrix(scheme: Scheme, step_size_over_period, damping_ratio) -> jax.Array:
    """Amplification matrix on the oscillator, of shape (m, m)."""
    return amplification_matrix(scheme, oscillator(damping_ratio), 2 * jnp.pi * step_size_over_period)


def _initial_states(scheme: Scheme, step_size_over_period, damping_ratio) -> jax.Array:
    """The scheme's whole states at u = 1 and u̇ = 0, and at u = 0 and u̇ = 1, of shape (2, m)."""

    def state(start):
        return ravel_pytree(
            started(scheme, oscillator(damping_ratio), start[0], start[1], 2 * jnp.pi * step_size_over_period)[0]
        )[0]

    return jax.vmap(state)(jnp.eye(2))


@partial(jit, compiler=eqx.filter_jit)
def _at_each(function, scheme: Scheme, step_size_over_period: np.ndarray, damping_ratio: jax.Array) -> jax.Array:
    return jax.vmap(partial(function, scheme, damping_ratio=damping_ratio))(step_size_over_period)


class NumericalMotion(NamedTuple):
    r"""Period and damping that follow from the principal roots, each of shape (points,).

    .. math::

        \lambda = \exp(\bar\omega\Delta t\,(-\bar\xi \pm i \sqrt{1 - \bar\xi^2}))

    All three attributes are NaN from the first step size at which the principal roots are real, because the motion then
    does not oscillate.

    Attributes
    ----------
    period_elongation
        Relative elongation of the damped period.
    algorithmic_damping
        Damping ratio ξ̄, including the damping of the oscillator.
    amplitude_decay
        Relative loss of amplitude per period, :math:`1 - \exp(-2\pi\bar\xi/\sqrt{1 - \bar\xi^2})`.
    """

    period_elongation: Points
    algorithmic_damping: Points
    amplitude_decay: Points


class LinearTheory:
    r"""Linear theory of a scheme at given step sizes.

    Parameters
    ----------
    scheme
        A name in ``study.schemes``, or your own scheme.
    step_size_over_period
        Step sizes over the undamped period, Δt/T, ascending, of shape (points,). The first must be small, because the
        principal roots are followed from Ω = 0.
    damping_ratio
        ξ of the oscillator, 0 ≤ ξ < 1.

    Attributes
    ----------
    matrices
        Amplification matrices, of shape (points, m, m).
    roots
        Their eigenvalues λ, of shape (points, m).
    spectral_radius
        :math:`\rho = \max|\lambda|`, of shape (points,).

    Raises
    ------
    KeyError
        If there is no such scheme.
    ValueError
        If the step sizes are not positive and ascending, or the damping ratio is out of its range.

    Examples
    --------
    >>> import numpy as np
    >>> import study
    >>> theory = study.LinearTheory("central_difference", np.logspace(-3, 3, 61))
    >>> print(f"stable up to ωΔt = {theory.stability_limit():.3f}")
    stable up to ωΔt = 2.000
    """

    matrices: Matrices
    roots: Roots
    spectral_radius: Points

    def __init__(self, scheme: str | Scheme, step_size_over_period: PointsLike, damping_ratio: float = 0.0):
        scheme = resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
        parts = np.asarray(step_size_over_period)
        if (
            parts.dtype.kind not in "fiu"
            or parts.ndim != 1
            or not parts.size
            or not np.all(np.diff(parts, prepend=0.0) > 0)
            or np.isinf(parts[-1])
        ):
            raise ValueError(
                "step_size_over_period must be positive and ascending, of shape (points,), not "
                f"{step_size_over_period}."
            )
        if not (is_number(damping_ratio) and 0 <= damping_ratio < 1):
            raise ValueError(f"damping_ratio must be at least 0 and less than 1, not {damping_ratio}.")
        self._scheme, self._dt_over_period, self._damping_ratio = scheme, parts, damping_ratio
        self.matrices = self._at_step_sizes(_matrix, parts)
        self.roots = eigenvalues(self.matrices)
        self.spectral_radius = np.abs(self.roots).max(axis=-1)

    def _at_step_sizes(self, function, step_size_over_period) -> np.ndarray:
        """Values of a function at every step size, computed in tiles of the same length.

        One compiled program then serves any number of step sizes. It serves all damping ratios too: zero damping adds
        exact zeros, which change no bit.
        """
        damping = jnp.asarray(float(self._damping_ratio))
        points = len(step_size_over_period)
        tiles = np.pad(np.asarray(step_size_over_period, float), (0, -points % TILE), mode="edge").reshape(-1, TILE)
        return np.concatenate([_at_each(function, unlabelled(self._scheme), tile, damping) for tile in tiles])[:points]

    def _radius(self, step_size_over_period: Points) -> Points:
        return np.abs(eigenvalues(self._at_step_sizes(_matrix, step_size_over_period))).max(axis=-1)

    def _first_unstable(self, omega: Points) -> int | None:
        """Index of the first unstable Ω, searched tile by tile; None if all are stable."""
        for start in range(0, len(omega), TILE):
            unstable = self._radius(omega[start : start + TILE] / (2 * np.pi)) > 1 + GROWTH
            if unstable.any():
                return start + int(np.argmax(unstable))
        return None

    def stability_limit(self) -> float:
        """Ω_crit, up to which the spectral radius is at most one.

        It is infinite if there is no instability up to Ω = 10⁴, and zero if the scheme is unstable at every step size.
        The search uses its own values of Ω. It can miss windows of instability that are narrower than 3e-4, or, beyond
        Ω = 12, narrower than 0.34 % of Ω.
        """
        omega = SEARCHED
        for _ in range(REFINEMENTS + 1):
            first = self._first_unstable(omega)
            if first is None:
                return np.inf
            if first == 0:
                return 0.0
            stable = float(omega[first - 1])
            if self._radius(np.array([stable / 4 / np.pi]))[0] > 1 + WEAK_GROWTH:
                return 0.0  # a weak instability: ρ − 1 grows with a power of Ω
            omega = np.linspace(omega[first - 1], omega[first], PARTS)
        return stable

    def infinite_frequency_radius(self) -> float:
        """ρ∞, the spectral radius for Ω → ∞."""
        return float(self._radius(np.array([INFINITE]))[0])

    def overshoot(self) -> Pairs:
        r"""Overshoot of displacement and velocity in the first 64 steps from u = 1 and u̇ = 0, of shape (2, points).

        It is the largest :math:`|u| - 1` and :math:`|\dot u|/\omega - 1`, and at least zero, the value for the exact
        motion. It is NaN at unstable step sizes.
        """
        state = self._at_step_sizes(_initial_states, self._dt_over_period)[:, 0]
        largest = np.ones((2, len(state)))
        stable = self.spectral_radius <= 1 + GROWTH
        for _ in range(OVERSHOOT_STEPS):
            state = np.einsum("pij,pj->pi", np.where(stable[:, None, None], self.matrices, 0.0), state)
            largest = np.maximum(largest, np.abs(state[:, :2].T))
        return np.where(stable, largest - 1, np.nan)

    def growth(self) -> Growth:
        r"""Exponents of Ω with which the motion after one step grows for Ω → ∞, of shape (2, 2).

        The columns hold the exponents of :math:`|u_1|` and :math:`|\dot u_1|/\omega`. The first row is for a start from
        u = 1 and u̇ = 0, the second for a start from u = 0 and u̇ = ω. Zero means bounded. For a scheme with a stability
        limit the exponents describe its instability.

        References
        ----------
        H. M. Hilber, T. J. R. Hughes, Collocation, dissipation and 'overshoot' for time integration schemes in
        structural dynamics, Earthquake Eng. Struct. Dyn. 6(1), 1978, 99-117.
        X. Zhou, K. K. Tamma, Design, analysis, and synthesis of generalized single step single solve and optimal
        algorithms for structural dynamics, Int. J. Numer. Methods Eng. 59(5), 2004, 597-668.
        """
        ends = np.array(LONG) / (2 * np.pi)
        states = self._at_step_sizes(_initial_states, ends)
        first = np.abs(np.einsum("pij,psj->psi", self._at_step_sizes(_matrix, ends), states)[..., :2])
        slopes = np.log(np.maximum(first[1], 1.0) / np.maximum(first[0], 1.0)) / np.log(LONG[1] / LONG[0])
        return np.maximum(slopes, 0.0)

    @property
    def _exponent(self) -> complex:
        """−ξ + i √(1 − ξ²): the exact motion is exp(exponent · Ω)."""
        return -self._damping_ratio + 1j * np.sqrt(1 - self._damping_ratio**2)

    def _principal_logarithm(self) -> np.ndarray:
        return followed(self.roots, self._exponent, 2 * np.pi * self._dt_over_period)

    def motion(self) -> NumericalMotion:
        """Period and damping of the numerical motion."""
        logarithm = self._principal_logarithm()
        return NumericalMotion(
            period_elongation=self._exponent.imag * 2 * np.pi * self._dt_over_period / logarithm.imag - 1,
            algorithmic_damping=-logarithm.real / np.abs(logarithm),
            amplitude_decay=-np.expm1(2 * np.pi * logarithm.real / logarithm.imag),
        )

    def displacement_factors(self) -> ComplexPairs:
        r"""Factors of the displacement of the principal motion from two starts, of shape (2, points).

        The displacement of the principal motion after n steps, from :math:`u = 1` and :math:`\dot u = 0` and from
        :math:`u = 0` and :math:`\dot u = \omega`, is the real part of

        .. math::

            a_1 \lambda^n, \quad -i a_2 \lambda^n

        Both factors a are one for the exact motion without damping. They are NaN where the principal roots are real.
        """
        roots = np.exp(self._principal_logarithm())
        known = np.isfinite(roots)
        matrices, states = self.matrices[known], self._at_step_sizes(_initial_states, self._dt_over_period)[known]
        left, _, right = np.linalg.svd(matrices - roots[known, None, None] * np.eye(matrices.shape[-1]))
        # the eigenvectors of λ, which the matrix minus λ maps to zero from either side
        rows, columns = left[..., -1].conj(), right[:, -1].conj()
        parts = np.einsum("pj,psj->sp", rows, states) * columns[:, 0] / np.einsum("pj,pj->p", rows, columns)
        factors = np.full((2, len(roots)), complex(np.nan, np.nan))
        factors[:, known] = 2 * parts * [[1], [1j]]
        return factors

    def order(self) -> float:
        r"""Order of accuracy: the order with which the principal roots approach the exact roots, minus one.

        The exact roots are :math:`\exp(\Omega\,(-\xi \pm i \sqrt{1 - \xi^2}))`. The order is fitted to the octave that
        begins with the finest step size whose error is above round-off, or with the finest one if no error is. It is
        NaN if that octave has fewer than three step sizes before the principal roots become real.
        """
        omega = 2 * np.pi * self._dt_over_period
        error = np.abs(np.exp(self._principal_logarithm()) - np.exp(self._exponent * omega))
        first = omega[np.argmax(error > ROUND_OFF)]
        fine = (omega >= first) & (omega <= 2 * first)
        return observed_order(1 / omega, error, fine) - 1

    def dataset(self) -> xr.Dataset:
        """All results as one dataset.

        Returns
        -------
        xarray.Dataset
            ``spectral_radius``, the quantities of :meth:`motion` and the overshoot of displacement and velocity, over
            ``step_size_over_period``. ``stability_limit``, ``infinite_frequency_radius``, ``linear_order``
            (:meth:`order`), the four exponents of :meth:`growth` and ``memory``, the size of the matrices, are single
            numbers.
        """
        motion, (displacement, velocity) = self.motion(), self.overshoot()
        (u_from_u, v_from_u), (u_from_v, v_from_v) = self.growth().tolist()
        values = {
            "spectral_radius": self.spectral_radius,
            **motion._asdict(),
            "displacement_overshoot": displacement,
            "velocity_overshoot": velocity,
            "stability_limit": self.stability_limit(),
            "infinite_frequency_radius": self.infinite_frequency_radius(),
            "linear_order": self.order(),
            "growth_u_from_u": u_from_u,
            "growth_v_from_u": v_from_u,
            "growth_u_from_v": u_from_v,
            "growth_v_from_v": v_from_v,
            "memory": self.matrices.shape[-1],
        }
        dims = ("step_size_over_period",)
        return xr.Dataset(
            {
                name: (dims[: np.ndim(value)], value, {"long_name": _LONG_NAMES[name], "units": "1"})
                for name, value in values.items()
            },
            {
                "step_size_over_period": (
                    dims,
                    self._dt_over_period,
                    {"long_name": "step size over period", "units": "1"},
                ),
                "damping_ratio": (
                    (),
                    self._damping_ratio,
                    {"long_name": "damping ratio of the oscillator", "units": "1"},
                ),
            },
        )
