"""Exact motions of linear and yielding oscillators under records of several spacings and spectra."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from reference import bilinear, linear
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, RecordDuration, RecordPeriods, Sizes
from study.problem.inelastic import yielding_under_record
from study.problem.records import family

#: Factors of the number of parts of an interval between two samples, in each of which events are sought. With the
#: factor 1 every part is as long as the smallest spacing. Peaks are computed with both factors; their difference gives
#: the uncertainty.
FACTORS = (1, 2)
#: Options that determine the records and oscillators.
SHARED = ("spacings", "corners", "kappas", "seeds", "duration", "periods", "reduction")


def _options(configuration: Mapping) -> Options:
    return {key: configuration["record_error"][key] for key in SHARED}


@experiment("reference/record_error", section="record_error", options=_options)
def record_error(
    spacings: Sizes,
    corners: Sizes,
    kappas: Sizes,
    seeds: Count,
    duration: RecordDuration,
    periods: RecordPeriods,
    reduction: Count,
) -> xr.Dataset:
    """Compute exact peaks of linear and yielding oscillators, and the displacement of the linear ones at every sample.

    The strength of a yielding oscillator is the largest force of the elastic one over ``reduction``. Records shorter
    than the longest are padded with NaN. The uncertainty of the peak follows from a second solution that seeks events
    at twice as many instants.
    """
    grounds = family(spacings, corners, kappas, seeds, duration)
    oscillators = [yielding_under_record(grounds[0], period, 1.0) for period in periods]
    of_period = np.array([[one.force.stiffness, one.damping] for one in oscillators])  # type: ignore[attr-defined]
    hardening = float(oscillators[0].force.hardening)  # type: ignore[attr-defined]
    shape, most = (len(grounds), len(periods)), max(len(one.acceleration) for one in grounds)
    ground, u = np.full((len(grounds), most), np.nan), np.full((*shape, most), np.nan)
    peak, uncertainty = np.zeros((2, *shape, 2))
    of_record = np.array([float(one.dt) for one in grounds])
    for row, one in zip(ground, grounds, strict=True):
        row[: len(one.acceleration)] = one.acceleration
    stiffness, damping = np.tile(of_period, (len(grounds), 1)).T
    for spacing in np.unique(of_record):
        progress(f"linear motions under records every {1e3 * spacing:g} ms")
        there = of_record == spacing
        samples = ground[there][:, np.isfinite(ground[there]).all(axis=0)]
        lanes, which = np.repeat(samples, len(periods), axis=0), np.repeat(there, len(periods))
        peak[there, :, 0], u[there, :, : samples.shape[1]] = (
            one.reshape(len(samples), len(periods), *one.shape[1:])
            for one in linear.motions(lanes, spacing, stiffness[which], damping[which])
        )
    progress("motions of yielding oscillators")
    strength = stiffness * peak[..., 0].ravel() / reduction
    lanes, spacing = np.repeat(ground, len(periods), axis=0), np.repeat(of_record, len(periods))
    places = np.maximum(np.round(spacing / of_record.min()), 1).astype(int)
    bent, other = (
        bilinear.motions(lanes, spacing, stiffness, damping, strength, hardening, factor * places)[0]
        for factor in FACTORS
    )
    peak[..., 1] = other.reshape(shape)
    uncertainty[..., 1] = np.abs(bent - other).reshape(shape)
    dims = ("record", "period")
    of_u = {"long_name": "displacement of the linear oscillator at the samples", "units": "m"}
    return xr.Dataset(
        {
            "u": ((*dims, "sample"), u, of_u),
            "peak_drift": ((*dims, "spring"), peak, {"long_name": "peak drift", "units": "m"}),
            "peak_drift_uncertainty": (
                (*dims, "spring"),
                np.maximum(uncertainty, np.spacing(peak)),
                {"long_name": "uncertainty of the peak drift", "units": "m"},
            ),
            "yield_force": (
                dims,
                strength.reshape(shape),
                {"long_name": "force at yield over the mass", "units": "m s-2"},
            ),
            "ground": (("record", "sample"), ground, {"long_name": "acceleration of the ground", "units": "m s-2"}),
            "spacing": (
                "record",
                of_record,
                {"long_name": "time between two samples of the record", "units": "s"},
            ),
        },
        coords={
            "record": ("record", [one.title for one in grounds], {"long_name": "record"}),
            "period": ("period", periods, {"long_name": "period of small motions", "units": "s"}),
            "spring": ("spring", ["linear", "yielding"], {"long_name": "kind of spring"}),
        },
        attrs={"title": "Motions of linear and yielding oscillators under records of several spacings and spectra"},
    )
