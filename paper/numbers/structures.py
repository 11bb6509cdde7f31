"""Numbers of the text: structures."""

import numpy as np
import xarray as xr

from paper.claims.ledger import by_name
from paper.claims.structures import SAMPLES_OF_SAWTOOTH, fails_to, kept, sawtooth
from paper.data import TURNING
from paper.figures.energy_growth import CEILING, FLOOR, sizes
from paper.products import numbers
from paper.requirements import samples_of_history
from paper.wording import joined
from study.words import printed, span

#: Schemes without numerical damping with which the text compares the energy-momentum method.
UNDAMPED = ["average_acceleration", "central_difference", "implicit_midpoint", "gauss4"]
#: Relative change of an error from the second finest step to the finest. Below this change, still finer steps do not
#: reduce the error.
LEVEL = 0.3


def _in_a_sentence(title: str) -> str:
    """The title of a structure within a sentence, such as "the stiff bar" or "Duffing's oscillator, chaotic"."""
    return f"the {title}".replace("the Duffing,", "Duffing's oscillator,")


def _plateaus(structures: xr.Dataset) -> dict[str, str | None]:
    """Errors of two schemes on the stiff and soft spring in percent; None if not run or if finer steps reduce them."""
    names = "gauss4", "bathe"
    nothing: dict[str, str | None] = {f"plateau_{name}": None for name in names}
    if "stiff_soft" not in structures.problem or not set(names) <= set(structures.scheme.values):
        return nothing
    error = structures.displacement_error.sel(problem="stiff_soft", scheme=list(names))
    *_, before, last = error.transpose("steps_per_period", "scheme").values
    if not (abs(before / last - 1) < LEVEL).all():
        return nothing
    return {f"plateau_{name}": f"{100 * value:.1g}" for name, value in zip(names, last, strict=True)}


@numbers(
    reference="reference/elastic_pendulum",
    stiff_soft="structure_history/stiff_soft",
    long_times="structure_history/long_times",
    stiff_bar="structure_history/stiff_bar",
    stiff_truss="structure_history/stiff_truss",
    requires={
        "structures.lengths.problem": ["elastic_pendulum", "fpu_chain"],
        "structures.schemes": [*UNDAMPED, "energy_momentum"],
        "structure_history.stiff_soft.schemes": ["average_acceleration", "bathe"],
        "structure_history.stiff_soft": samples_of_history(SAMPLES_OF_SAWTOOTH),
        "structure_history.long_times.problem": "fpu_chain",
        "structure_history.long_times.schemes": ["central_difference", "implicit_midpoint", "energy_momentum", "bathe"],
        "structure_history.long_times": samples_of_history(1),
    },
)
def of_structures(
    structures: xr.Dataset,
    reference: xr.Dataset,
    stiff_soft: xr.Dataset,
    long_times: xr.Dataset,
    stiff_bar: xr.Dataset,
    stiff_truss: xr.Dataset,
) -> dict:
    """Energies of stiff and rotating structures, and the tolerance of a reference."""
    runs = kept(structures, TURNING)
    most_steps_per_period = by_name(fails_to(runs))
    alternating = sawtooth(stiff_soft.v.isel(component=0))
    change = by_name(100 * long_times.max_sum_change)
    own, exact = (
        sum(long_times[f"{prefix}oscillatory_energy_{spring}"] for spring in (1, 2, 3)) for prefix in ("", "reference_")
    )
    exact_change = 100 * abs(exact / own.isel(t=0, scheme=0) - 1).max().item()
    turning = [stiff_bar, stiff_truss]
    fails = ~runs.sel(scheme="average_acceleration")
    finest_failing = fails.steps_per_period.where(fails).max("steps_per_period")
    return {
        "structure_schemes": structures.sizes["scheme"],
        "most_unknowns": int(structures.unknowns.max()),
        "structure_titles": joined(map(_in_a_sentence, structures.problem_title.values), {}),
        "turning_titles": joined(map(_in_a_sentence, runs.problem_title.values), {}),
        "trapezoidal_fails_turning": most_steps_per_period["average_acceleration"] > 0,
        "momentum_method_stable": bool(np.isnan(most_steps_per_period["energy_momentum"]))
        and all(most_steps_per_period[name] > 0 for name in UNDAMPED),
        "structure_tolerance": f"{np.log10(reference.rtol):.0f}",
        "turning_fails_to": span(finest_failing, ".0f"),
        **{
            f"fails_to_{name}": None if np.isnan(most) else f"{most:.0f}"
            for name, most in most_steps_per_period.items()
        },
        **{f"sawtooth_{name}": f"{a:.2g}" for name, a in zip(stiff_soft.scheme.values, alternating, strict=True)},
        "chain_best": f"{100 * structures.displacement_error.sel(problem='fpu_chain').min().item():.2g}",
        "long_time": f"{long_times.t.max().item():,.0f}",
        "sum_exact": f"{exact_change:.1f}",
        "sum_exact_until": f"{long_times.t_reference.max().item():.0f}",
        "long_step": f"{long_times.step_size.item():.2f}",
        **_plateaus(structures),
        "stiff_soft_steps": stiff_soft.steps_per_period.item(),
        "stiff_bar_steps": stiff_bar.steps_per_period.item(),
        "stiff_truss_steps": stiff_truss.steps_per_period.item(),
        "growth_ceiling": printed(f"{CEILING:.0e}") if any((sizes(one) > CEILING).any() for one in turning) else None,
        "growth_floor": printed(f"{FLOOR:.0e}") if any((sizes(one) < FLOOR).any() for one in turning) else None,
        "growth_fails": any((one.status != 0).any() for one in turning),
        **{f"sum_{name}": f"{value:.0f}" if value > 10 else f"{value:.1f}" for name, value in change.items()},
    }
