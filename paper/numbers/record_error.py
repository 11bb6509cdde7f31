"""Numbers of the text: errors of steps under records of several spacings and spectra, measured and predicted."""

import numpy as np
import xarray as xr

from paper.measures.record_error import ONE_CURVE, RANGE, SCHEME, order, over_period, scatter, square_of_step
from paper.measures.shares import share_of_runs
from paper.products import numbers
from paper.wording import share_with
from study.words import listed, number, span

#: Origin of the stochastic records, as the dataset states it.
_STOCHASTIC = "Boore (2003)"


@numbers(
    errors="record_error",
    requires={"record_error.schemes": [SCHEME, "rk4"]},
)
def record_error_numbers(errors: xr.Dataset) -> dict:
    """Ratios of measured and predicted errors, scatter about three predictors, and shares of runs."""
    average = errors.sel(scheme=SCHEME)
    law = average.predicted_error
    ratio = average.error.sel(load="samples") / law
    runs = ratio.notnull()
    steps_per_period = (average.period / errors.step_size).where(runs)
    stochastic = (errors.origin == _STOCHASTIC).values
    first, last = np.flatnonzero(stochastic)[[0, -1]]  # measured records precede them, those of a folder follow
    low, high = np.nanpercentile(ratio, RANGE)
    measured_low, measured_high = np.nanpercentile(ratio.isel(record=~stochastic), RANGE)
    scatters = {
        name: scatter(average, by)
        for name, by in {"law": law, "step": square_of_step(average), "power": average.power_above}.items()
    }

    def within(error):
        return share_with(*share_of_runs((error <= law).where(runs)))

    entries = {
        "record_error_records": errors.sizes["record"],
        "record_error_measured": int(first),
        "record_error_own": errors.sizes["record"] - 1 - int(last) or None,
        "record_error_spacings": listed(f"{1e3 * spacing:g}" for spacing in np.unique(errors.spacing[stochastic])),
        "record_error_runs": int(runs.sum()),
        "record_error_fewest": f"{steps_per_period.min().item():.0f}",
        "record_error_damping": f"{100 * errors.damping_ratio.item():g}",
        "record_error_periods": span(errors.period, "g"),
        "record_error_duration": span(errors.duration[stochastic], ".0f"),
        "record_error_low": number(low, 2),
        "record_error_high": number(high, 2),
        "record_error_measured_low": number(measured_low, 2),
        "record_error_measured_high": number(measured_high, 2),
        "record_error_peak_yielding": within(average.peak_error.sel(spring="yielding")),
        "record_error_one_curve": scatters["law"] < ONE_CURVE < min(scatters["step"], scatters["power"]),
    }
    for load in ("samples", "averages"):
        entries[f"record_error_{load}_most"] = number(over_period(errors, load), 2)
    for name, value in scatters.items():
        entries[f"record_error_scatter_{name}"] = f"{value:.2f}"
    rk4 = errors.sel(scheme="rk4")
    entries["record_error_with_power"] = int(
        ((average.error.sel(load="samples") > 0) & (average.power_above > 0)).sum()
    )
    entries["record_error_rk4_dividing"] = f"{order(rk4, 'samples', True):.1f}"
    return entries
