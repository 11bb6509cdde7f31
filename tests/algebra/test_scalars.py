"""Arrays with masked entries, wherever a user may give an array."""

import numpy as np
import pytest

import study
from study.program.attempt import attempt

MASKED = np.ma.array([1.0, 2.0, 1e20], mask=[False, False, True])
WHOLE = np.ma.array([1, 2, 10**6], mask=[False, False, True])


@pytest.mark.parametrize(
    "call, name",
    [
        (lambda: study.Problem(lambda u: u, u0=MASKED), "u0"),
        (lambda: study.Problem(lambda u: u, u0=np.zeros(2), stiffness=[MASKED[:2], MASKED[1:]]), "stiffness"),
        (lambda: study.run("hardening", "rk4", dt=MASKED, steps=2), "dt"),
        (lambda: study.run("hardening", "rk4", dt=0.1, steps=WHOLE), "steps"),
        (lambda: study.run("hardening", "rk4", dt=0.1, steps=2, u0=MASKED), "u0"),
        (lambda: study.run("hardening", "rk4", tolerance=MASKED, duration=1.0), "tolerance"),
        (
            lambda: study.run(
                lambda k: study.Problem(lambda u: k * u, 1.0), "rk4", dt=0.1, steps=2, over={"k": MASKED}
            ),
            r"over\['k'\]",
        ),
        (lambda: study.GroundMotion(MASKED, 0.1, title="quake"), "'quake'"),
        (lambda: study.Quantity(lambda u: u, scale=MASKED), "scale"),
        (lambda: study.Prescribed(MASKED), "an array"),
        (lambda: study.materials.elastoplastic(stiffness=MASKED, yield_force=1.0), "an array"),
    ],
)
def test_masked_entries_are_refused(call, name):
    place = r"\[1, 1\]" if name == "stiffness" else r"\[2\]"
    with pytest.raises(ValueError, match=rf"^{name} has masked entries, the first at {place}: fill them, or leave"):
        call()


@pytest.mark.parametrize(
    "call, name",
    [
        (lambda: study.Problem(lambda u: u, u0=np.ma.masked), "u0"),
        (lambda: study.GroundMotion([0.0, 1.0], np.ma.masked, title="quake"), "'quake'"),
        (lambda: study.Quantity(lambda u: u, scale=np.ma.masked), "scale"),
    ],
)
def test_a_masked_number_is_refused(call, name):
    with pytest.raises(ValueError, match=rf"^{name} has masked entries, the first at \[0\]: fill them, or leave"):
        call()


def test_a_run_of_a_program_with_masked_entries_fails():
    run = attempt(lambda scheme, dt: {"t": [0.0, 1.0, 2.0], "drift": MASKED}, "a", 1.0, 2.0)
    assert run.status == "unusable" and "'drift' has masked entries, the first at [2]" in run.reason


def test_a_mask_that_covers_nothing_changes_nothing():
    unmasked = np.ma.array([1.0, 2.0], mask=[False, False])
    assert study.Problem(lambda u: u, u0=unmasked).u0.tolist() == [1.0, 2.0]
