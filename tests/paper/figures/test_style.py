"""Looks of curves, titles of panels, and how figures are saved."""

import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb

import study
from paper.figures import style
from paper.figures.large_steps import CLASSES
from paper.figures.linear_accuracy import draw
from paper.figures.style import OUTCOME_STYLES, letter, looks, save
from paper.published import SCHEMES
from tests.paper.figures.printing import faults


def _names(number):
    return xr.DataArray([f"scheme {index}" for index in range(number)])


def test_a_scheme_looks_the_same_in_every_figure():
    every = looks(xr.DataArray(list(study.schemes)))
    assert looks(xr.DataArray(["rk4", "houbolt"])) == {name: every[name] for name in ("rk4", "houbolt")}
    assert len({every[name]["color"] for name in SCHEMES}) == 7
    assert set(style._ORDER) <= set(every)


def test_all_schemes_look_different_also_those_that_are_added():
    many = looks(xr.DataArray([*study.schemes, *_names(50).values]))
    assert len({str(look) for look in many.values()}) == len(many)


def test_schemes_of_a_family_have_different_colours():
    every = looks(xr.DataArray(list(study.schemes)))
    families: dict[str, list[str]] = {}
    for name, scheme in study.schemes.items():
        families.setdefault(scheme.family, []).append(every[name]["color"])
    for family, colours in families.items():
        assert len(set(colours)) == len(colours), family


def _lightness(colour):
    """Lightness L* of a colour, from 0 to 100."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    luminance = np.dot(linear, [0.2126, 0.7152, 0.0722])
    return 116 * np.cbrt(luminance) - 16 if luminance > 0.008856 else 903.3 * luminance


@pytest.mark.parametrize("colours", [[colour for _, colour in OUTCOME_STYLES.values()], list(CLASSES.values())])
def test_classes_of_maps_get_darker_in_steps_that_are_seen_in_greyscale(colours):
    steps = -np.diff([_lightness(colour) for colour in colours])
    assert steps.min() > 9


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


@pytest.mark.parametrize("number", [1, 7, 8, 12])
def test_any_number_of_schemes_fits_a_panel_and_its_legend(number):
    figure = draw(_spectral(number))
    assert faults(figure) == []
    panel = figure.axes[0]
    curves = panel.get_lines()
    assert len(curves) == number and min(line.get_linewidth() for line in curves) > 0.4
    height = panel.get_window_extent().height / figure.dpi * 2.54
    assert 2 < height < 4
    plt.close(figure)


def test_a_legend_takes_the_place_of_a_missing_panel():
    figure, axes = style.panels(2, 2, style.COLUMN, 8)
    for ax in axes.flat[:3]:
        ax.plot([0, 1], label="central difference")
    style.legend_in_gap(figure, axes, number=3, columns=2)
    assert axes[1, 1].get_legend() is not None and not figure.legends
    assert faults(figure) == []
    plt.close(figure)


def test_the_style_serves_other_figures():
    """A program of a user finds it in a checkout by name, without the modules of the paper."""
    code = (
        "import sys, matplotlib.pyplot as plt; plt.style.use('paper.style'); "
        "print(plt.rcParams['font.size'], 'paper.figures' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "7.0 False\n"


@pytest.mark.parametrize("width", [90, 190])
def test_a_figure_fits_the_width_of_a_journal(width, tmp_path):
    figure = style.at_width(draw(_spectral(3)), width)
    assert faults(figure) == [f"{width / 10:.1f} cm is no width of the manuscript"]
    save(figure, tmp_path / "own.pdf")
    assert plt.imread(tmp_path / "own.png").shape[1] == int(width / 25.4 * plt.rcParams["savefig.dpi"])
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
