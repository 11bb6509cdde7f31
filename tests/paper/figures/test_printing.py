"""The check of printed figures finds each kind of fault."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from paper.figures.style import COLUMN, panels
from tests.paper.figures.printing import crowded, faults


@pytest.fixture
def picture():
    """A figure without faults, and its panel."""
    figure, ((ax,),) = panels(1, 1, COLUMN, 5)
    ax.plot([1, 2], label="central difference")
    ax.set(xlabel="$u$ over $10 \\omega$", ylabel="velocity (1/s)", title="newmark, nano, 3e")
    ax.legend()
    yield figure, ax
    plt.close(figure)


def test_nothing_is_wrong_with_a_sound_figure(picture):
    assert faults(picture[0]) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "words, options, fault",
    [
        ("central_difference", {}, "is of code"),
        ("5e-05", {}, "is of code"),
        ("2e−5 s", {}, "is of code"),
        ("nan", {}, "is of code"),
        ("small", {"fontsize": 6.9}, "has 6.9 pt"),
        ("error\nover $10^{-5}$", {}, "has 4.9 pt"),
        ("$\\omega_0$", {"fontsize": 9}, "has 6.3 pt"),
        ("a long text that ends outside", {"x": 0.8}, "is cut off"),
        ("central", {"x": 0.02, "y": 1.03}, "overlap"),
    ],
)
def test_a_fault_is_found(picture, words, options, fault):
    figure, ax = picture
    place = {"x": 0.1, "y": 0.2} | options
    ax.text(s=words, transform=ax.transAxes, in_layout=False, **place)
    assert any(fault in sentence for sentence in faults(figure))


def test_ticks_that_collide_are_found(picture):
    figure, ax = picture
    ax.set_xticks([0.2, 0.22], ["1/100", "1/99"])
    assert faults(figure) == ["'1/100' and '1/99' overlap"]


@pytest.mark.parametrize("width, height, fault", [(9.0, 5, "no width"), (COLUMN, 20, "too high")])
def test_sizes_are_those_of_the_manuscript(picture, width, height, fault):
    figure, _ = picture
    figure.set_size_inches(width / 2.54, height / 2.54)
    assert any(fault in sentence for sentence in faults(figure))


def test_a_panel_of_the_article_has_six_curves(picture):
    figure, ax = picture
    ax.axhline(1.5)
    ax.plot(np.ones((3, 9)), "o", linestyle="")
    for _ in range(5):
        ax.plot([1, 2])
    assert crowded(figure) == []
    ax.plot([2, 1])
    assert crowded(figure) == ["'newmark, nano, 3e' has 7 curves"]
