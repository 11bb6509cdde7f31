"""diffrax's solvers."""

import pytest

import reference.diffrax
import study


def test_diffrax_steps_our_runge_kutta_method():
    problem = study.problems["hardening"]
    ours = study.run("hardening", "rk4", dt=0.003, steps=100)
    theirs = reference.diffrax.classical_runge_kutta(problem, 0.003, 100)
    assert theirs.u[-1] == pytest.approx(ours.u[-1].item(), abs=1e-11)
    assert theirs.v[-1] == pytest.approx(ours.v[-1].item(), abs=1e-9)
