"""Chaotic motions by scheme and step."""

import numpy as np
import pytest

from study.experiments.chaos import chaos
from study.problem.oscillators import UEDA_EXPONENT


def test_a_fine_step_keeps_the_exponent_and_a_long_one_makes_the_motion_regular():
    ds = chaos("ueda", ["average_acceleration"], [24, 64], 400, 32).sel(problem="ueda", scheme="average_acceleration")
    largest = ds.lyapunov_exponent.isel(place=0)
    assert largest[0] < 0 and ds.regular.values.tolist() == [1, 0]
    assert largest[1] == pytest.approx(UEDA_EXPONENT, rel=0.1)
    # SciPy's DOP853 with tolerances of 1e-8 gives 2.569 over 4,800 periods; the error of second order is 0.8 % here
    assert ds.mean_square[1] == pytest.approx(1.008 * 2.569, abs=4 * ds.mean_square_uncertainty[1].item())
    # the sum of the exponents is -0.05 and has an error of second order
    assert ds.damping == 0.05 and ds.contraction[1] == pytest.approx(0.05, rel=0.03)
    assert ds.lyapunov_exponent[:, 2:].isnull().all()


def test_a_run_that_fails_has_no_statistics():
    ds = chaos("buckled_beam", ["central_difference"], [8, 24], 8, 2).squeeze()
    assert np.isnan(ds.contraction[0]) and ds.contraction[1] == pytest.approx(0.9, rel=0.01)
    assert (
        ds.lyapunov_exponent[1].notnull().all() and np.isnan(ds.regular[0]) and ds.damping.item() == pytest.approx(0.9)
    )
