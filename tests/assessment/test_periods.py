"""The model of an assessment in two lines."""

import numpy as np
import pytest

import study
from study.assessment.periods import model_of, remark_on_record
from study.mechanics.frequencies import frequencies


def test_a_chain_is_described_by_its_periods_and_damping_ratios():
    """Two equal masses between three equal springs have ω² = 1 and 3, and C = 0.1 K gives ζ = 0.05 ω."""
    stiffness = np.array([[2.0, -1.0], [-1.0, 2.0]])
    chain = study.Problem(stiffness=stiffness, damping=0.1 * stiffness, u0=[1.0, 0.0])
    sentence = "2 unknowns, periods of small motion 3.63 to 6.28 s, 62.83 s are 10 periods of the slowest"
    assert model_of(chain, 20 * np.pi, None) == [sentence, "damping ratios 0.05 to 0.0866; no load"]
    free = study.Problem(lambda u: 4 * u, 1.0)
    assert model_of(free, np.pi, None) == [
        "1 unknown, period of small motion 3.14 s, 3.142 s are 1 periods",
        "no damping; no load",
    ]
    through_force = study.Problem(lambda u, v: u + 0.4 * v, 1.0)
    assert model_of(through_force, 1.0, None)[1] == "damping ratios 0.2; no load"
    drag = study.Problem(lambda u, v: u + 0.4 * v * abs(v), 1.0)
    assert model_of(drag, 1.0, None)[1] == "no damping of small motions; no load"
    overdamped = study.Problem(lambda u: u, 1.0, damping=3.0)
    assert model_of(overdamped, 1.0, None)[1] == "no small motion oscillates; no load"
    assert model_of(study.Problem(lambda u: -u, 1.0, damping=0.1), 2.0, None)[0] == "1 unknown, 2 s"


def test_motions_that_grow_are_not_called_damped():
    """Negative damping, and flutter with the roots −0.3786 ± 2.0915i and 0.3286 ± 2.0915i."""
    growing = study.Problem(lambda u: u, 1.0, damping=-0.1)
    grow = "small motions with a negative one grow; no load"
    assert model_of(growing, 1.0, None)[1] == f"damping ratios −0.05, and {grow}"
    stiffness = np.array([[4.0, 1.5], [-1.5, 4.5]])
    flutter = study.Problem(lambda u: stiffness @ u, np.array([0.1, 0.2]), damping=0.05)
    assert model_of(flutter, 1.0, None)[1] == f"damping ratios −0.155 to 0.178, and {grow}"
    np.testing.assert_allclose(frequencies(flutter), [abs(0.3286 + 2.0915j), abs(-0.3786 + 2.0915j)], rtol=1e-4)


def test_units_that_do_not_fit_a_record_are_remarked():
    """Masses in t with stiffness in N/m: periods are shorter by the root of a thousand."""
    ground = study.GroundMotion(np.sin(np.arange(100)), 0.02)
    wrong = study.Problem(lambda u: (2 * np.pi / 0.0156) ** 2 * u, 0.0, ground=ground, title="frame")
    with pytest.warns(RuntimeWarning, match="'frame', 0.0156 s, is below the spacing of the record, 0.02 s: check"):
        assert remark_on_record(wrong, 0.02)
    assert remark_on_record(study.Problem(lambda u: u, 0.0, ground=ground), 0.02) == []
    assert model_of(wrong, 1.0, 0.02)[1] == "no damping; record with a spacing of 0.02 s"
