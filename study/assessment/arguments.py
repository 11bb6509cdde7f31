"""What an assessment of a problem is asked: its arguments, checked."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from study.analysis.linear_theory import LinearTheory
from study.assessment import steps
from study.assessment.errors import DEFAULT, named
from study.assessment.periods import length_of, model_of, remark_on_record
from study.assessment.search import ENERGY
from study.control.controllers import Controller
from study.control.named import controllers
from study.marching.arguments import resolve
from study.mechanics.definition import Problem
from study.mechanics.loads import excited
from study.mechanics.tangent import FINDABLE
from study.observer.motion import Quantity
from study.problem.named import problems
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


@dataclass(frozen=True)
class Question:
    """What an assessment of a problem is asked.

    Attributes
    ----------
    problem
        The problem, scaled by one: it shares a compiled program with the same problem scaled by 0.99 and 1.01.
    schemes, fit
        The chosen schemes, and those of them that can step the problem, by name.
    duration
        Simulated time of the runs, in s.
    given, quantities
        The quantities as they were given, or None, and those that are assessed, by name.
    allowed
        Allowed errors, the largest first.
    maps, controller, seconds
        As in :func:`study.assess`.
    spacing
        Time between the samples of the load, in s; None if it is no record with equal spacing.
    model
        The model in two lines.
    own_schemes
        Names of your own schemes among those that can step the problem.
    remarks
        Remarks on the record and on your own schemes.
    """

    problem: Problem
    schemes: dict[str, Scheme]
    fit: dict[str, Scheme]
    duration: float
    given: Mapping[str, Quantity] | None
    quantities: dict[str, Quantity]
    allowed: list[float]
    maps: bool
    controller: Controller | None
    seconds: float
    spacing: float | None
    model: list[str]
    own_schemes: list[str]
    remarks: list[str]

    @property
    def is_large(self) -> bool:
        """Whether the problem is assessed like a program: its unknowns are many, or one of them has no mass."""
        return np.size(self.problem.u0) > FINDABLE or self.problem.massless


def question_of(
    problem: str | Problem,
    schemes: str | Scheme | Mapping[str, Scheme] | Iterable[str | Scheme] | None,
    duration: float | None,
    quantities: Mapping[str, Quantity] | None,
    allowed: list[float],
    maps: bool,
    controller: str | Controller | None,
    seconds: float,
) -> Question:
    """The arguments of :func:`study.assess` for a problem, checked.

    Raises
    ------
    KeyError, TypeError, ValueError
        As :func:`study.assess`.
    """
    if not isinstance(maps, bool):
        raise TypeError(f"maps must be True or False, not {maps!r}.")
    scaled = excited(resolve(problem, problems, Problem), 1.0, displaced=True)
    chosen, selected = chosen_schemes(schemes), wanted_quantities(quantities, scaled)
    length = length_of(scaled, duration)
    for name, quantity in selected.items():
        if reason := refusal(replace(quantity, name=name), scaled):
            raise ValueError(reason)
    control = None if controller is None else resolve(controller, controllers, Controller)  # type: ignore[type-abstract]
    fit = {name: scheme for name, scheme in chosen.items() if not scheme.refusal(scaled)}
    if not fit:
        raise ValueError(next(iter(chosen.values())).refusal(scaled))
    own = {name: scheme for name, scheme in fit.items() if scheme not in schemes_by_name.values()}
    spacing = steps.spacing(scaled, length)
    return Question(
        problem=scaled,
        schemes=chosen,
        fit=fit,
        duration=length,
        given=quantities,
        quantities=selected,
        allowed=allowed,
        maps=maps,
        controller=control,
        seconds=seconds,
        spacing=spacing,
        model=model_of(scaled, length, spacing),
        own_schemes=list(own),
        remarks=remark_on_record(scaled, spacing) + remarks_on_own(own.values()),
    )
