"""Drawn maps of the outcomes of runs."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb

from paper.figures.outcome_map import outcome_map
from paper.figures.style import OUTCOME_STYLES
from study.analysis.outcomes import Outcome


def test_styles_stand_in_the_order_of_the_outcomes():
    assert list(OUTCOME_STYLES) == [outcome.name.lower() for outcome in Outcome]


def test_every_cell_is_drawn_in_its_place():
    amplitudes, parts = np.logspace(-1.5, 1.5, 12), np.logspace(-2, 0, 8)
    outcome = np.random.default_rng(0).integers(0, len(OUTCOME_STYLES), (12, 8))
    unit = ("amplitude", np.ones(12))
    ds = xr.Dataset(
        {"outcome": (("amplitude", "step_size_over_period"), outcome), "highest_frequency": unit, "period": unit},
        {"amplitude": amplitudes, "step_size_over_period": parts},
    )
    figure, ax = plt.subplots(dpi=100)
    outcome_map(ax, ds.assign_coords(scheme_title="Bathe", problem_title="spring"), np.inf)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    drawn = np.asarray(canvas.buffer_rgba())[::-1, :, :3]
    places = np.stack(np.meshgrid(parts, amplitudes), axis=-1).reshape(-1, 2)
    columns, rows = ax.transData.transform(places).astype(int).T
    colours = 255 * np.array([to_rgb(colour) for _, colour in OUTCOME_STYLES.values()])
    np.testing.assert_allclose(drawn[rows, columns], colours[outcome.ravel()], atol=1)
    assert ax.get_label() == "Bathe, spring"
    plt.close(figure)
