"""Sentences on the reliability of an assessment: the runs that confirm its steps, and its reference."""

import numpy as np
import xarray as xr

from study.analysis.duration import step_exponent
from study.words import listed, measured, number, printed, printed_unit

#: Largest number of components of a quantity whose reference values a page shows.
SHOWN = 6

#: Smallest number of confirming runs for which a bound with 95 % confidence is stated; with fewer, it exceeds 10 %.
ASSURING = 30


def percent(fraction: float) -> str:
    """A fraction in percent, as the page of an assessment prints it."""
    return f"{number(100 * fraction)}\u00a0%"


def confirmation(assessed: xr.Dataset) -> str:
    """Sentences on the steps that confirm recommended steps, and on the confidence; empty if no step is recommended."""
    tried = assessed.steps_tried.values[assessed.recommended_step_size.notnull().values]
    if not tried.size:
        return ""
    fewest, most = tried.min(), tried.max()
    largest = percent(float((assessed.largest_error / assessed.allowed_error).max()))
    # for a program neither confidence nor frequency is stated: some steps are not random, and frequencies are unknown
    is_program = "reason" in assessed
    kind = "finer steps, some of them random," if is_program else "random finer steps"
    assured, unassured = tried[tried >= ASSURING], int(np.sum(tried < ASSURING))
    certainty = ""
    if assured.size:
        bounds = " to ".join(dict.fromkeys(percent(3 / n) for n in (assured.max(), assured.min())))
        certainty = f" With 95 % confidence, at most {bounds} of such steps exceed the allowed error."
    if unassured:
        certainty += (
            f" {unassured} of {len(tried)} recommended steps were confirmed by fewer than {ASSURING} steps, which is "
            "no assurance for the steps that were not tried."
        )
    frequency = (
        " Small motions about points of the motion have frequencies up to "
        f"ω = {assessed.highest_frequency.item():.4g} /s."
    )
    return (
        f"Every recommended step was run, over {assessed.attrs['duration']:.4g} s, and {fewest} to {most} {kind} "
        f"down to a twentieth of it, or to the finest one. Their largest error is {largest} of the allowed error."
        f"{'' if is_program else certainty} {assessed.attrs['starts']} Errors along time are the largest at any step, "
        "and a peak is the largest value at any step."
        f"{'' if is_program else frequency}"
    )


def limits_of_reference(assessed: xr.Dataset) -> str:
    """The remarks, and a sentence if the reference holds only for part of the duration; empty if there are none."""
    sentences = [f"{assessed.attrs['remarks']}."] if assessed.attrs.get("remarks") else []
    duration, requested = assessed.attrs["duration"], assessed.attrs["duration_requested"]
    if duration < requested:
        sentences.append(
            f"Beyond t = {duration:.4g} s of the requested {requested:.4g} s, {assessed.attrs['reference']} and "
            f"{assessed.attrs['witness']} differ by more than the smallest error allows, as they do if neighbouring "
            "motions diverge. All errors are measured up to this time."
        )
    return " ".join(sentences)


def other_durations(assessed: xr.Dataset) -> str:
    """Sentences on the steps for longer durations, by the law of :mod:`study.analysis.duration`."""
    sentence = f"All steps hold for {assessed.attrs['duration']:.4g} s."
    if not assessed.attrs.get("free_vibration"):
        return f"{sentence} A longer duration needs an assessment of its own."
    laws: dict[float, list[str]] = {}
    for scheme in assessed.scheme:
        laws.setdefault(step_exponent(scheme.order.item(), scheme.order_of_loss.item()), []).append(
            scheme.scheme_title.item()
        )
    steps = "; ".join(f"n^(−{number(exponent, 2)}) with {listed(titles)}" for exponent, titles in sorted(laws.items()))
    return (
        f"{sentence} Over n periods of a free vibration that is not chaotic, the step that keeps an error of the "
        f"motion falls with {steps}. study.recommend(..., duration=) extrapolates by this law."
    )


def reference_of(assessed: xr.Dataset) -> str:
    """Sentences on the reference and its uncertainty."""
    attributes, uncertainty = assessed.attrs, assessed.reference_uncertainty
    differences = ", ".join(
        f"{percent(float(uncertainty.sel(quantity=name)))} of {name}" for name in assessed.quantity.values
    )
    if "interpolation" in attributes:
        return (
            f"The reference comes from the program itself: {attributes['reference']}, compared with "
            f"{attributes['witness']}; between the steps, {attributes['interpolation']}. They differ by {differences}."
        )
    return (
        f"The reference comes from {attributes['reference']} and, independently, {attributes['witness']}, both with a "
        f"relative tolerance of {number(attributes['reference_tolerance'])}. They differ by {differences}."
    )


def values_of_reference(assessed: xr.Dataset) -> list[tuple[str, ...]]:
    """Rows of a table of the reference values: the components of each quantity, at most the ``SHOWN`` largest.

    A row has the quantity with its component, the value with its uncertainty and unit, and the time.
    """
    rows: list[tuple[str, ...]] = []
    for name in assessed.quantity.values:
        values = assessed[["reference_value", "reference_value_uncertainty", "reference_time"]].sel(quantity=name)
        table = values.to_dataframe().dropna(subset="reference_value")
        unit = assessed.quantity_units.sel(quantity=name).item()
        for row in table.loc[table.reference_value.abs().nlargest(SHOWN).index].itertuples():
            time = "–" if np.isnan(row.reference_time) else f"{row.reference_time:.4g}"
            numbers = printed(" ± ".join(measured(row.reference_value, row.reference_value_uncertainty)))
            value = numbers if unit == "1" else f"{numbers} {printed_unit(unit)}"
            rows.append((f"{name}, component {row.Index}" if len(table) > 1 else name, value, time))
    return rows
