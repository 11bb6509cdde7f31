"""Exact motions of linear and yielding oscillators under records of several spacings and spectra."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from reference import bilinear, linear
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, Folder, RecordDuration, RecordPeriods, Sizes
from study.mechanics.ground import GroundMotion
from study.problem.inelastic import yielding_under_record
from study.problem.records import family, files_in

#: Factors of the number of parts of an interval between two samples, in each of which events are sought. With the
#: factor 1 every part is as long as the smallest spacing. Peaks are computed with both factors; their difference gives
#: the uncertainty.
FACTORS = (1, 2)
#: Largest spacing of a record over the shortest period. Half a period must be longer than the spacing.
LONGEST_SPACING = 0.4
#: Options that determine the records and oscillators.
SHARED = ("spacings", "corners", "kappas", "seeds", "duration", "periods", "reduction", "folder")


def _options(configuration: Mapping) -> Options:
    return {key: configuration["record_error"][key] for key in SHARED if key in configuration["record_error"]}


def _files(options: Options) -> list[str]:
    return [str(path) for path in files_in(options["folder"])] if "folder" in options else []


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse records that cannot be read, or whose samples are too far apart for the exact motions."""
    try:
        grounds = [GroundMotion.read(path) for path in _files(options)]
    except (OSError, ValueError) as error:
        return f"folder: {error}"
    for ground in grounds:
        if ground.dt > LONGEST_SPACING * min(options["periods"]):
            return (
                f"folder: the samples of '{ground.title}' are {ground.dt:g} s apart, and must be at most "
                f"{LONGEST_SPACING:g} of the shortest of record_error.periods apart, {min(options['periods']):g} s."
            )
    return None


@experiment("reference/record_error", section="record_error", options=_options, files=_files, check=_check)
def record_error(
    spacings: Sizes,
    corners: Sizes,
    kappas: Sizes,
    seeds: Count,
    duration: RecordDuration,
    periods: RecordPeriods,
    reduction: Count,
    folder: Folder | None = None,
) -> xr.Dataset:
    """Compute exact peaks of linear and yielding oscillators, and the displacement of the linear ones at every sample.

    The strength of a yielding oscillator is the largest force of the elastic one over ``reduction``. The records in the
    files of ``folder`` follow the stochastic ones. Records shorter than the longest are padded with NaN. The
    uncertainty of the peak follows from a second solution that seeks events at twice as many instants.
    """
    grounds = family(spacings, corners, kappas, seeds, duration, folder)
    oscillators = [yielding_under_record(grounds[0], period, 1.0) for period in periods]
    coefficients = np.array([[oscillator.force.stiffness, oscillator.damping] for oscillator in oscillators])  # type: ignore[attr-defined]
    hardening = float(oscillators[0].force.hardening)  # type: ignore[attr-defined]
    counts = np.array([len(record.acceleration) for record in grounds])
    shape, most = (len(grounds), len(periods)), counts.max()
    ground, u = np.full((len(grounds), most), np.nan), np.full((*shape, most), np.nan)
    peak, uncertainty = np.zeros((2, *shape, 2))
    record_spacings = np.array([float(record.dt) for record in grounds])
    for row, record in zip(ground, grounds, strict=True):
        row[: len(record.acceleration)] = record.acceleration
    stiffness, damping = np.tile(coefficients, (len(grounds), 1)).T
    for spacing, count in np.unique([record_spacings, counts], axis=1).T:
        progress(f"linear motions under records of {count:.0f} samples every {1e3 * spacing:g} ms")
        alike = (record_spacings == spacing) & (counts == count)
        samples = ground[alike, : int(count)]
        lanes, mask = np.repeat(samples, len(periods), axis=0), np.repeat(alike, len(periods))
        peak[alike, :, 0], u[alike, :, : samples.shape[1]] = (
            values.reshape(len(samples), len(periods), *values.shape[1:])
            for values in linear.motions(lanes, spacing, stiffness[mask], damping[mask])
        )
    progress("motions of yielding oscillators")
    strength = stiffness * peak[..., 0].ravel() / reduction
    lanes, spacing = np.repeat(ground, len(periods), axis=0), np.repeat(record_spacings, len(periods))
    places = np.maximum(np.round(spacing / record_spacings.min()), 1).astype(int)
    bent, refined = (
        bilinear.motions(lanes, spacing, stiffness, damping, strength, hardening, factor * places)[0]
        for factor in FACTORS
    )
    peak[..., 1] = refined.reshape(shape)
    uncertainty[..., 1] = np.abs(bent - refined).reshape(shape)
    dims = ("record", "period")
    attributes = {"long_name": "displacement of the linear oscillator at the samples", "units": "m"}
    return xr.Dataset(
        {
            "u": ((*dims, "sample"), u, attributes),
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
                record_spacings,
                {"long_name": "time between two samples of the record", "units": "s"},
            ),
        },
        coords={
            "record": ("record", [record.title for record in grounds], {"long_name": "record"}),
            "origin": ("record", [record.source for record in grounds], {"long_name": "origin of the record"}),
            "period": ("period", periods, {"long_name": "period of small motions", "units": "s"}),
            "spring": ("spring", ["linear", "yielding"], {"long_name": "kind of spring"}),
        },
        attrs={"title": "Motions of linear and yielding oscillators under records of several spacings and spectra"},
    )
