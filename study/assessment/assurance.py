"""Sentences on the reliability of an assessment: the runs that confirm its steps, and its reference."""

import xarray as xr

from study.words import number


def percent(fraction: float) -> str:
    """A fraction in percent, as the page of an assessment prints it."""
    return f"{number(100 * fraction)}\u00a0%"


def confirmation(assessed: xr.Dataset) -> str:
    """Sentences on the steps that confirm recommended steps, and on the confidence; empty if no step is recommended."""
    tried = assessed.steps_tried.values[assessed.recommended_dt.notnull().values]
    if not tried.size:
        return ""
    few, many = tried.min(), tried.max()
    bounds = " to ".join(percent(3 / n) for n in (many, few))
    worst = percent(float(assessed.worst_error.max()))
    # for a program neither confidence nor frequency is stated: some steps are not random, and frequencies are unknown
    of_program = "reason" in assessed
    kind = "finer steps, some of them random," if of_program else "random finer steps"
    certain = (
        f" With 95 % confidence, at most {bounds} of such steps exceed the allowed error; the bound falls with the "
        "number of steps tried."
    )
    frequency = (
        " Small motions about points of the motion have frequencies up to "
        f"ω = {assessed.highest_frequency.item():.4g} /s."
    )
    return (
        f"Every recommended step was run, over {assessed.attrs['duration']:.4g} s, and {few} to {many} {kind} "
        f"down to a twentieth of it, or to the finest one. Their largest error is {worst} of the allowed error."
        f"{'' if of_program else certain} {assessed.attrs['starts']} Errors along time are the largest at any step, "
        "and a peak is the largest value at any step."
        f"{'' if of_program else frequency}"
    )


def limits_of_reference(assessed: xr.Dataset) -> str:
    """The remarks on a program, or a sentence if the reference holds only for part of the duration; otherwise empty."""
    if assessed.attrs.get("remarks"):
        return f"{assessed.attrs['remarks']}."
    held, requested = assessed.attrs["duration"], assessed.attrs["duration_requested"]
    if held >= requested:
        return ""
    return (
        f"Beyond t = {held:.4g} s of the requested {requested:.4g} s, {assessed.attrs['reference']} and "
        f"{assessed.attrs['witness']} differ by more than the smallest error allows, as they do if neighbouring "
        "motions diverge. All errors are measured up to this time."
    )


def reference_of(assessed: xr.Dataset) -> str:
    """Sentences on the reference and its uncertainty."""
    attributes, off = assessed.attrs, assessed.reference_uncertainty
    differences = ", ".join(f"{percent(float(off.sel(quantity=name)))} of {name}" for name in assessed.quantity.values)
    if "interpolation" in attributes:
        return (
            f"The reference comes from the program itself: {attributes['reference']}, compared with "
            f"{attributes['witness']}; between the steps, {attributes['interpolation']}. They differ by {differences}."
        )
    return (
        f"{attributes['reference']} and, independent of it, {attributes['witness']}, both with a relative tolerance of "
        f"{attributes['reference_tolerance']:g}. They differ by {differences}."
    )
