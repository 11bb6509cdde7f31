"""How numbers are printed, for the paper and the site alike."""

import numpy as np
import pytest

from study.words import at_most, measured, printed, printed_unit, up_to


@pytest.mark.parametrize(
    "text, expected",
    [
        ("6e4523684f94, 1e5023684512", "6e4523684f94, 1e5023684512"),
        ("5e-05", "5\u00a0×\u00a010⁻⁵"),
        ("1e-15", "10⁻¹⁵"),
        ("2.3e+05", "2.3\u00a0×\u00a010⁵"),
        ("0e+00", "0"),
        ("Houbolt: -1.0; Bathe: 2e-16", "Houbolt: −1.0; Bathe: 2\u00a0×\u00a010⁻¹⁶"),
        ("Fermi-Pasta-Ulam, ρ∞-Bathe, T-20, a1e5", "Fermi-Pasta-Ulam, ρ∞-Bathe, T-20, a1e5"),
    ],
)
def test_powers_of_ten_and_minus_signs(text, expected):
    assert printed(text) == expected


@pytest.mark.parametrize("units, expected", [("m s-2", "m s⁻²"), ("m2", "m²"), ("kN", "kN"), ("%", "%")])
def test_the_exponents_of_a_unit_are_raised(units, expected):
    assert printed_unit(units) == expected


@pytest.mark.parametrize(
    "value, uncertainty, expected",
    [
        (244406.0, 41.0, ("244410", "40")),
        (0.01876845, 1.1e-5, ("0.01877", "1e-05")),
        (0.96, 0.97, ("1", "1")),
        (-3.0, 1e-12, ("-3", "1e-12")),
        (1 / 3, 0.0, ("0.3333333", "0")),
        (1 / 3, float("nan"), ("0.3333333", "–")),
    ],
)
def test_a_value_is_printed_up_to_its_uncertainty(value, uncertainty, expected):
    assert measured(value, uncertainty) == expected


@pytest.mark.parametrize(
    ("value", "digits", "printed"),
    [(1.49e-12, 1, "2 × 10⁻¹²"), (0.32, 1, "0.4"), (0.3, 1, "0.3"), (7.01, 2, "7.1"), (99.2, 2, "100"), (0.0, 1, "0")],
)
def test_a_bound_is_rounded_up(value, digits, printed):
    assert at_most(value, digits).replace("\u00a0", " ") == printed


@pytest.mark.parametrize(
    ("value", "printed"), [(3.745029, "3.74"), (2 * (1 - 1e-9), "2"), (np.sqrt(6), "2.44"), (np.inf, "∞"), (0.0, "0")]
)
def test_a_limit_is_rounded_down(value, printed):
    assert up_to(value) == printed
