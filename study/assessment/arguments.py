"""Checks of the arguments of an assessment."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from study.analysis.linear_theory import LinearTheory
from study.assessment.errors import DEFAULT, named
from study.assessment.search import ENERGY
from study.marching.arguments import resolve
from study.mechanics.definition import Problem
from study.observer.motion import Quantity
from study.scheme.base import Scheme
from study.scheme.contract import check_attributes
from study.scheme.named import schemes as schemes_by_name

#: Default schemes of an assessment: schemes that codes and textbooks offer.
USUAL = (
    "average_acceleration",
    "central_difference",
    "newmark_dissipative",
    "wilson_theta",
    "houbolt",
    "hht_alpha",
    "generalized_alpha",
    "bathe",
    "rho_bathe",
    "rk4",
)

#: Ratios of step to period at which the stability of your own scheme is examined.
FINE = np.logspace(-3, 0, 31)
#: Largest difference of a stated order from that of linear theory, and largest loss of amplitude in a period at steps
#: below ``COARSE`` over the period with which a scheme keeps the energy.
OFF_ORDER, COARSE, KEPT = 0.5, 0.05, 1e-8

#: Least allowed error.
LEAST_ERROR = 1e-10


def _checked(choice: str | Scheme) -> Scheme:
    scheme = resolve(choice, schemes_by_name, Scheme)  # type: ignore[type-abstract]
    check_attributes(scheme)
    return scheme


def chosen_schemes(schemes: str | Scheme | Mapping[str, Scheme] | Iterable[str | Scheme] | None) -> dict[str, Scheme]:
    """The given schemes, or the default ones, by their names in the dataset."""
    if schemes is None:
        return {name: schemes_by_name[name] for name in USUAL}
    if isinstance(schemes, Mapping) and schemes:
        return {name: _checked(choice) for name, choice in schemes.items()}
    if not isinstance(schemes, str | Scheme | Iterable):
        raise TypeError(f"schemes must be names, schemes, or a mapping from names to schemes, not {schemes!r}.")
    chosen: dict[str, Scheme] = {}
    for choice in [schemes] if isinstance(schemes, str | Scheme) else schemes:
        scheme = _checked(choice)
        name = schemes_by_name.resolve(choice) if isinstance(choice, str) else scheme.title
        if name in chosen:
            raise ValueError(f"two schemes have the name '{name}'; give a mapping from names to schemes.")
        chosen[name] = scheme
    if not chosen:
        raise ValueError("schemes is empty; name at least one, or leave schemes out for the default ones.")
    return chosen


def remarks_on_own(schemes: Iterable[Scheme]) -> list[str]:
    """Remarks on your own schemes that linear theory contradicts, or that are unstable at every step without damping.

    Steps for longer durations follow from the order and from ``keeps_energy``.
    """
    remarks = []
    for scheme in schemes:
        theory = LinearTheory(scheme, FINE)
        if scheme.explicit and not theory.stability_limit() > 0:
            remarks.append(f"{scheme.title} is unstable without damping at every step")
        if (order := theory.order()) < scheme.order - OFF_ORDER:
            remarks.append(f"{scheme.title} has the order {order:.1f} in linear theory, and states {scheme.order}")
        decay = np.abs(theory.motion().amplitude_decay[FINE < COARSE])
        if scheme.keeps_energy and decay.max() > KEPT:
            remarks.append(f"{scheme.title} does not keep the energy in linear theory, and states keeps_energy")
    return remarks


def checked_errors(allowed: Sequence[float]) -> list[float]:
    """The distinct allowed errors, the largest first."""
    values = np.atleast_1d(np.asarray(allowed))
    if values.dtype.kind not in "fiu" or not values.size or not np.all((values > 0) & (values < 1)):
        raise ValueError(
            f"allowed_errors must be fractions between 0 and 1, such as 0.01 for one percent, not {allowed}."
        )
    if values.min() < LEAST_ERROR:
        raise ValueError(
            f"allowed_errors must be at least {LEAST_ERROR:g}, not {values.min():g}: no reference in double precision "
            "is accurate enough for smaller errors."
        )
    return sorted(set(values.tolist()), reverse=True)


def refusal(quantity: Quantity, problem: Problem) -> str | None:
    """Why a quantity cannot be assessed, in one sentence; None if it can."""
    if quantity.needs_acceleration and problem.history is not None:
        return (
            f"the quantity '{quantity.name}' takes ü, which does not follow from u and u̇ where the force of "
            f"'{problem.title}' has a history; leave it out."
        )
    return quantity.refusal(problem)


def wanted_quantities(quantities: Mapping[str, Quantity] | None, problem: Problem) -> dict[str, Quantity]:
    """The given quantities, or the default ones that the problem has, by their names in the dataset."""
    if quantities is None:
        quantities = {name: quantity for name, quantity in DEFAULT.items() if not refusal(quantity, problem)}
    chosen = named(quantities)
    if ENERGY in chosen:
        raise ValueError(f"the name '{ENERGY}' is reserved for the balance of energies; give the quantity another one.")
    return chosen
