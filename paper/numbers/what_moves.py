"""Numbers of the text: what moves collapse intensity, drift and residual drift of a yielding mass with P-Δ."""

import numpy as np
import xarray as xr

from paper.measures.shares import with_interval
from paper.measures.what_moves import (
    CHOSEN,
    QUANTITIES,
    SINGLE,
    choice_spread,
    coarsest_step,
    median_changes,
    record_changes,
    without_drift,
)
from paper.products import numbers
from study.words import listed, number, span

#: Changes of the answer for a single record that count, and that are large.
NOTICED, LARGE = 0.01, 0.05
#: Distance from zero within which the end of an interval depends on the resampling.
TOUCHES = 0.001


def _spacings(ratio: float) -> str:
    return "the spacing" if ratio == 1 else f"{number(ratio, 3)} times the spacing"


def _most(changes: xr.DataArray, beyond: float) -> str:
    """Largest share, over the periods, of the records whose answer changes by more than ``beyond``, with its period.

    It is "none" if no record has an answer.
    """
    shares = (changes > beyond).where(changes.notnull()).mean("record")
    if shares.isnull().all():
        return "none"
    period = shares.period[shares.argmax("period")].item()
    return f"{with_interval(changes.sel(period=period).dropna('record') > beyond)} at {period:g} s"


@numbers(moves="what_moves")
def what_moves_numbers(moves: xr.Dataset) -> dict:
    """Changes of medians and of single records by step, damping, strength and choice of records."""
    collapsed = [f"{period:g}" for period in without_drift(moves)]
    entries = {
        "moves_runs": f"{int(moves.runs):,}",
        "moves_scheme": moves.scheme.item().replace("_", " "),
        "moves_records": moves.sizes["record"],
        "moves_failed": int(moves.failed.sum()),
        "moves_spacing": f"{1e3 * moves.spacing.item():g}",
        "moves_parts": int(moves.parts),
        "moves_intensity": f"{moves.intensity.item():g}",
        "moves_periods": listed(f"{period:g}" for period in moves.period.values),
        "moves_without_drift": listed(collapsed) if collapsed else None,
        "moves_single_share": f"{100 * SINGLE:g}",
        "moves_touches": f"{100 * TOUCHES:g}",
        "moves_chosen": CHOSEN[-1],
        "moves_hardening": f"{100 * moves.hardening.item():g}",
        "moves_p_delta": f"{100 * moves.p_delta.item():g}",
        "moves_collapse": f"{moves.collapse.item():.3g}",
    }
    smaller, most, unclear = [], [], []
    for name in QUANTITIES:
        quantity, short = moves[name], name.partition("_")[0]
        medians = median_changes(quantity)
        change, damping = 100 * medians.change, medians.sel(variant="damping")
        around_zero = (damping.low * damping.high < 0) | (np.minimum(abs(damping.low), abs(damping.high)) < TOUCHES)
        if len(periods := damping.period.values[around_zero.values]):
            unclear.append(f"the {name.replace('_', ' ')} at {listed(f'{period:g}' for period in periods)} s")
        single = record_changes(quantity).sel(variant="spacing")
        entries[f"moves_{short}_single"] = _most(single, NOTICED)
        entries[f"moves_{short}_worst"] = number(100 * float(single.where(np.isfinite(single)).max()), 3)
        entries[f"moves_{short}_large"] = _most(single, LARGE)
        coarsest = coarsest_step(quantity)
        entries[f"moves_{short}_coarsest"] = _spacings(coarsest) if np.isfinite(coarsest) else "none"
        known = abs(change).dropna("period")
        smaller.append(known.size and (known.sel(variant="spacing") < known.sel(variant="damping")).all())
        chosen = xr.concat([choice_spread(quantity, count) for count in CHOSEN], "choice").min("choice")
        most.append(
            known.size and (100 * chosen > known.sel(variant=["spacing", "damping", "strength"]).max("variant")).all()
        )
    collapse = 100 * median_changes(moves.collapse_intensity).change
    for variant in ("spacing", "damping"):
        entries[f"moves_collapse_{variant}"] = span(collapse.sel(variant=variant), "+.1f").replace("-", "−")
    entries["moves_collapse_choice"] = span(100 * choice_spread(moves.collapse_intensity, CHOSEN[-1]), ".0f")
    entries["moves_damping_unclear"] = listed(unclear) if unclear else None
    entries["moves_step_is_least"] = bool(np.all(smaller))
    entries["moves_choice_is_most"] = bool(np.all(most))
    return entries
