"""``study.assess`` for a model in another program."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import xarray as xr

from study import io
from study.assessment.dataset import ATTRIBUTES
from study.assessment.scales import Measured, remark_on_components, scaled_from, with_reference
from study.assessment.search import COARSEST_KEEPS, FINEST_FAILS, FOUND, OUT_OF_TIME, UNCERTAIN
from study.assessment.steps import round_step
from study.io import flags, processor
from study.program.attempt import STATUSES
from study.program.curves import INTERPOLATION, Curve
from study.program.definition import Program
from study.program.search import Search
from study.program.truth import Estimate
from study.registry import UnknownName, did_you_mean
from study.scheme.named import schemes as schemes_by_name
from study.sizes import Limit
from study.warn import warn
from study.words import relative_to

#: Attributes of variables in the dataset of a program. The dataset of a problem lacks these variables or describes them
#: otherwise.
PROGRAM_ATTRIBUTES = {
    "status": flags("how the run ended", STATUSES, np.int8),
    "reason": {"long_name": "reason why the run failed"},
    "seconds_per_run": {"long_name": "wall time of the run", "units": "s"},
    "seconds": {
        "long_name": "time of a run with the recommended step, the median of the runs that confirm it",
        "units": "s",
    },
    "seconds_spread": {"long_name": "interquartile range of the times of these runs", "units": "s"},
    "reference_uncertainty": {"long_name": "relative difference of the two reference schemes", "units": "1"},
    "repeated": {"long_name": "relative difference of a repeated run", "units": "1"},
    "highest_frequency": {"long_name": "highest circular frequency of small motions, unknown", "units": "s-1"},
}

#: Names of the variables of a verdict that are NaN if the verdict gives no number.
NUMBERS = (
    "largest_step_size",
    "recommended_step_size",
    "recommended_error",
    "largest_error",
    "seconds",
    "seconds_spread",
    "force_evaluations",
)


def narrowed(program: Program, schemes: str | Sequence[str] | None) -> Program:
    """The program with only some of its schemes; the others become witnesses.

    Raises
    ------
    UnknownName
        If the program has no such scheme.
    """
    names = [schemes] if isinstance(schemes, str) else list(schemes or program.schemes)
    for name in names:
        if name not in program.schemes:
            raise UnknownName(f"'{program.title}' has no scheme {name!r}; {did_you_mean(str(name), program.schemes)}")
    return replace(program, schemes=names, witnesses=[name for name in program.all_schemes if name not in names])


def assess_program(program: Program, allowed: list[float], seconds: float, report: Callable[..., None]) -> xr.Dataset:
    """Result of :func:`study.assess` for a program.

    Raises
    ------
    NoTruth
        If fewer than two schemes run to the end at three successively halved steps, or a quantity is always zero.
    """
    search = Search(program, allowed, round_step, seconds, report)
    remarks = "; ".join([*search.refinement.remarks, *_remarks_on_components(search)])
    if remarks:
        warn(f"{remarks}.")
    names = list(search.truth.uncertainty)
    dts = sorted({dt for name, dt in search.errors if name in program.schemes}, reverse=True)
    ds = _verdicts(search, names, allowed).merge(_runs(search, names, dts))
    known = {name: schemes_by_name.get(name) for name in program.schemes}
    kinds = [("explicit" if scheme.explicit else "implicit") if scheme else "unknown" for scheme in known.values()]
    ds = ds.assign_coords(
        scheme_title=("scheme", [scheme.title if scheme else name for name, scheme in known.items()]),
        kind=("scheme", kinds),
        steps=("step_size", np.floor(program.duration / np.array(dts) * (1 + 1e-9)).astype(int)),
        quantity_title=("quantity", names, {"long_name": "description of the quantity"}),
    )
    ds["reference_uncertainty"] = "quantity", list(search.truth.uncertainty.values())
    ds["repeated"] = "scheme", [search.refinement.noise[name] for name in program.schemes]
    ds["highest_frequency"] = (), np.nan
    ds = with_reference(ds, {name: _measured(curve) for name, curve in search.truth.best.motion.items()})
    for name, attributes in (ATTRIBUTES | PROGRAM_ATTRIBUTES).items():
        ds[name].attrs |= attributes
    best, witness = search.truth.best, search.truth.witness
    ds.attrs = io.provenance(f"Which scheme and which step: {program.title}", "study.assess", io.now()) | {
        "model": f"the program {program.title}, {program.duration:.4g} s\n"
        f"{int((ds.status != STATUSES.index('not_tried')).sum())} runs with steps from {dts[-1]:.4g} to {dts[0]:.4g} s",
        "reference": _described(best),
        "witness": _described(witness),
        "interpolation": INTERPOLATION,
        "starts": "No other start was tried.",
        "duration": program.duration,
        "duration_requested": program.duration,
        "problem": program.title,
        "command": f"study.assess(program, {list(program.schemes)}, allowed_errors={allowed})",
        "processor": processor(),
        "remarks": remarks,
        "folder": str(program.place),
        **({"spacing": program.spacing} if program.spacing else {}),
    }
    return ds


def _measured(curve: Curve) -> Measured:
    """How a quantity is measured, and its value in the reference."""
    reduced = None if curve.quantity is None else curve.quantity.reduce
    if reduced is not None:  # a run of a problem returns it as constant along time
        value = np.atleast_1d(curve.values[-1])
        result = Measured("", value=value, time=np.full(len(value), curve.t[-1] if reduced == "final" else np.nan))
    elif curve.values.ndim:
        flat = curve.values.reshape(len(curve.t), -1)
        time, value = np.transpose([_largest(curve.t, sizes) for sizes in np.abs(flat).T])
        result = Measured("", value=value, time=time, along=(curve.t, flat))
        result = result._replace(scaled_from=scaled_from(curve.quantity, curve.t, flat))
    else:
        result = Measured("", value=np.atleast_1d(curve.values))
    result = result._replace(scale=curve.scale)
    if curve.quantity is not None:
        return result._replace(relative_to=curve.quantity.relative_to(len(result.value)), units=curve.quantity.units)
    relation = relative_to(components=len(result.value))
    return result._replace(relative_to=relation if curve.values.ndim else "relative to the value itself")


def _largest(t: np.ndarray, sizes: np.ndarray) -> tuple[float, float]:
    """Time and largest value of the parabola through the largest of some sizes and its neighbours, or of the former."""
    place = int(sizes.argmax())
    if 0 < place < len(t) - 1:
        before, middle, after = sizes[place - 1 : place + 2]
        rise, bend = (after - before) / 2, 2 * middle - before - after
        if bend > 0:
            return t[place] + rise / bend * (t[place + 1] - t[place]), middle + rise**2 / (2 * bend)
    return t[place], sizes[place]


def _remarks_on_components(search: Search) -> list[str]:
    """Remarks on quantities whose components differ much in size."""
    quantities = search.program.quantities
    remedy = (
        "study.Quantity(..., scale='each') gives each component its own scale"
        if quantities
        else "return them separately"
    )
    return [
        remark
        for name, curve in search.truth.best.motion.items()
        if name not in quantities or quantities[name].scale in ("own", "peak")
        for remark in remark_on_components(name, curve.sizes, remedy)
    ]


def _described(estimate: Estimate) -> str:
    orders = ", ".join(f"{name} by order {order}" for name, order in estimate.order.items())
    return f"{estimate.scheme} down to Δt = {estimate.dt:.4g} s" + (f", extrapolated ({orders})" if orders else "")


def _verdicts(search: Search, names: list[str], allowed: list[float]) -> xr.Dataset:
    rows = []
    for scheme in search.program.schemes:
        for limit in ((name, error) for name in names for error in allowed):
            rows.append(
                {"scheme": scheme, "quantity": limit[0], "allowed_error": limit[1]} | _row(search, scheme, limit)
            )
    table = pd.DataFrame(rows).set_index(["scheme", "quantity", "allowed_error"])
    ds = table.to_xarray().sel(scheme=list(search.program.schemes), quantity=names, allowed_error=allowed)
    return ds.assign(verdict=ds.verdict.astype(np.int8), steps_tried=ds.steps_tried.astype(np.int32))


def _row(search: Search, scheme: str, limit: Limit) -> dict[str, float]:
    """The verdict on a scheme, with the time of a run with the recommended step and the spread of times.

    Both follow from the runs in the octave below this step, whose times are in proportion to their steps: a single run
    may have been slow by other work on the machine.
    """
    runs = {run.dt: run for run in search.refinement.runs_of(scheme)}
    row = dict.fromkeys(NUMBERS, np.nan) | {"verdict": UNCERTAIN, "steps_tried": 0}
    if not search.certain(scheme, limit):
        return row
    needed = search.needed(scheme, limit)
    if search.unfinished(scheme, limit):
        return row | {"verdict": OUT_OF_TIME, "largest_step_size": needed.largest or np.nan}
    if not needed.largest:
        return row | {"verdict": FINEST_FAILS}
    around = [run.seconds * run.dt for run in runs.values() if needed.recommended / 2 <= run.dt <= needed.recommended]
    low, middle, high = np.quantile(around, [0.25, 0.5, 0.75])
    return row | {
        "verdict": COARSEST_KEEPS if needed.largest == max(runs) else FOUND,
        "largest_step_size": needed.largest,
        "recommended_step_size": needed.recommended,
        "steps_tried": needed.tried,
        "largest_error": needed.largest_error,
        "recommended_error": search.errors[scheme, needed.recommended][limit[0]],
        "seconds": middle / needed.recommended,
        "seconds_spread": (high - low) / needed.recommended,
    }


def _runs(search: Search, names: list[str], dts: list[float]) -> xr.Dataset:
    """Error, status, reason and time of every run, by scheme and step."""
    schemes = search.program.schemes
    shape = len(schemes), len(dts)
    error = np.full((*shape, len(names)), np.nan)
    status, seconds = np.full(shape, STATUSES.index("not_tried"), np.int8), np.full(shape, np.nan)
    reason = np.full(shape, "", object)
    per_step = []
    for s, scheme in enumerate(schemes):
        runs = search.refinement.runs_of(scheme)
        for run in runs:
            index = s, dts.index(run.dt)
            error[index] = [search.errors[scheme, run.dt][name] for name in names]
            status[index], reason[index], seconds[index] = STATUSES.index(run.status), run.reason, run.seconds
        finest = next((run for run in reversed(runs) if run.completed), None)
        per_step.append(finest.seconds * finest.dt / search.program.duration if finest else np.nan)
    dims = ("scheme", "step_size")
    return xr.Dataset(
        {
            "error": ((*dims, "quantity"), error),
            "status": (dims, status),
            "reason": (dims, reason.astype(str)),
            "seconds_per_run": (dims, seconds),
            "energy_imbalance": (dims, np.full(shape, np.nan)),
            "newton_iterations_per_step": (dims, np.full(shape, np.nan)),
            "seconds_per_step": ("scheme", per_step),
        },
        {"scheme": list(schemes), "step_size": dts, "quantity": names},
    )
