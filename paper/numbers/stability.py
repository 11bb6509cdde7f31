"""Numbers of the text: maps of stability, several roots and chaos."""

import numpy as np
import xarray as xr

from paper.claims.ledger import by_name
from paper.measures.outcomes import FAILURES, SPAN, fewest_steps, is_outcome, most_steps, near_1996
from paper.products import numbers
from paper.published import PROBLEMS
from paper.requirements import contained
from paper.terms import CHAOTIC, DAMPED, DISSIPATIVE, FAITHFUL
from paper.wording import joined
from study.words import at_most, listed, span


@numbers()
def long_time_numbers(long_times: xr.Dataset) -> dict:
    """Growth and size of round-off."""
    last = long_times.isel(periods=-1)
    return {
        "lasting_periods": f"{last.periods.item():,}",
        "lasting_steps": long_times.steps_per_period.item(),
        "lasting_runs": long_times.runs.item(),
        "lasting_double": span(long_times.energy_exponent),
        "lasting_energy": at_most(100 * last.energy_round_off.max().item()),
        "lasting_phase": at_most(last.phase_round_off.max().item()),
    }


def _lost_left_of_the_limit(atlas: xr.Dataset, spectral: xr.Dataset) -> xr.DataArray:
    """Share of failed runs among the runs of explicit schemes with ωΔt below a finite linear limit, (scheme, problem).

    Here ω is the highest frequency along the motion.
    """
    limits = spectral.stability_limit.sel(damping_ratio=0.0, scheme=atlas.scheme)
    explicit = atlas.isel(scheme=np.flatnonzero((atlas.explicit.values == 1) & np.isfinite(limits.values)))
    limit = limits.sel(scheme=explicit.scheme)
    below = explicit.step_size_over_period * explicit.period * explicit.highest_frequency < limit
    lost = sum(is_outcome(explicit, name) for name in FAILURES) > 0
    dims = ["amplitude", "step_size_over_period"]
    return ((lost & below).sum(dims) / below.sum(dims)).transpose("scheme", "problem")


@numbers(
    atlas="stability/atlas",
    roots="stability/roots",
    bifurcation="stability/bifurcation",
    requires={
        "": contained("atlas.schemes", within="spectral.schemes"),
        "atlas.schemes": DAMPED,
        "energy_error.problems": PROBLEMS,
        "energy_error.schemes": FAITHFUL,
        "energy_error.steps_per_period": [20],
        "spectral.damping_ratios": [0.0],
        "atlas.problems": ["hardening", "softening", "double_well"],
        "stability.roots.problem": "double_well",
        "stability.roots.schemes": ["average_acceleration"],
        "stability.bifurcation.problem": "double_well",
        "stability.bifurcation.scheme": "average_acceleration",
    },
)
def stability_numbers(
    atlas: xr.Dataset,
    roots: xr.Dataset,
    bifurcation: xr.Dataset,
    spectral: xr.Dataset,
    energy_error: xr.Dataset,
) -> dict:
    """Outcomes on the maps, several roots of a step, onset of chaos, and steps that suffice at all amplitudes."""
    chaotic = (bifurcation.lyapunov_exponent * bifurcation.step_size > CHAOTIC).values.astype(int)
    onset = bifurcation.step_size.values[chaotic.argmax()]
    several = roots.unique_up_to.sel(scheme="average_acceleration")
    unique = ((bifurcation.step_size >= onset) & (bifurcation.step_size < several)).values
    # NaN for step sizes that are not between the onset of chaos and the onset of several roots
    in_chaos = roots.steps_together.where((roots.step_size >= onset) & (roots.step_size < several))
    lost_left = _lost_left_of_the_limit(atlas, spectral)
    fewest = fewest_steps(atlas, 0.1)
    average_steps = fewest.sel(scheme="average_acceleration")
    tables = 100 * energy_error.max_energy_error.sel(period_used="printed", steps_per_period=20)
    on_springs = tables.sel(problem=PROBLEMS, scheme=FAITHFUL)
    at_all_amplitudes = average_steps.fillna(np.inf)
    finer = (fewest.sel(scheme=FAITHFUL).fillna(np.inf) > 20).any("problem")
    twenty = fewest.sel(problem="hardening") <= 20
    near = near_1996(atlas)
    by_scheme = {
        name: is_outcome(near, name).any(["problem", "amplitude", "step_size_over_period"]) for name in FAILURES
    }
    at_rest = by_scheme["damped_to_rest"]
    untouched = ~(by_scheme["chaotic"] | by_scheme["growing"] | by_scheme["unbounded"])
    return {
        "maps": atlas.sizes["scheme"] * atlas.sizes["problem"],
        "map_points": atlas.sizes["amplitude"] * atlas.sizes["step_size_over_period"],
        "map_periods": atlas.periods.item(),
        "map_schemes": atlas.sizes["scheme"],
        "map_span": f"{SPAN:g}",
        "map_chaotic_schemes": int(by_scheme["chaotic"].sum()),
        "map_untouched": joined(atlas.scheme_title.values[untouched.values], {}),
        "damped_end_at_rest": bool(
            (at_rest & ~by_scheme["chaotic"] & ~by_scheme["growing"]).sel(scheme=DISSIPATIVE).all()
        ),
        "twenty_not_everywhere": bool((on_springs <= 10).all() and finer.all()),
        "chaos_before_roots": bool(onset < several),
        "chaos_from": f"{onset:.2f}",
        "chaotic_exponent": f"{CHAOTIC:g}",
        "chaotic_steps": f"{chaotic[unique].sum()} of the {unique.sum()}",
        "unique_average_acceleration": f"{several.item():.2f}",
        "together": f"{in_chaos.median().item():.0f}",
        "together_span": span(in_chaos, ".0f"),
        "lost_left": listed(
            f"{listed(f'{100 * share:.0f}' for share in shares.values)} % with {shares.scheme_title.item()}"
            for shares in lost_left.sel(problem=["hardening", "softening", "double_well"])
        ),
        "softening_needs_more": bool(
            at_all_amplitudes.sel(problem="softening") > at_all_amplitudes.sel(problem="hardening")
        ),
        **{
            f"needed_{name}": f"{value:.0f}" if np.isfinite(value) else most_steps(atlas)
            for name, value in by_name(average_steps).items()
        },
        "needed_twenty": joined(atlas.scheme_title.values[twenty.values], {}),
    }
