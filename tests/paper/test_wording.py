"""Numbers and names as the ledger prints them."""

import pytest
import xarray as xr

from paper.wording import joined, listed, number, title

DATA = {
    "over_schemes": xr.Dataset(coords={"scheme": ["rk4"], "scheme_title": ("scheme", ["Runge-Kutta"])}),
    "cut": xr.Dataset(coords={"scheme": ((), "hht_alpha_1996"), "scheme_title": ((), "α-method")}),
    "over_problems": xr.Dataset(coords={"problem": ["large"], "problem_title": ("problem", ["spring, large"])}),
    "portrait": xr.Dataset(attrs={"problem": "double_well", "problem_title": "double well"}),
}


@pytest.mark.parametrize(
    "value, form, text",
    [
        (-0.5, ".1f", "−0.5"),
        (2e-16, ".0e", "2\u00a0×\u00a010⁻¹⁶"),
        (-3.2e5, ".1e", "−3.2\u00a0×\u00a010⁵"),
        (1e-5, ".0e", "10⁻⁵"),
        (0.0, ".0e", "0"),
        (5e-5, ".2g", "5\u00a0×\u00a010⁻⁵"),
        (float("inf"), ".1f", "∞"),
        (float("nan"), ".1f", "failed"),
    ],
)
def test_a_number_is_printed_without_code(value, form, text):
    assert number(value, form) == text


@pytest.mark.parametrize(
    "name, words",
    [
        ("rk4", "Runge-Kutta"),
        ("hht_alpha_1996", "α-method"),
        ("large", "spring, large"),
        ("double_well", "double well"),
        ("linear_acceleration", "linear acceleration"),
    ],
)
def test_a_name_has_the_title_that_any_dataset_gives_it(name, words):
    assert title(name, DATA) == words


def test_lists():
    assert listed({"rk4": 1.0, "large": float("nan")}, DATA, missing="none") == "Runge-Kutta: 1.0; spring, large: none"
    assert joined(["a", "b", "rk4"], DATA) == "a, b and Runge-Kutta"
    assert joined(["large", "b", "rk4"], DATA) == "spring, large; b and Runge-Kutta"
    assert joined(["rk4"], DATA) == "Runge-Kutta" and joined([], DATA) == "none"
