"""Claims of the authors of later schemes, on problems whose solution is known."""

import numpy as np
import pytest

from study.experiments.later_schemes import _largest_stiffening, later_schemes
from study.scheme.kolay_ricles import kr_alpha, mkr_alpha


@pytest.fixture(scope="module")
def ds():
    return later_schemes([0.5, 2.0], [16, 32, 64], [0.25, 1.0], 40, [0.5, 8.0], [192, 384])


def test_a_tangent_may_exceed_the_model_by_a_multiple_of_the_mass(ds):
    exact = 1 + 4 / np.array([0.5, 2.0]) ** 2
    for scheme in ("chen_ricles", "chang", "kr_alpha"):
        np.testing.assert_allclose(ds.largest_stiffening.sel(with_model=scheme), exact, rtol=1e-3)


@pytest.mark.parametrize("scheme, stable, unstable", [(kr_alpha, 1.01, 1.05), (mkr_alpha, 1.6, 1.8)])
def test_a_dissipative_tangent_may_exceed_the_model_by_a_ratio(scheme, stable, unstable):
    """The ratios that the scheme states, with a spectral radius of 0.8, also at a step far beyond the period."""
    assert all(stable < _largest_stiffening(scheme, dt) < unstable for dt in (1.0, 100.0))


def test_trigonometric_methods_are_of_first_order_at_resonances_and_mollifying_makes_it_the_second(ds):
    slopes = np.log2(ds.trigonometric_end_error[:, :-1] / ds.trigonometric_end_error[:, 1:].values)
    for member in ds.member.values:
        expected = 2.0 if member == "garcia_archilla" else 1.0
        np.testing.assert_allclose(slopes.sel(member=member), expected, atol=0.2)


def test_central_difference_is_best_at_a_step_of_an_element(ds):
    error = ds.wave_error.sel(courant=1.0)
    assert error.idxmin() == "central_difference" and np.isfinite(error.sel(wave_scheme="beta_bathe"))


def test_the_auxiliary_variable_bounds_the_motion_at_every_step(ds):
    assert (ds.auxiliary_peak < 10).all() and (ds.auxiliary_error.sel(auxiliary="auxiliary_variable") > 0).all()
    finer = ds.fourth_order_error
    assert (finer[:, 1] < finer[:, 0] / 10).all()


def test_mixed_pade_methods_have_their_order_and_radius(ds):
    orders = np.log2(ds.pade_error[:, -2] / ds.pade_error[:, -1].values)
    np.testing.assert_allclose(orders, 2 * ds.terms - 1, atol=0.2)
    np.testing.assert_allclose(ds.pade_radius, ds.attrs["rho_inf"], atol=1e-10)


def test_a_velocity_that_lags_loses_an_order_unless_it_starts_so(ds):
    orders = np.log2(ds.lag_error[..., :-1] / ds.lag_error[..., 1:].values)
    np.testing.assert_allclose(orders.sel(lagged_start="initial velocity"), 1.0, atol=0.1)
    np.testing.assert_allclose(orders.sel(lagged_start="lagged velocity"), 2.0, atol=0.1)
