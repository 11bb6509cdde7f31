"""Period elongation and damping ratio of every scheme without physical damping, one row per family."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.data import families
from paper.figures.style import PAGE, legend_beside, letter, looks, thinned
from paper.products import figure

#: Largest step size over period, that of the textbooks.
TO = 0.4


@figure("Period elongation and damping by linear theory.", spectral="spectral", asks={"spectral.damping_ratios": [0.0]})
def draw(spectral: xr.Dataset) -> Figure:
    """Elongation in percent (left) and algorithmic damping ratio in percent (right) against Δt/T, where stable."""
    data = spectral.sel(damping_ratio=0.0, dt_over_period=slice(None, TO))
    stable = 2 * np.pi * data.dt_over_period <= data.stability_limit
    elongation, damping = data.period_elongation.where(stable), data.algorithmic_damping.where(stable)
    parts = families(data)
    figure, axes = plt.subplots(len(parts), 2, figsize=(PAGE, 1.35 * len(parts)), sharex=True, squeeze=False)
    for index, (row, (family, part)) in enumerate(zip(axes, parts.items(), strict=True)):
        for thickness, (name, look) in enumerate(looks(part.scheme).items()):
            title = part.scheme_title.sel(scheme=name).item()
            style = look | {"marker": None, "linewidth": thinned(2.4, 0.25, thickness), "label": title}
            row[0].plot(data.dt_over_period, 100 * elongation.sel(scheme=name), **style)
            row[1].plot(data.dt_over_period, 100 * damping.sel(scheme=name), **style)
        row[0].set(ylim=(-30, 60), ylabel="elongation (%)")
        row[1].set(ylim=(-1, 20), ylabel="damping ratio (%)")
        letter(row[0], 2 * index, family)
        letter(row[1], 2 * index + 1, family)
        legend_beside(row[1])
    for ax in axes[-1]:
        ax.set_xlabel("step size over period")
    return figure
