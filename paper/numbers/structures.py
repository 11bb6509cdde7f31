"""Numbers of the text: structures."""

import numpy as np
import xarray as xr

from paper.claims.ledger import by_name
from paper.claims.structures import TURNING, kept, sawtooth
from paper.figures.oscillatory_energies import total
from paper.tables.structures import STEPS_PER_PERIOD


def of_structures(structures: xr.Dataset, reference: xr.Dataset, history: dict[str, xr.Dataset]) -> dict:
    """Energies of stiff structures and of those that turn, and how well one of them is known."""
    data = {"structures": structures}
    runs = kept(data, TURNING)
    lost = by_name((~runs).sum(["problem", "steps_per_period"]))
    stiff_soft, long_times = history["stiff_soft"], history["long_times"]
    alternating = sawtooth(stiff_soft.v.isel(component=0))
    oscillatory = total(long_times)
    change = by_name(100 * abs(oscillatory / oscillatory.isel(t=0) - 1).max("t"))
    return {
        "structures_shown": structures.sizes["problem"],
        "structure_tolerance": f"{np.log10(reference.rtol):.0f}",
        "turning_runs": runs.sizes["problem"] * runs.sizes["steps_per_period"],
        **{f"lost_{name}": number for name, number in lost.items()},
        **{f"sawtooth_{name}": f"{a:.2f}" for name, a in zip(stiff_soft.scheme.values, alternating, strict=True)},
        "chain_best": f"{100 * structures.displacement_error.sel(problem='fpu_chain').min().item():.0f}",
        "long_time": f"{long_times.t.max().item():,.0f}",
        "long_sample": f"{long_times.t[1].item():.0f}",
        "long_step": f"{long_times.dt.item():.2f}",
        "structures_steps": STEPS_PER_PERIOD,
        **{
            f"{name}_steps": history[name].steps_per_period.item()
            for name in ("stiff_soft", "stiff_bar", "stiff_truss")
        },
        **{f"sum_{name}": f"{value:.0f}" if value > 10 else f"{value:.1f}" for name, value in change.items()},
    }
