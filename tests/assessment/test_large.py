"""Assessments of problems with many unknowns; their reference is the motion on which two schemes agree."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from scipy import sparse

import study
from study.assessment import arguments, errors, large, program
from study.program import search
from study.program.refinement import NoTruth

#: Options of the assessments of the chain, whose slowest period is 25 s.
OPTIONS = {"duration": 6.0, "allowed_errors": (0.1, 0.01), "maps": False}
SCHEMES = ["average_acceleration", "central_difference"]


@pytest.fixture
def like_programs(monkeypatch, tmp_path):
    """Treat several unknowns as many, keep runs in a temporary folder, and confirm steps by the fewest runs."""
    monkeypatch.setattr(arguments, "FINDABLE", 1)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(search, "MOST_CONFIRMING", search.FEWEST_CONFIRMING)


@pytest.mark.slow
def test_steps_and_error_bar_are_those_of_the_certified_reference(damped_chain, like_programs, monkeypatch):
    """It alone compares the search of a program, and its uncertainty, with a certified reference."""
    ds = study.assess(damped_chain(), SCHEMES[0], **OPTIONS)
    monkeypatch.undo()
    quantities = {name: errors.DEFAULT[name] for name in ds.quantity.values}
    # at an error of 1 % only, because at 10 % the search of a large problem is limited by its coarsest step
    allowed = {"allowed_errors": (0.01,)}
    certified = study.assess(damped_chain(), SCHEMES[0], quantities=quantities, **OPTIONS | allowed)
    assert set(ds.quantity.values) == {"displacement", "velocity"}
    assert ds.reference_uncertainty.max() < 1e-3
    ratio = (ds.largest_step_size / certified.largest_step_size).sel(quantity=ds.quantity, allowed_error=0.01)
    assert ((ratio > 0.9) & (ratio < 1.1)).all()
    assert ds.attrs["reference"].startswith(("rk4", "nystrom4"))


@pytest.mark.slow
def test_quantities_that_are_reduced_are_single_numbers(damped_chain, like_programs):
    peak = {
        "peak": study.Quantity(lambda u: u[-1], reduce="peak"),
        "both": study.Quantity(lambda u: u[:2], reduce="rms"),
        "last": study.Quantity(lambda u: u[-1], reduce="final"),
    }
    ds = study.assess(damped_chain(), SCHEMES, quantities=peak, **OPTIONS)
    np.testing.assert_array_equal(ds.reference_time.isel(component=0), [np.nan, np.nan, OPTIONS["duration"]])
    assert list(ds.quantity.values) == [*peak] and (ds.recommended_step_size > 0).all()
    assert "peaks and root mean squares are compared with those of the whole duration" in ds.attrs["remarks"]


def test_the_largest_value_may_lie_between_two_samples():
    t = np.linspace(0, 1, 11)
    assert program._largest(t, 3 - (t - 0.33) ** 2) == pytest.approx((0.33, 3.0), rel=1e-12)
    assert program._largest(t, t) == (1.0, 1.0) and program._largest(t, np.ones(11)) == (0.0, 1.0)


def test_what_there_is_no_time_for_is_said(damped_chain, like_programs):
    with pytest.raises(NoTruth, match="in the given time"):
        study.assess(damped_chain(), SCHEMES, seconds=0.0, **OPTIONS)


@pytest.mark.slow
def test_another_problem_of_the_same_title_has_other_runs(damped_chain, like_programs):
    heavier = replace(damped_chain(), mass=np.array([1.0, 2.0, 1.0, 1.0, 1.6]))
    problems = [damped_chain(), replace(damped_chain()), damped_chain(linear=True), heavier]
    rk4 = {"rk4": study.schemes["rk4"]}
    first, same, *others = (large.program_of(problem, rk4, 1.0, None, None).identity() for problem in problems)
    assert first == same and len({first, *others}) == 3


@pytest.mark.slow
def test_unknowns_whose_force_is_not_linear_are_compared():
    """Both unknowns with stops are among the 256 compared ones. Of 1000 cubic springs, 256 unknowns are compared."""
    n, stops = 1000, [311, 737]
    linear = sparse.diags_array([np.full(n - 1, -1.0), np.full(n, 2.0), np.full(n - 1, -1.0)], offsets=[-1, 0, 1])

    def touches(u):
        return jnp.zeros_like(u).at[np.array(stops)].set(1e3 * jnp.maximum(u[np.array(stops)] - 0.5, 0))

    row = study.Problem(touches, np.zeros(n), stiffness=sparse.csc_array(linear))
    places = large.compared(row)
    assert set(stops) <= set(places) and len(places) == 256 and np.diff(places).max() <= 5
    cubic = study.Problem(lambda u: 3 * u + u**3, np.zeros(n))
    assert len(large.compared(cubic)) == 256


def test_unknowns_that_are_not_compared_are_said(damped_chain, like_programs, monkeypatch):
    """An assessment of many unknowns that compares some of them and does not say so."""
    monkeypatch.setattr(large, "SHOWN", 2)
    ds = study.assess(damped_chain(), SCHEMES, **OPTIONS | {"allowed_errors": (0.1,)})
    assert " Errors were compared at 2 of " in ds.attrs["starts"]
