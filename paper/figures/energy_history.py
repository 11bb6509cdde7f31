"""Energy error of the schemes against time, which the paper describes and does not show."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.asks import steps_of_portrait
from paper.figures.style import PAGE, letter, looks
from paper.products import figure

#: Steps of which the largest error is drawn.
STRETCH = 20


def _envelope(error: xr.DataArray, steps: int) -> xr.DataArray:
    """Largest |error| within each ``steps`` samples: the oscillation within a period would blacken the panel."""
    return abs(error).isel(t=slice(1, None)).coarsen(t=steps, boundary="trim").max()


@figure(
    "Energy error of the seven schemes against time.",
    portraits=["phase_portrait/hardening", "phase_portrait/softening"],
    asks={
        "phase_portrait.hardening": steps_of_portrait("phase_portrait.hardening", STRETCH),
        "phase_portrait.softening": steps_of_portrait("phase_portrait.softening", STRETCH),
    },
)
def draw(portraits: list[xr.Dataset]) -> Figure:
    """One panel per problem: the largest |E − E₀|/E₀ in each stretch of 20 steps, on a logarithmic scale."""
    figure, axes = plt.subplots(1, len(portraits), figsize=(PAGE, 0.4 * PAGE), sharey=True)
    for index, (ax, portrait) in enumerate(zip(axes, portraits, strict=True)):
        for name, look in looks(portrait.scheme).items():
            run = portrait.sel(scheme=name)
            envelope = _envelope(run.energy_error, STRETCH)
            marked = (0.05, 0.15) if envelope.notnull().any() else None  # matplotlib marks no curve without points
            ax.plot(envelope.t, envelope, label=run.scheme_title.item(), markevery=marked, **look)
        ax.set(xlabel="elapsed time $t$ (s)", yscale="log")
        letter(ax, index, portrait.problem_title)
    axes[0].set_ylabel("energy error (%)")
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=4)
    return figure
