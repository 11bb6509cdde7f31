"""The step size that each scheme needs for an allowed error, and the cheapest schemes."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from jaxtyping import Float

from study.analysis.duration import step_exponent
from study.io import flags
from study.sizes import CERTAIN, Kept, unbroken

#: Counts of a run, by name.
COSTS = {
    "force_evaluations": {"long_name": "internal forces evaluated", "units": "1"},
    "tangent_evaluations": {"long_name": "tangents of the internal force evaluated", "units": "1"},
    "factorisations": {"long_name": "linear systems with a new matrix", "units": "1"},
}
#: Quantities of the motion; the one that a problem has is its default. With the energy they are the quantities whose
#: steps are searched and tabulated.
MOTION = ("displacement", "peak drift")
DECIDED = (*MOTION, "energy")
#: Number of unknowns from which on the computing time decides which scheme is the cheapest, because implicit
#: schemes then spend most of it on factorisations.
LARGE = 100
#: Power of the duration with which an error may grow: a phase grows linearly, and quadratically if the period drifts.
GROWTH = 2
#: Bounds of the error of each quantity in a run whose whole motion is right. The bounds of velocity and acceleration
#: admit a scheme that removes an unresolved oscillation but not, at all finer steps, a lasting one from step to step.
WHOLE_MOTION = {"displacement": 0.1, "velocity": 0.75, "acceleration": 1.25, "energy": 0.1}
#: Conditions on the runs, by name.
CONDITIONS = {
    "practice": "steps divide the spacing of a record",
    "any_step": "any steps",
    "whole_motion": "steps divide the spacing of a record, and displacement, velocity, acceleration and energy, if "
    f"measured, are within {', '.join(f'{100 * bound:g}' for bound in WHOLE_MOTION.values())} %",
}
#: Outcomes for a scheme, quantity and allowed error.
FOUND, COARSEST, NONE, UNCERTAIN, NO_VALUE = range(5)
VERDICTS = ("found", "already_the_coarsest_step", "not_even_the_finest_step", "below_the_reference", "no_value")
#: Cost as a multiple of the least, up to which a scheme ties with the cheapest.
TIED = 1.1
#: Kinds of schemes.
KINDS = ("explicit", "implicit")
#: Choices among which a scheme is decided: the condition on its runs, and whether programs must have the scheme.
FILTERS = {
    "all": ("practice", False),
    "codes": ("practice", True),
    "any_step": ("any_step", False),
    "whole_motion": ("whole_motion", False),
}
#: Beginnings of the names of the programs whose schemes the filter ``codes`` admits.
CODES = ("OpenSees", "Abaqus", "LS-DYNA")
#: Attributes of the variables of needs and decisions.
ATTRIBUTES = {
    "step_size": {
        "long_name": "largest admitted step size that keeps the error, as smaller ones tried do",
        "units": "s",
    },
    "steps_per_period": {"long_name": "steps in a time scale", "units": "1"},
    "omega_step": {"long_name": "step size times the highest frequency of the motion", "units": "1"},
    "divides": {
        "long_name": "1 if the step size divides the spacing of a record or is a multiple, or there is none",
        "units": "1",
    },
    "error": {"long_name": "error with this step size from the problem's own start", "units": "1"},
    "largest_error": {"long_name": "largest error with this step size from all starts", "units": "1"},
    "smaller_steps": {"long_name": "number of smaller step sizes that keep the error", "units": "1"},
    "verdict": flags("how the search for the step ended", VERDICTS, np.int8),
    **COSTS,
    "duration": {"long_name": "duration of the run", "units": "s"},
    "exponent": {
        "long_name": "a in: step size proportional to n^(-a) over n periods; NaN if the motion has no such law",
        "units": "1",
    },
    "seconds": {"long_name": "computing time of the run, NaN if it is not the cost", "units": "s"},
    "cost": {"long_name": "variable that decides which scheme is the cheapest"},
    "scheme": {"long_name": "time integration scheme"},
    "scheme_title": {"long_name": "title of the scheme"},
    "ties": {"long_name": "number of schemes that cost as much", "units": "1"},
    "problem": {"long_name": "problem"},
    "problem_title": {"long_name": "title of the problem"},
    "quantity": {"long_name": "quantity whose error is measured"},
    "allowed_error": {"long_name": "largest allowed error", "units": "1"},
    "condition": {
        "long_name": f"condition on the runs: {'; '.join(f'{name}: {words}' for name, words in CONDITIONS.items())}"
    },
    "kind": {"long_name": "kind of scheme"},
    "filter": {
        "long_name": f"choice of schemes and runs; codes: {', '.join(CODES)}; others are conditions on the runs"
    },
    "highest_frequency": {"long_name": "highest circular frequency of small motions", "units": "s-1"},
    "time_scale": {"long_name": "time by which steps are counted", "units": "s"},
    "time_scale_name": {"long_name": "what the time scale is"},
    "spacing": {"long_name": "time between the samples of a record, NaN if there is none", "units": "s"},
    "unknowns": {"long_name": "number of unknowns", "units": "1"},
    "decided": {"long_name": "duration for which steps are decided, in time scales", "units": "1"},
    "starts": {"long_name": "number of starts of a step that is needed", "units": "1"},
    "free_vibration": {"long_name": "1 if steps may be extrapolated to longer durations", "units": "1"},
    "has_kinks": {"long_name": "1 if the force has kinks", "units": "1"},
}

#: Errors of runs over some numbers of periods, and these numbers.
Errors = Float[np.ndarray, "*runs periods"]
Periods = Float[np.ndarray, " periods"]
#: Errors of runs in some quantities.
ErrorsOfQuantities = Float[np.ndarray, "*runs quantities"]
#: Costs and errors of schemes.
Values = Float[np.ndarray, "*places schemes"]


def keeps(error: Errors, periods: Periods, decided: float, allowed: float) -> Kept:
    r"""Whether each run over the decided number n of periods keeps an allowed error, over the first dimensions.

    To exclude an error that is small by cancellation at one duration, the errors over all numbers n' of periods must
    satisfy

    .. math::

        e(n') \le \max(1, (n'/n)^2)\, e_\text{allowed}

    Parameters
    ----------
    error
        Largest errors from the starts that were run over a number of periods; NaN or infinite if a run failed.
    periods
        Numbers of periods.
    decided
        The number n of periods.
    allowed
        Allowed error.
    """
    within: np.ndarray = error <= np.maximum(1.0, (periods / decided) ** GROWTH) * allowed
    return np.all(within, axis=-1)


def moves_right(error: ErrorsOfQuantities, names: Sequence[str]) -> Kept:
    """Whether the errors of a run, over the names of quantities, are within ``WHOLE_MOTION``, if they are bounded."""
    bounded = [k for k, name in enumerate(names) if name in WHOLE_MOTION]
    return np.all(error[..., bounded] <= [WHOLE_MOTION[names[k]] for k in bounded], axis=-1)


def place_of_need(kept: Kept, counted: Kept, proposed: Kept) -> np.ndarray:
    """Place of the largest proposed size that keeps an error, as all smaller sizes do that count; −1 if there is none.

    The sizes ascend along the last axis.
    """
    places = np.arange(kept.shape[-1])
    return np.where(unbroken(kept | ~counted) & counted & proposed, places, -1).max(-1, initial=-1)


def needs(runs: xr.Dataset, allowed_errors: Sequence[float]) -> xr.Dataset:
    """The largest proposed step size that keeps each allowed error, as all smaller step sizes of the scheme do.

    Under a record, the conditions ``practice`` and ``whole_motion`` admit only step sizes that divide its spacing, or
    are multiples of it; others are not counted. Quantities whose steps were not searched are left out.

    Parameters
    ----------
    runs
        Runs of one problem, ``results/runs/PROBLEM.nc``.
    allowed_errors
        Allowed errors, as fractions.

    Returns
    -------
    xarray.Dataset
        Over (scheme, quantity, allowed_error, condition), for the decided duration: ``step_size`` in s,
        ``steps_per_period``, ``omega_step``, ``divides``, the costs of a run, ``error`` at this step size from the
        problem's own start, ``largest_error`` from all starts, ``smaller_steps``, the number of
        smaller step sizes that keep it too, and ``verdict``. A value is NaN where no step keeps the error.
    """
    runs = runs.sortby("step_size").transpose("scheme", "size", "quantity", "periods", ...)
    decided = runs.sel(periods=runs.decided)
    worst = np.fmax(runs.error, runs.largest_error)
    right = moves_right(worst.sel(periods=runs.decided).values, runs.quantity.values)
    searched = [name for name in DECIDED if name in runs.quantity]
    worst, decided = worst.sel(quantity=searched), decided.sel(quantity=searched)
    within = [keeps(worst.values, runs.periods.values, runs.decided.item(), allowed) for allowed in allowed_errors]
    parts = []
    for condition in CONDITIONS:
        meets = right[..., None] | (condition != "whole_motion")
        of_condition = [
            _needed(decided, condition, decided.error.copy(data=meets & kept), allowed)
            for allowed, kept in zip(allowed_errors, within, strict=True)
        ]
        parts.append(xr.concat(of_condition, _index(allowed_error=allowed_errors)))
    ds = xr.concat(parts, _index(condition=list(CONDITIONS)))
    return ds.transpose("scheme", "quantity", "allowed_error", "condition").assign_coords(
        decided.drop_dims("size").drop_vars("periods").coords
    )


def _index(**values: Sequence) -> xr.IndexVariable:
    ((name, along),) = values.items()
    return xr.IndexVariable(name, list(along))


def _needed(runs: xr.Dataset, condition: str, kept: xr.DataArray, allowed: float) -> xr.Dataset:
    """The needs over (scheme, quantity) for one condition and one allowed error; step sizes ascend."""
    sizes, counted = ["step_size", "steps_per_period", "omega_step", "divides"], runs.tried == 1
    if condition != "any_step":
        counted = counted & (runs.divides == 1)
    if condition == "whole_motion" and WHOLE_MOTION.keys().isdisjoint(runs.quantity.values):
        counted = xr.zeros_like(counted)
    kept, proposed = kept & (runs.uncertainty * CERTAIN <= allowed), counted & (runs.proposed == 1)
    place = xr.apply_ufunc(place_of_need, kept, counted, proposed, input_core_dims=[["size"]] * 3)
    at = runs.reset_coords(sizes).isel(size=place.clip(min=0))
    values = at[[*sizes, *COSTS, "error", "largest_error"]]
    smaller = counted & (xr.DataArray(np.arange(runs.sizes["size"]), dims="size") < place)
    values = values.assign(smaller_steps=smaller.sum("size")).where(place >= 0)
    return values.assign(verdict=_verdict(runs, proposed, place, allowed)).reset_coords(drop=True)


def _verdict(runs: xr.Dataset, counted: xr.DataArray, place: xr.DataArray, allowed: float) -> xr.DataArray:
    """Index in ``VERDICTS``, over (scheme, quantity)."""
    last = xr.where(counted, np.arange(runs.sizes["size"]), -1).max("size")
    verdict = xr.where(place < 0, NONE, xr.where(place == last, COARSEST, FOUND))
    verdict = xr.where(runs.uncertainty * CERTAIN > allowed, UNCERTAIN, verdict)
    completed = counted & runs.error.notnull().any("quantity")
    unknown = completed.any("size") & runs.error.where(completed).isnull().all("size")
    none = (~counted.any("size") | unknown) & np.isfinite(runs.uncertainty)
    return xr.where(none, NO_VALUE, verdict).transpose("scheme", "quantity").astype(np.int8)


def joined_needs(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """The needs of several problems over (problem, scheme, quantity, allowed_error, condition), each for its duration.

    ``cost`` is the variable that decides: ``seconds`` from ``LARGE`` unknowns on, otherwise ``force_evaluations``.
    Times are NaN until they are measured.
    """
    datasets = []
    for part in parts:
        problem_needs = part.assign(seconds=part.step_size * np.nan)
        problem_needs = problem_needs.assign_coords(cost="seconds" if part.unknowns >= LARGE else "force_evaluations")
        labels = [name for name in problem_needs.coords if name != "scheme" and "scheme" in problem_needs[name].dims]
        datasets.append(problem_needs.drop_vars(labels).expand_dims("problem"))
    ds = xr.concat(datasets, "problem", join="outer", coords="all", compat="override", data_vars="all")
    return ds.assign(verdict=ds.verdict.fillna(NO_VALUE).astype(np.int8))


def exponents(needed: xr.Dataset) -> xr.DataArray:
    """The exponent a with which a step falls over n periods, over (problem, scheme, quantity).

    It follows the law of :mod:`study.analysis.duration`, and is NaN unless the motion is a free vibration.
    """
    schemes = zip(needed.order.values, needed.order_of_loss.values, strict=True)
    law = [[step_exponent(p, q, name) for name in needed.quantity.values] for p, q in schemes]
    return xr.DataArray(law, dims=("scheme", "quantity")).where(needed.free_vibration == 1)


def cost(needed: xr.Dataset) -> xr.DataArray:
    """The cost by which schemes are compared, over the dimensions of the needs."""
    return needed.seconds.where(needed.cost == "seconds", needed.force_evaluations)


def _place_of_cheapest(costs: Values, errors: Values) -> np.ndarray:
    """Place of the cheapest along the last axis: costs up to ``TIED`` times the least tie, the smallest error decides.

    A cost that is NaN does not count.
    """
    tied = costs <= TIED * np.fmin.reduce(costs, axis=-1, keepdims=True)
    return np.where(tied, np.fmin(errors, np.finfo(float).max), np.inf).argmin(-1)


def cheapest(needed: xr.Dataset, along: str) -> xr.DataArray:
    """Place along a dimension of the cheapest, over the other dimensions; see :func:`decisions`."""
    errors = needed.largest_error.fillna(needed.error)
    return xr.apply_ufunc(_place_of_cheapest, cost(needed), errors, input_core_dims=[[along], [along]])


def decisions(needed: xr.Dataset) -> xr.Dataset:
    """The cheapest scheme of each kind, over (problem, quantity, allowed_error, kind, filter).

    ``scheme`` is its name, empty where no scheme of the kind keeps the error, and ``ties`` the number of schemes that
    cost as much. The other variables are those of the needs. Schemes with up to ``TIED`` times the least
    ``cost`` tie, and the smallest error decides among them.
    """
    parts = []
    for condition, codes_only in FILTERS.values():
        considered, admitted = needed.sel(condition=condition, drop=True), (needed.in_codes == 1) | (not codes_only)
        by_kind = [_decided(considered, admitted & (needed.explicit == flag)) for flag in (1, 0)]
        parts.append(xr.concat(by_kind, _index(kind=KINDS)))
    ds = xr.concat(parts, _index(filter=list(FILTERS)))
    return ds.transpose("problem", "quantity", "allowed_error", "kind", "filter")


def _decided(needed: xr.Dataset, admitted: xr.DataArray) -> xr.Dataset:
    """The decision among the admitted schemes of a dataset of needs."""
    costs, verdict = cost(needed).where(admitted), xr.where(admitted, needed.verdict, NO_VALUE)
    ties = costs <= TIED * costs.min("scheme")
    place, exists = cheapest(needed.where(admitted), "scheme"), ties.any("scheme")
    numbers = needed.drop_vars([str(name) for name in needed.coords if "scheme" in needed[name].dims])
    decision = numbers.isel(scheme=place)
    decision = decision.assign({name: decision[name].where(exists) for name in decision if name != "verdict"})
    verdict = xr.where(exists, decision.verdict, verdict.min("scheme")).astype(np.int8)
    for name in ("scheme", "scheme_title"):
        decision[name] = place.dims, np.where(exists, needed[name].values[place.values], "")
    return decision.assign(verdict=verdict, ties=ties.sum("scheme"))


def ranked(needed: xr.Dataset) -> list[str]:
    """Names of the schemes that keep an error, kind by kind: each is the decision among those that remain.

    ``needed`` has the needs for one problem, quantity, allowed error and condition, over scheme. The kind of the
    decision among both is first.
    """
    costs, errors = cost(needed).values, needed.largest_error.fillna(needed.error).values
    kinds = list[list[int]]()
    for flag in (1, 0):
        remaining, places = np.where(needed.explicit == flag, costs, np.nan), list[int]()
        while not np.isnan(remaining).all():
            places.append(int(_place_of_cheapest(remaining, errors)))
            remaining[places[-1]] = np.nan
        kinds += [places] if places else []
    firsts = np.isin(np.arange(len(costs)), [places[0] for places in kinds])
    best = _place_of_cheapest(np.where(firsts, costs, np.nan), errors)
    return needed.scheme.values[sum(sorted(kinds, key=lambda places: places[0] != best), list[int]())].tolist()


def dominated(measures: xr.DataArray, scheme: str, equal: float = 1e-6) -> list[str]:
    """Schemes that are at least as good as ``scheme`` in every respect, and better in at least one.

    ``measures`` has small numbers for good schemes, over (respect, scheme). Numbers within a relative and absolute
    difference of ``equal`` count as equal, and two infinities too.
    """
    numbers = measures.sel(scheme=scheme).values

    def better(other: np.ndarray) -> bool:
        with np.errstate(invalid="ignore"):
            close = np.isclose(other, numbers, rtol=equal, atol=equal)
        return bool(((other < numbers) | close).all() and ((other < numbers) & ~close).any())

    return [name for name in measures.scheme.values if name != scheme and better(measures.sel(scheme=name).values)]


def keeps_part(needed: xr.Dataset) -> xr.DataArray:
    """Whether a step keeps its quantity, while the whole motion needs another step, or none that was tried keeps it.

    ``needed`` has the dimension ``condition`` of :func:`needs`, and the result has its other dimensions.
    """
    alone, whole = (needed.sel(condition=condition) for condition in ("practice", "whole_motion"))
    return (alone.step_size > 0) & (whole.verdict != NO_VALUE) & (whole.step_size != alone.step_size)
