"""Tongues of instability of Mathieu's equation: where a scheme finds them, against the theory of Hill's equation."""

from collections.abc import Mapping
from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from numpy.polynomial import Chebyshev
from numpy.polynomial.chebyshev import chebpts1
from scipy.special import mathieu_a, mathieu_b

from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Numbers, RisingCounts, Schemes
from study.experiments import coordinates
from study.marching.run import sweep
from study.mechanics.definition import Problem
from study.problem import oscillators

#: Period of the coefficient of the equation.
PERIOD = np.pi
#: Number of values of δ in the interval of a tongue. The determinant is smooth in δ, and the polynomial through it at
#: so many values is exact up to round-off.
NODES = 28
#: Periods before the monodromy matrix is taken, in which the motion forgets states other than u and u̇.
SETTLED = 2
#: Largest imaginary part of a zero that counts as real. Round-off gives a double zero a smaller one.
REAL = 1e-6


def exact_edges(tongue: int, epsilon: np.ndarray) -> np.ndarray:
    """Lower and upper edge δ of a tongue of ü + (δ + 2ε cos 2t) u = 0, the characteristic values bₙ(ε) and aₙ(ε)."""
    return np.stack([mathieu_b(tongue, epsilon), mathieu_a(tongue, epsilon)])


def _interval(tongue: int) -> tuple[float, float]:
    """Range of δ that contains tongue n and no other tongue of the same eigenvalue: n − 1 < √δ < n + 1."""
    return (tongue - 1.0) ** 2, (tongue + 1.0) ** 2


def _oscillator(delta, epsilon, first, second) -> Problem:
    """Mathieu's oscillator from u₀ = ``first`` and u̇₀ = ``second``."""
    return Problem(oscillators.mathieu(delta, epsilon).force, first, second)


def monodromy(scheme: str, steps: int, delta: np.ndarray, epsilon: np.ndarray) -> np.ndarray:
    """Matrices (cases, 2, 2) that take (u, u̇) of a scheme across one period, in ``steps`` steps.

    With two motions as the columns of Xₖ after k periods, the matrix is Xₖ₊₁Xₖ⁻¹. It is exact if u and u̇ determine
    the next step. Otherwise it is the map of the motion after the other states have decayed.
    """
    starts = {"first": np.repeat([1.0, 0.0], len(delta)), "second": np.repeat([0.0, 1.0], len(delta))}
    cases = {"delta": np.tile(delta, 2), "epsilon": np.tile(epsilon, 2)}
    periods = SETTLED + 1
    ds = sweep(_oscillator, scheme, dt=PERIOD / steps, steps=periods * steps, every=steps, over=cases | starts)
    x = np.stack([ds.u.values, ds.v.values]).reshape(2, 2, len(delta), periods + 1).transpose(2, 3, 0, 1)
    return x[:, -1] @ np.linalg.inv(x[:, -2])


def _zeros(delta: np.ndarray, determinants: np.ndarray, interval: tuple[float, float]) -> np.ndarray | None:
    """The two zeros of the determinant within an interval of δ; NaN if its least value is positive.

    ``None`` if neither is the case, because the least value or a zero is not within the interval.
    """
    zeros = Chebyshev.fit(delta, determinants, NODES - 1, domain=interval).roots()
    real = np.sort(zeros.real[(abs(zeros.imag) < REAL) & (interval[0] < zeros.real) & (zeros.real < interval[1])])
    if len(real) not in (0, 2) or determinants.argmin() in (0, NODES - 1):
        return None
    return real if len(real) else np.full(2, np.nan)


def edges(scheme: str, steps: int, tongues: int, epsilon: np.ndarray) -> np.ndarray:
    """Lower and upper edge δ of the first tongues of a scheme, (epsilon, tongue, side); NaN where a tongue is closed.

    The monodromy matrix P has the eigenvalue σ = (−1)ⁿ on the edges of tongue n. The edges are the two zeros of
    det(P − σI) over δ.

    Raises
    ------
    ValueError
        If the steps are so long that a tongue is not near its exact place.
    """
    numbers = range(1, tongues + 1)
    low, high = np.transpose([_interval(n) for n in numbers])
    delta = (low + high)[:, None] / 2 + np.outer(high - low, chebpts1(NODES)) / 2
    cases = np.broadcast_to(delta, (len(epsilon), *delta.shape))
    matrices = monodromy(scheme, steps, cases.ravel(), np.repeat(epsilon, delta.size)).reshape(*cases.shape, 2, 2)
    determinants = np.linalg.det(matrices - np.reshape([(-1) ** n * np.eye(2) for n in numbers], (tongues, 1, 2, 2)))
    sides = np.empty((len(epsilon), tongues, 2))
    for e, t in np.ndindex(sides.shape[:2]):
        zeros = _zeros(delta[t], determinants[e, t], _interval(t + 1))
        if zeros is None:
            raise ValueError(
                f"with {steps} steps per period, tongue {t + 1} of '{scheme}' is not within √δ = {t + 1} ± 1: take "
                "more steps."
            )
        sides[e, t] = zeros
    return sides


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse values of ε for which the edges of a tongue are not within its interval."""
    span = options["epsilon"]
    if span["first"] <= 0:
        return f"epsilon: first, {span['first']}, must be positive, because no tongue is open at ε = 0."
    for tongue in range(1, options["tongues"] + 1):
        (low, high), (lower, upper) = _interval(tongue), exact_edges(tongue, span["last"])
        if not (low < lower and upper < high):
            return f"epsilon: at {span['last']} tongue {tongue} leaves √δ = {tongue} ± 1; last must be smaller."
    return None


@experiment("mathieu", check=_check)
def mathieu(
    schemes: Schemes, epsilon: Numbers, steps_per_period: RisingCounts, tongues: Annotated[int, Ge(1), Le(10)]
) -> xr.Dataset:
    """Find the edges of the tongues of Mathieu's equation that the schemes have, and the edges of theory.

    In a tongue the motion of ü + (δ + 2ε cos 2t) u = 0 grows without bound.

    Parameters
    ----------
    epsilon
        ``first``, ``last`` and ``count`` of the values of ε.
    steps_per_period
        Steps in the period π of the coefficient.
    tongues
        Number of tongues; tongue n starts at δ = n² for ε = 0.

    Returns
    -------
    xarray.Dataset
        ``edge`` has the shape (scheme, steps_per_period, epsilon, tongue, side), ``exact_edge`` the last three.

    References
    ----------
    D. W. Jordan, P. Smith, Nonlinear ordinary differential equations, 4th ed., Oxford University Press, 2007, chapter
    9.
    """
    values = np.linspace(epsilon["first"], epsilon["last"], int(epsilon["count"]))
    edges_by_scheme = []
    for scheme in schemes:
        progress(f"tongues of {scheme}")
        edges_by_scheme.append([edges(scheme, steps, tongues, values) for steps in steps_per_period])
    numbers = range(1, tongues + 1)
    dims = ("epsilon", "tongue", "side")
    return xr.Dataset(
        {
            "edge": (
                ("scheme", "steps_per_period", *dims),
                np.array(edges_by_scheme),
                {"long_name": "edge of a tongue of a scheme, NaN where the tongue is closed", "units": "s-2"},
            ),
            "exact_edge": (
                dims,
                np.stack([exact_edges(n, values) for n in numbers], axis=1).transpose(2, 1, 0),
                {"long_name": "edge of a tongue, a characteristic value of Mathieu's equation", "units": "s-2"},
            ),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "epsilon": ("epsilon", values, {"long_name": "half the amplitude of the coefficient", "units": "s-2"}),
            "tongue": ("tongue", list(numbers), {"long_name": "number of the tongue", "units": "1"}),
            "side": ("side", ["lower", "upper"], {"long_name": "side of the tongue"}),
        },
        attrs={"title": "Tongues of instability of Mathieu's equation by scheme and step size", "problem": "mathieu"},
    )
