"""Styles of curves, titles of panels, and saved figures."""

import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.colors import to_rgb

import study
from paper.figures import style
from paper.figures.large_steps import CLASSES
from paper.figures.linear_accuracy import draw
from paper.figures.style import OUTCOME_STYLES, curve_styles, letter, save
from paper.points import points
from paper.published import SCHEMES
from study.experiments.coordinates import scheme_coordinates
from tests.paper.figures.printing import faults, printed

EVERY = xr.Dataset(coords=scheme_coordinates(list(study.schemes)))


def _members(number, family="Own"):
    """Coordinates of ``number`` made-up schemes of one family; the study need not have this family."""
    names = [f"{family} {place}" for place in range(number)]
    of = {"scheme": names, "scheme_title": names, "family": [family] * number, "place_in_family": list(range(number))}
    return xr.Dataset(coords={name: ("scheme", values) for name, values in of.items()})


def test_a_scheme_has_the_same_style_in_every_figure():
    every, few = curve_styles(EVERY.scheme), xr.Dataset(coords=scheme_coordinates(["rk4", "bathe"]))
    assert curve_styles(few.scheme) == {name: every[name] for name in ("rk4", "bathe")}
    assert len({every[name]["color"] for name in SCHEMES}) == 7


def test_the_marks_of_all_schemes_differ_without_their_lines():
    looks = curve_styles(EVERY.scheme).values()
    assert len({(look["color"], look["marker"]) for look in looks}) == len(looks)


def test_all_schemes_look_different_also_those_that_are_added():
    families = {scheme.family for scheme in study.schemes.values()}
    many = [look for family in families for look in curve_styles(_members(8, family).scheme).values()]
    many += curve_styles(_members(50).scheme).values()
    assert len({str(look) for look in many}) == len(many)


@pytest.mark.parametrize("family", [*style._STYLE_NUMBERS, "Own"])
def test_eight_schemes_of_a_family_have_different_colours(family):
    assert len({look["color"] for look in curve_styles(_members(8, family).scheme).values()}) == 8


def test_every_family_has_its_styles():
    assert set(style._STYLE_NUMBERS) == {scheme.family for scheme in study.schemes.values()}


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
    """Made-up linear theory of ``number`` schemes of one family."""
    dims = ("scheme", "step_size_over_period", "damping_ratio")
    values = (dims, np.linspace(0, 0.1, number * 20).reshape(number, 20, 1))
    return _members(number).assign(
        {
            "period_elongation": values,
            "algorithmic_damping": values,
            "stability_limit": (dims[::2], np.ones((number, 1))),
            "step_size_over_period": np.linspace(0.01, 0.4, 20),
            "damping_ratio": [0.0],
        }
    )


@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 7, 8, 12])
def test_any_number_of_schemes_fits_a_panel_and_its_legend(number):
    figure = draw(_spectral(number))
    assert faults(figure) == []
    panel = figure.axes[0]
    curves = panel.get_lines()
    assert len(curves) == min(number, style.MOST) and min(line.get_linewidth() for line in curves) > 0.4
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
    """In a checkout, a program finds the style by its name, and does not import the module paper.figures.style."""
    code = (
        "import sys, matplotlib.pyplot as plt; plt.style.use('paper.figures.style'); "
        "print(plt.rcParams['font.size'], 'paper.figures.style' in sys.modules)"
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
    for suffix in (".pdf", ".png", ".svg", ".csv"):
        first, second = ((tmp_path / folder / f"figure{suffix}").read_bytes() for folder in ("first", "second"))
        assert first == second and first


def test_a_figure_has_its_points_and_its_text(tmp_path):
    figure, (curves, cells) = plt.subplots(1, 2)
    curves.plot([1.0, 2.0], [3.0, np.nan], label="curve")
    curves.axhline(0.5)  # a line of the panel, not of the data
    curves.scatter([4.0], [5.0], label="point")
    curves.set_title("left panel", loc="left")
    cells.pcolormesh([0.0, 1.0, 3.0], [0.0, 2.0], [[7.0, 8.0]])
    cells.imshow([[9.0, 10.0]], extent=(0, 2, 0, 1), origin="lower", aspect="auto")
    save(figure, tmp_path / "figure.pdf")
    plt.close(figure)
    assert ">left panel</text>" in (tmp_path / "figure.svg").read_text()
    table = pd.read_csv(tmp_path / "figure.csv", keep_default_na=False, na_values={"y": "", "value": ""})
    rows = table.replace(np.nan, None).to_numpy().tolist()
    assert rows == [
        ["left panel", "curve", 1.0, 3.0, None],
        ["left panel", "curve", 2.0, None, None],
        ["left panel", "point", 4.0, 5.0, None],
        ["2", "", 0.5, 1.0, 7.0],
        ["2", "", 2.0, 1.0, 8.0],
        ["2", "", 0.5, 0.5, 9.0],
        ["2", "", 1.5, 0.5, 10.0],
    ]


def test_the_points_of_a_figure_have_the_names_that_its_legend_and_its_axes_give():
    """A curve that only its colour and marker name, and a place along an axis of names."""
    figure, (first, second) = plt.subplots(1, 2)
    for ax in (first, second):
        ax.errorbar([1.0], [0.2], yerr=[0.1], marker="o", color="C0", label="Bathe" if ax is first else None)
    first.plot([1.0], [3.0], marker="s", color="C0")
    second.set_yticks([0, 1], ["plain", "damping"])
    second.plot([2.0], [0.8], marker="x", color="C1")
    second.set_label("panel")
    table = points(figure)
    assert table[table.y == 0.2].curve.tolist() == ["Bathe", "Bathe"]
    assert table[(table.y == 3.0) | (table.y == 0.8)].curve.tolist() == ["", ""]
    assert table[table.panel == "panel"]["y name"].tolist() == ["plain", "damping", "plain", "plain"]
    assert table[table.panel == "1"]["y name"].isna().all() and "x name" not in table
    plt.close(figure)


def test_the_points_of_an_image_are_in_the_coordinates_of_the_axes():
    """An image across a panel with logarithmic axes, whose cells would have coordinates from zero to one."""
    figure, ax = plt.subplots()
    ax.set(xscale="log", yscale="log", xlim=(0.1, 10.0), ylim=(1.0, 100.0))
    ax.imshow([[5.0, 6.0]], extent=(0, 1, 0, 1), transform=ax.transAxes, origin="lower", aspect="auto")
    table = points(figure)
    np.testing.assert_allclose(table[["x", "y"]], [[10**-0.5, 10.0], [10**0.5, 10.0]])
    assert table.value.tolist() == [5.0, 6.0]
    plt.close(figure)


def test_the_points_of_a_figure_hold_the_ends_of_its_intervals():
    figure, ax = plt.subplots()
    ax.hlines([1.0, 2.0], [0.1, 0.2], [0.3, 0.4], label="interval")
    ax.hlines([], [], [], label="none")
    ax.errorbar([np.nan], [1.0], yerr=[np.nan], fmt="none", label="without ends")
    table = points(figure)
    assert set(table.curve) == {"interval"}
    assert table[["x", "y"]].values.tolist() == [[0.1, 1.0], [0.3, 1.0], [0.2, 2.0], [0.4, 2.0]]
    plt.close(figure)


@pytest.mark.slow
@pytest.mark.parametrize("ends, labels", [((0.002, 4000), ["0.01", "1", "100"]), ((2e-5, 20), None)])
def test_labels_of_logarithmic_axes_are_short_numbers_or_powers_with_legible_exponents(ends, labels):
    picture, ((first, second),) = style.panels(1, 2, style.COLUMN, 4, sharey=True)
    for ax in (first, second):
        ax.set(yscale="log", ylim=ends)
    second.tick_params(labelleft=True)
    texts = [text for text in printed(picture) if text.words[0] in "0123456789$"]
    powers = [text.words for text in texts if "^" in text.words]
    assert min(text.size for text in texts) >= 7 - 1e-6
    assert bool(powers) == (labels is None)
    assert labels is None or set(labels) <= {text.words for text in texts}
    plt.close(picture)
