"""The order of displacement, velocity and acceleration under the circumstances of real problems."""

from functools import partial
from typing import Annotated

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from annotated_types import Ge, Le, Len

from study.algebra.jit import short_runs
from study.analysis.orders import LEAST, observed_order
from study.declaration.experiment import experiment, progress
from study.declaration.options import RisingCounts, Schemes, Tolerances
from study.experiments import coordinates
from study.experiments.circumstances import QUANTITIES, Circumstance, carries, circumstances_with
from study.io import flags
from study.scheme.base import Scheme
from study.scheme.named import schemes as schemes_by_name

#: Whether an order was measured, or why it is missing.
STATUSES = ("measured", "does_not_apply", "failed", "exact")

#: Limits of the fit of an order: smallest and largest error that counts, relative to the motion, and largest number of
#: errors in the fit. The fit takes the errors with the finest steps.
SMALLEST, LARGEST, MOST = 1e-11, 1.0, 4


def _applies(circumstance: Circumstance, scheme: Scheme) -> bool:
    """Whether a scheme can be run under a circumstance."""
    if circumstance.inconsistent:
        state, _ = jax.eval_shape(partial(scheme.start, circumstance.problem), jnp.ones(()), jnp.ones(()), 1.0)
        return carries(state)
    if circumstance.tolerance is not None and scheme.explicit:
        return False
    return not (scheme.refusal(circumstance.problem) or (circumstance.unequal and scheme.needs_equal_steps))


def _order(counts: np.ndarray, error: np.ndarray) -> tuple[float, str]:
    """Order by a least squares fit, and one of ``STATUSES``.

    The fit takes the logarithms of at most ``MOST`` errors that count, with the finest steps. The order is NaN if fewer
    than ``LEAST`` errors count.
    """
    useful = error < LARGEST
    if useful.sum() < LEAST:
        return np.nan, "failed"
    places = np.flatnonzero(useful & (error > SMALLEST))[-MOST:]
    if len(places) < LEAST:
        return np.nan, "exact"
    return observed_order(counts[places], error[places]), "measured"


@experiment("order_under_reality")
@short_runs()
def order_under_reality(
    schemes: Schemes,
    steps: RisingCounts,
    stiffness_ratios: Annotated[list[Annotated[float, Ge(1e2), Le(1e12)]], Len(1, 10)],
    tolerances: Tolerances,
) -> xr.Dataset:
    """Measure the order of displacement, velocity and acceleration of schemes under the circumstances of real problems.

    The error is measured at the end of a run of six units of time. It is the root mean square over twelve motions and
    all unknowns, relative to the root mean square of the exact motion. The order is the slope of the logarithm of the
    error against the logarithm of the step size. Reference motions are exact, or computed by a Runge-Kutta method of
    eighth order with adaptive steps. The acceleration is part of the scheme's state. If the state has none, or the
    accelerations of all stages, the acceleration follows from the equation of motion.

    - ``plain``, ``damping``, ``load``: the oscillator ü + c u̇ + u + u³ = f cos(1.5t − 0.7), free and undamped, with
      c = 0.2, or with f = 1;
    - ``support_0``, ...: two masses on a moving support, held by a spring with each of the ``stiffness_ratios``;
    - ``hysteresis``, ``contact``: an elastoplastic spring, and an oscillator whose mass meets a stop of twenty times
      the stiffness of its spring;
    - ``inconsistent_start``: the oscillator of ``plain``, with an initial acceleration of zero, which violates the
      equation of motion;
    - ``unequal_steps``: the oscillator of ``plain``, with steps that alternate between 4/3 and 2/3 of their mean;
    - ``tolerance_0``, ...: the oscillator of ``plain``, with Newton iterations that end at each of the ``tolerances``.

    Parameters
    ----------
    steps
        Numbers of steps of a run.
    stiffness_ratios
        Stiffness of the spring at the support divided by the stiffness of the spring between the masses.
    tolerances
        Tolerances of Newton's iteration: largest change of the displacement by the last correction, relative to the
        displacement.
    """
    circumstances, counts = circumstances_with(stiffness_ratios, tolerances), np.array(steps)
    shape = len(schemes), len(circumstances), len(QUANTITIES)
    error, order = np.full((*shape, len(steps)), np.nan), np.full(shape, np.nan)
    status = np.full(shape, STATUSES.index("does_not_apply"), np.int8)
    for s, name in enumerate(schemes):
        progress(f"order of {name}")
        for c, circumstance in enumerate(circumstances.values()):
            if not _applies(circumstance, schemes_by_name[name]):
                continue
            error[s, c] = circumstance.errors(schemes_by_name[name], steps)
            for q in range(len(QUANTITIES)):
                order[s, c, q], how = _order(counts, error[s, c, q])
                status[s, c, q] = STATUSES.index(how)
    dims = ("scheme", "circumstance", "quantity")
    titles = [circumstance.title for circumstance in circumstances.values()]
    return xr.Dataset(
        {
            "end_error": ((*dims, "steps"), error, {"long_name": "error at the end over the motion", "units": "1"}),
            "observed_order": (dims, order, {"long_name": "observed order of the errors", "units": "1"}),
            "status": (dims, status, flags("how the order was found", STATUSES, np.int8)),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            "circumstance": ("circumstance", list(circumstances), {"long_name": "circumstance"}),
            "circumstance_title": ("circumstance", titles, {"long_name": "title of the circumstance"}),
            "stiffness_ratio": ("support", list(stiffness_ratios), {"long_name": "stiffness ratio", "units": "1"}),
            "tolerance": ("newton", list(tolerances), {"long_name": "tolerance of Newton's iteration", "units": "1"}),
            "quantity": ("quantity", list(QUANTITIES), {"long_name": "quantity"}),
            "steps": ("steps", list(steps), {"long_name": "number of steps", "units": "1"}),
        },
        attrs={"title": "Order of schemes under the circumstances of real problems"},
    )
