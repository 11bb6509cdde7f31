"""diffrax's solvers."""

import pytest

import reference.diffrax
import study


def test_diffrax_steps_our_runge_kutta_method():
    problem = study.problems["hardening"]
    ds = study.run("hardening", "rk4", dt=0.003, steps=100)
    solution = reference.diffrax.classical_runge_kutta(problem, 0.003, 100)
    assert solution.u[-1] == pytest.approx(ds.u[-1].item(), abs=1e-11)
    assert solution.v[-1] == pytest.approx(ds.v[-1].item(), abs=1e-9)
