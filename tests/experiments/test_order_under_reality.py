"""The order of schemes under the circumstances of real problems, where theory predicts it."""

import numpy as np
import pytest

from study.experiments.circumstances import QUANTITIES, TOLERANCES, LooselyBalanced, circumstances_with
from study.experiments.order_under_reality import STATUSES, order_under_reality
from study.marching.run import run
from study.scheme.named import schemes

SCHEMES = ["average_acceleration", "generalized_alpha", "rk4", "energy_momentum"]


@pytest.fixture(scope="module")
def ds():
    return order_under_reality(SCHEMES, [64, 128, 256, 512], [1e6], [1e-3])


def test_schemes_have_their_order_where_all_is_smooth(ds):
    motion = ds.observed_order.sel(quantity=["displacement", "velocity"])
    for circumstance in ("plain", "damping", "load", "unequal_steps"):
        order = motion.sel(circumstance=circumstance)
        np.testing.assert_allclose(order.sel(scheme=SCHEMES[:2]), 2.0, atol=0.1)
        np.testing.assert_allclose(order.sel(scheme="rk4"), 4.0, atol=0.4)


def test_circumstances_cost_the_order_of_theory(ds):
    order = ds.observed_order
    # the carried acceleration of the generalized-α method belongs to a time within the step
    late = order.sel(scheme="generalized_alpha", quantity="acceleration", circumstance=["damping", "load"])
    np.testing.assert_allclose(late, 1.0, atol=0.35)
    # a wrong initial acceleration causes an error of the velocity that is proportional to the size of the first step
    wrong = order.sel(scheme="average_acceleration", circumstance="inconsistent_start", quantity="velocity")
    assert wrong == pytest.approx(1.0, abs=0.1)
    # a kink costs the Runge-Kutta method two orders
    assert (order.sel(scheme="rk4", circumstance=["hysteresis", "contact"]) < 2.7).all()
    # a scheme whose limit of stability is too low cannot integrate the stiff spring
    support = ds.sel(circumstance="support_0")
    assert support.observed_order.sel(scheme="average_acceleration")[0] == pytest.approx(2.0, abs=0.1)
    assert (support.status.sel(scheme="rk4") == STATUSES.index("failed")).all()


def test_what_does_not_apply_has_no_error(ds):
    left_out = {("energy_momentum", "hysteresis"), ("rk4", "inconsistent_start"), ("rk4", "tolerance_0")}
    for scheme in SCHEMES:
        for circumstance in ds.circumstance.values:
            case = ds.sel(scheme=scheme, circumstance=circumstance)
            applies = (case.status != STATUSES.index("does_not_apply")).all()
            assert applies == ((scheme, circumstance) not in left_out)
            assert applies or case.end_error.isnull().all()
    assert (ds.observed_order.notnull() == (ds.status == STATUSES.index("measured"))).all()


@pytest.mark.slow
def test_references_are_those_of_a_fine_run_of_another_method():
    """A reference that is wrong in one circumstance, which all orders of the table would share."""
    assert TOLERANCES["rtol"] < 1e-12
    for name, circumstance in circumstances_with([100.0]).items():
        if circumstance.inconsistent or circumstance.unequal:
            continue
        # at kinks the error of the fine run is of second order
        allowed = 1e-5 if name in ("hysteresis", "contact") else 1e-9
        assert circumstance.errors(schemes["rk4"], [4096]).max() < allowed, name


@pytest.mark.slow
def test_newton_iterations_that_end_early_leave_another_error_and_the_order(ds):
    implicit = ds.sel(scheme=[name for name in SCHEMES if name != "rk4"], quantity="displacement")
    loose, plain = (implicit.sel(circumstance=name) for name in ("tolerance_0", "plain"))
    np.testing.assert_allclose(loose.observed_order, plain.observed_order, atol=0.05)
    assert (loose.end_error != plain.end_error).any("steps").all()
    # with the loose tolerance, one iteration is enough in most steps
    case = circumstances_with([100.0], [1e-3])["tolerance_0"]
    schemes_with = (
        schemes["average_acceleration"],
        LooselyBalanced(scheme=schemes["average_acceleration"], tolerance=1e-3),
    )
    full, early = (
        run(case.problem, scheme, dt=0.05, steps=100, observe=["newton_iterations"]).newton_iterations.item()
        for scheme in schemes_with
    )
    assert early < 110 < 200 <= full


@pytest.mark.slow
def test_a_lane_is_a_run_of_its_own():
    plain = circumstances_with([100.0])["plain"]
    ds, completed = plain.final(schemes["rk4"], [32, 64])
    assert completed.all()
    alone = run(plain.problem, "rk4", dt=6.0 / 64, steps=64, u0=1.0, v0=plain.v0[3], every=64)
    together = ds[QUANTITIES[0]].values.reshape(2, -1)[1, 3]
    np.testing.assert_allclose(together, alone.u[-1], rtol=1e-12)
