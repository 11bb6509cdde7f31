"""Linear theory out of the code itself: everything follows from the derivative of a scheme's step.

On ü + 2ξω u̇ + ω² u = 0 a step is a linear map of the scheme's state, its amplification matrix, and no formula of it is
typed twice. Here ω = 1, so that Ω = ωΔt = 2π Δt/T is the step size.
"""

from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from study.problem.definition import Problem
from study.scheme.base import Scheme
from study.scheme.named import schemes

#: A spectral radius above one by more than this is growth and no round-off.
GROWTH = 1e-8

#: Errors of roots below this are not fitted.
ROUND_OFF = 1e-11

#: How many steps of a run are looked at for overshoot.
OVERSHOOT_STEPS = 64

#: Step size over period that stands for infinity.
INFINITE = 1e12

#: Ω at which a limit of stability is looked for: densely where explicit schemes end, since symmetric compositions have
#: narrow windows of instability near multiples of π, and up to what stands for all.
SEARCHED = np.concatenate([np.linspace(3e-4, 12, 40_000), np.geomspace(12.01, 1e4, 2_000)])

#: Step sizes that are looked at together.
TILE = 1024

#: How often the interval of a limit is narrowed, and into how many parts.
REFINEMENTS, PARTS = 2, 1_000


def oscillator(damping_ratio=0.0) -> Problem:
    """The linear oscillator with ω = 1."""
    return Problem(force=lambda u: u, potential=lambda u: u * u / 2, u0=1.0, damping=2 * damping_ratio)


def amplification_matrix(scheme: Scheme, dt_over_period, damping_ratio) -> jax.Array:
    """Derivative of one step with respect to the scheme's whole state, (m, m); multi-step schemes in companion form."""
    problem, dt = oscillator(damping_ratio), 2 * jnp.pi * dt_over_period
    # any state would do; this one moves in a long step and in a short one, as discrete gradients need
    state, _ = scheme.start(problem, jnp.ones(()), jnp.ones(()), dt)
    flat, unflatten = ravel_pytree(state)

    def step(flat):
        return ravel_pytree(scheme.step(problem, unflatten(flat), 0.0, dt)[0])[0]

    return jax.jacfwd(step)(flat)


def _initial_state(scheme: Scheme, dt_over_period, damping_ratio) -> jax.Array:
    """The whole state, flat, from u = 1 and u̇ = 0."""
    state, _ = scheme.start(oscillator(damping_ratio), jnp.ones(()), jnp.zeros(()), 2 * jnp.pi * dt_over_period)
    return ravel_pytree(state)[0]


@eqx.filter_jit
def _at_each(function, scheme: Scheme, dt_over_period: np.ndarray, damping_ratio: jax.Array) -> jax.Array:
    return jax.vmap(partial(function, scheme, damping_ratio=damping_ratio))(dt_over_period)


class Motion(NamedTuple):
    """What the principal roots λ = exp(ω̄Δt (−ξ̄ ± i √(1 − ξ̄²))) say of the numerical motion, each over step sizes.

    ``period_elongation`` is that of the damped period, ``algorithmic_damping`` the ratio ξ̄ with the oscillator's own in
    it, and ``amplitude_decay`` the loss a period, 1 − exp(−2π ξ̄/√(1 − ξ̄²)). NaN from where the roots are real on, and
    nothing swings.
    """

    period_elongation: np.ndarray
    algorithmic_damping: np.ndarray
    amplitude_decay: np.ndarray


class LinearTheory:
    """A scheme on the linear oscillator at given step sizes.

    Parameters
    ----------
    scheme
        A scheme, or the name of one.
    dt_over_period
        Step sizes over the undamped period, ascending from a fine one, of shape (points,).
    damping_ratio
        ξ of the oscillator, 0 ≤ ξ < 1.

    Attributes
    ----------
    matrices
        Amplification matrices (points, m, m).
    roots
        Their eigenvalues (points, m).
    spectral_radius
        ρ = max |λ|, (points,).

    Raises
    ------
    KeyError
        If there is no such scheme.
    ValueError
        If the step sizes are not positive and ascending, or the damping ratio is out of its range.
    """

    def __init__(self, scheme: str | Scheme, dt_over_period: np.ndarray, damping_ratio: float = 0.0):
        scheme = schemes[scheme] if isinstance(scheme, str) else scheme
        parts = np.asarray(dt_over_period)
        if (
            parts.dtype.kind not in "fiu"
            or parts.ndim != 1
            or not parts.size
            or not np.all(np.diff(parts, prepend=0.0) > 0)
            or np.isinf(parts[-1])
        ):
            raise ValueError(
                f"dt_over_period must be positive and ascending, of shape (points,), not {dt_over_period}."
            )
        if not isinstance(damping_ratio, int | float) or not 0 <= damping_ratio < 1:
            raise ValueError(f"damping_ratio must be at least 0 and less than 1, not {damping_ratio}.")
        self._scheme, self._dt_over_period, self._damping_ratio = scheme, parts, damping_ratio
        self.matrices = self._of_each(amplification_matrix, parts)
        self.roots = _eigenvalues(self.matrices)
        self.spectral_radius = np.abs(self.roots).max(axis=-1)

    def _of_each(self, function, dt_over_period) -> np.ndarray:
        """The function at every step size, in tiles of one length: one program serves grids of all lengths.

        It serves all damping ratios too: without damping its terms are zeros, and add nothing.
        """
        damping = jnp.asarray(float(self._damping_ratio))
        points = len(dt_over_period)
        tiles = np.pad(np.asarray(dt_over_period, float), (0, -points % TILE), mode="edge").reshape(-1, TILE)
        return np.concatenate([_at_each(function, self._scheme, tile, damping) for tile in tiles])[:points]

    def _radius(self, dt_over_period) -> np.ndarray:
        return np.abs(_eigenvalues(self._of_each(amplification_matrix, dt_over_period))).max(axis=-1)

    def _first_unstable(self, omega: np.ndarray) -> int | None:
        """Where Ω is first unstable, looked for tile by tile."""
        for start in range(0, len(omega), TILE):
            unstable = self._radius(omega[start : start + TILE] / (2 * np.pi)) > 1 + GROWTH
            if unstable.any():
                return start + int(np.argmax(unstable))
        return None

    def stability_limit(self) -> float:
        """Ω_crit, up to which the spectral radius is at most one; infinite where it is up to Ω = 10⁴.

        It does not depend on the step sizes of this object. Windows of instability narrower than 3e-4 can be missed.
        """
        omega = SEARCHED
        for _ in range(REFINEMENTS + 1):
            first = self._first_unstable(omega)
            if first is None:
                return np.inf
            if first == 0:
                return 0.0
            stable = float(omega[first - 1])
            omega = np.linspace(omega[first - 1], omega[first], PARTS)
        return stable

    def infinite_frequency_radius(self) -> float:
        """ρ∞, the spectral radius for Ω → ∞."""
        return float(self._radius(np.array([INFINITE]))[0])

    def overshoot(self) -> np.ndarray:
        """Largest |u| − 1 and |u̇|/ω − 1 in the first steps from u = 1 and u̇ = 0, (2, points); NaN where unstable.

        Zero is no overshoot: the exact motion has none.
        """
        state = self._of_each(_initial_state, self._dt_over_period)
        largest = np.ones((2, len(state)))
        stable = self.spectral_radius <= 1 + GROWTH
        for _ in range(OVERSHOOT_STEPS):
            state = np.einsum("pij,pj->pi", np.where(stable[:, None, None], self.matrices, 0.0), state)
            largest = np.maximum(largest, np.abs(state[:, :2].T))
        return np.where(stable, largest - 1, np.nan)

    @property
    def _exponent(self) -> complex:
        """The exact motion is exp(exponent Ω)."""
        return -self._damping_ratio + 1j * np.sqrt(1 - self._damping_ratio**2)

    def _principal_logarithm(self) -> np.ndarray:
        return _followed(self.roots, self._exponent, 2 * np.pi * self._dt_over_period)

    def motion(self) -> Motion:
        """Period and damping of the motion that the principal roots describe."""
        logarithm = self._principal_logarithm()
        return Motion(
            period_elongation=self._exponent.imag * 2 * np.pi * self._dt_over_period / logarithm.imag - 1,
            algorithmic_damping=-logarithm.real / np.abs(logarithm),
            amplitude_decay=-np.expm1(2 * np.pi * logarithm.real / logarithm.imag),
        )

    def order(self) -> float:
        """Order with which the principal roots approach exp(Ω (−ξ ± i √(1 − ξ²))), less one for the number of steps.

        Fitted over an octave of the finest step sizes whose error is above round-off; NaN with fewer than three there.
        """
        omega = 2 * np.pi * self._dt_over_period
        error = np.abs(np.exp(self._principal_logarithm()) - np.exp(self._exponent * omega))
        first = omega[np.argmax(error > ROUND_OFF)]
        fine = (omega >= first) & (omega <= 2 * first) & np.isfinite(error)
        if fine.sum() < 3:
            return np.nan
        return float(np.polyfit(np.log(omega[fine]), np.log(error[fine]), 1)[0]) - 1


def _eigenvalues(matrices: np.ndarray) -> np.ndarray:
    """Eigenvalues (points, m), infinite where a matrix is beyond all numbers."""
    finite = np.isfinite(matrices).all(axis=(1, 2))
    roots = np.full(matrices.shape[:2], complex(np.inf))
    roots[finite] = np.linalg.eigvals(matrices[finite])
    return roots


def _followed(roots: np.ndarray, exponent: complex, omega: np.ndarray) -> np.ndarray:
    """Logarithms of the root that is exp(exponent Ω) for Ω → 0, followed over step sizes; NaN once it is real."""
    result = np.full(len(omega), complex(np.nan, np.nan))
    last, slope = (0.0, 0j), exponent
    for i, (candidates, step) in enumerate(zip(roots, omega, strict=True)):
        expected = last[1] + slope * (step - last[0])
        root = candidates[np.argmin(np.abs(candidates - np.exp(expected)))]
        if abs(root.imag) <= 1e-9 * abs(root):
            break
        # the branch of the logarithm that is nearest: a step may be longer than half a period
        turns = np.round((expected - np.log(root)).imag / (2 * np.pi))
        result[i] = np.log(root) + 2j * np.pi * turns
        slope = (result[i] - last[1]) / (step - last[0])
        last = step, result[i]
    return result
