"""Looks of curves, titles of panels, and how figures are saved."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

from paper.figures.linear_accuracy import draw
from paper.figures.style import legend_beside, letter, looks, save

COLOURS = ["#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00"]


def _names(number):
    return xr.DataArray([f"scheme {index}" for index in range(number)])


def test_a_scheme_looks_the_same_however_many_follow():
    seven, many = looks(_names(7)), looks(_names(50))
    assert [look["color"] for look in seven.values()] == COLOURS
    assert seven.items() <= many.items()
    assert len({str(look) for look in many.values()}) == 50


@pytest.mark.parametrize("index, title", [(0, "(a) u"), (25, "(z) u"), (26, "(aa) u"), (53, "(bbb) u")])
def test_panels_are_lettered_beyond_the_alphabet(index, title):
    figure, ax = plt.subplots()
    letter(ax, index, "u")
    assert ax.get_title(loc="left") == title
    plt.close(figure)


def _spectral(number):
    """Linear theory of schemes of one family."""
    dims = ("scheme", "dt_over_period", "damping_ratio")
    values = (dims, np.linspace(0, 0.1, number * 20).reshape(number, 20, 1))
    names = _names(number).values
    return xr.Dataset(
        {
            "period_elongation": values,
            "algorithmic_damping": values,
            "stability_limit": (dims[::2], np.ones((number, 1))),
        },
        {"scheme": names, "dt_over_period": np.linspace(0.01, 0.4, 20), "damping_ratio": [0.0]}
        | {"scheme_title": ("scheme", names), "family": ("scheme", ["Own"] * number)},
    )


@pytest.mark.parametrize("number", [7, 8, 12])
def test_any_number_of_schemes_fits_a_panel_and_its_legend(number):
    figure = draw(_spectral(number))
    figure.draw_without_rendering()
    curves = figure.axes[1].get_lines()
    assert len(curves) == number and min(line.get_linewidth() for line in curves) > 0.4
    legend = figure.axes[1].get_legend().get_window_extent()
    assert legend.y0 >= figure.bbox.y0 - 1 and legend.y1 <= figure.bbox.y1 + 1 and legend.x1 <= figure.bbox.x1 + 1
    assert figure.axes[1].get_window_extent().height > 0.5 * figure.bbox.height
    plt.close(figure)


def test_a_legend_of_seven_has_the_full_size():
    figure, ax = plt.subplots()
    for index in range(7):
        ax.plot([0, 1], label=str(index))
    legend_beside(ax)
    legend = ax.get_legend()
    assert legend is not None
    assert legend.get_texts()[0].get_fontsize() == plt.rcParams["legend.fontsize"]
    plt.close(figure)


def test_the_same_figure_gives_the_same_files(tmp_path):
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        figure, ax = plt.subplots()
        ax.plot([0, 1])
        save(figure, tmp_path / folder / "figure.pdf")
        plt.close(figure)
    for suffix in (".pdf", ".png", ".svg"):
        first, second = ((tmp_path / folder / f"figure{suffix}").read_bytes() for folder in ("first", "second"))
        assert first == second and first
