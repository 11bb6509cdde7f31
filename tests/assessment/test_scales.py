"""Values to which errors are relative, and remarks on them, on linear motions in closed form."""

import numpy as np
import pytest

import study
from study.assessment import errors
from study.assessment.reference import Reference
from study.assessment.scales import remark_on_components, remarks_on_scales, scaled_from
from study.assessment.search import Case
from study.assessment.steps import StepSearch

#: Translation in mm and rotation in rad: K has entries of different units.
MASS, STIFFNESS = np.array([1.0, 4e3]), np.array([[100.0, -2e3], [-2e3, 4e7]])


def _targets(problem, duration, quantities):
    reference = Reference(problem, duration)
    exactly = reference.solution(reference.routes[0], reference.grid(duration / 20), 1e-12)
    return {name: errors.target(quantity, problem, exactly) for name, quantity in errors.named(quantities).items()}


def _errors(problem, duration, targets, dt):
    search = StepSearch(study.schemes["rk4"], {1.0: Case(problem, targets, None)}, duration, dt, dt, False)
    search.run(np.array([dt]))
    return search.runs.iloc[0]


@pytest.fixture(scope="module")
def decaying():
    """ü + 0.1 u̇ + u = 0 from u = 1 at rest: after 30 s it is at a fifth of its start."""
    return study.Problem(lambda u: u, 1.0, damping=0.1, title="decaying")


def _exact(t):
    ratio, omega = 0.05, np.sqrt(1 - 0.05**2)
    return np.exp(-ratio * t) * (np.cos(omega * t) + ratio / omega * np.sin(omega * t))


def test_the_error_of_a_final_value_is_relative_to_it(decaying):
    """A final value whose error is relative to another value than its scale names."""
    duration, dt = 30.0, 0.5
    quantities = {scale: study.Quantity(lambda u: u, reduce="final", scale=scale) for scale in ("own", "peak", "each")}
    quantities |= {"number": study.Quantity(lambda u: u, reduce="final", scale=0.2)}
    row = _errors(decaying, duration, _targets(decaying, duration, quantities), dt)
    end = study.run(decaying, "rk4", dt=dt, steps=60, every=60).u[-1].item()
    difference = abs(end - _exact(duration))
    for scale, value in (
        ("own", abs(_exact(duration))),
        ("each", abs(_exact(duration))),
        ("peak", 1.0),
        ("number", 0.2),
    ):
        assert row[scale] == pytest.approx(difference / value, rel=1e-6)


@pytest.mark.slow
def test_a_residual_drift_has_an_error_of_its_own_size():
    """A spring that yields once keeps u = 0.5 as its drift: k (u − 0.5) about which it swings with damping."""
    settled = study.Problem(lambda u: u - 0.05, 1.0, damping=0.4, title="settled")
    ratio, omega = 0.2, np.sqrt(1 - 0.04)
    exact = 0.05 + 0.95 * np.exp(-0.2 * 20) * (np.cos(omega * 20) + ratio / omega * np.sin(omega * 20))
    targets = _targets(settled, 20.0, {"drift": study.Quantity(lambda u: u, reduce="final")})
    assert targets["drift"].value == pytest.approx([exact], rel=1e-9)
    value = study.run(settled, "rk4", dt=1.0, steps=20).u[-1].item()
    assert _errors(settled, 20.0, targets, 1.0).drift == pytest.approx(abs(value - exact) / abs(exact), rel=1e-6)


def test_a_final_value_near_zero_gets_a_remark(decaying):
    quantities = {"end": study.Quantity(lambda u: u, reduce="final")}
    # u(t) = 0 where tan ωt = −ω/ζ
    omega = np.sqrt(1 - 0.05**2)
    zero = (np.pi - np.arctan(omega / 0.05)) / omega
    with pytest.warns(RuntimeWarning, match="the final value of 'end', .* is close to zero"):
        (remark,) = remarks_on_scales(_targets(decaying, zero + 1e-5, quantities))
    assert "scale='peak'" in remark
    quantities["end"] = study.Quantity(lambda u: u, reduce="final", scale="peak")
    assert remarks_on_scales(_targets(decaying, zero + 1e-5, quantities)) == []


@pytest.mark.slow
def test_a_motion_that_runs_away_gets_a_remark():
    """U = cosh t grows by cosh 20/cosh 10 = 22,026 in the second half of 20 s."""
    leaning = study.Problem(lambda u: -u, 1.0, title="leaning")
    along = {"drift": study.Quantity(lambda u: u)}
    with pytest.warns(
        RuntimeWarning, match=r"'drift' grows 2e\+04-fold in the second half of the time: the motion runs"
    ):
        remarks_on_scales(_targets(leaning, 20.0, along))
    assert remarks_on_scales(_targets(leaning, 10.0, along)) == []


def test_components_of_different_units_have_errors_of_their_own_size():
    problem = study.Problem(stiffness=STIFFNESS, mass=np.diag(MASS), u0=[50.0, 0.0], v0=[0.0, 0.5], title="mixed")
    quantities = {scale: study.Quantity(lambda u: u, scale=scale) for scale in ("own", "each")}
    quantities |= {"given": study.Quantity(lambda u: u, scale=[50.0, 0.0081])}
    duration, dt = 2.0, 0.028
    targets = _targets(problem, duration, quantities)
    # modal solution: M^(−1/2) K M^(−1/2) has the eigenvalues ω²
    root = np.sqrt(MASS)
    squares, modes = np.linalg.eigh(STIFFNESS / np.outer(root, root))
    omega = np.sqrt(squares)
    amplitudes, rate = modes.T @ (root * [50.0, 0.0]), modes.T @ (root * [0.0, 0.5])

    def exact(t):
        swings = amplitudes * np.cos(np.outer(t, omega)) + rate / omega * np.sin(np.outer(t, omega))
        return swings @ modes.T / root

    ds = study.run(problem, "rk4", dt=dt, steps=int(duration / dt))
    differences = np.abs(ds.u - exact(ds.t.values)).max("t").values
    peaks = np.abs(exact(np.linspace(0, duration, 100_001))).max(axis=0)
    row = _errors(problem, duration, targets, dt)
    assert row.own == pytest.approx(differences.max() / peaks.max(), rel=1e-3) and row.own < 0.01
    assert row.each == pytest.approx((differences / peaks).max(), rel=1e-3) and row.each > 0.5
    assert row.given == pytest.approx((differences / [50.0, 0.0081]).max(), rel=1e-3)
    with pytest.warns(RuntimeWarning, match="1 of 2 components of 'own' stay below a hundredth of the largest"):
        (remark,) = remarks_on_scales(targets)
    assert "scale='each'" in remark


def test_a_component_of_round_off_neither_dominates_nor_gets_a_remark():
    quantity = study.Quantity(lambda u: u, scale="each")
    assert quantity.scales(np.array([1.0, 1e-14]), np.ones(2)).tolist() == [1.0, 1e-6]
    assert remark_on_components("u", np.array([1.0, 0.02, 1e-14, 0.0]), "") == []
    assert "1 of 3 components" in remark_on_components("u", np.array([1.0, 0.005, 0.0]), "")[0]


@pytest.mark.parametrize(
    "quantity, begin",
    [
        (None, 3.0),
        (study.Quantity(lambda u: u, scale="each"), 5.0),
        (study.Quantity(lambda u: u, scale=[1.0, 2.0]), 0.0),
        (study.Quantity(lambda u: u, reduce="peak"), np.nan),
    ],
)
def test_the_value_to_which_errors_are_relative_is_reached_at_a_time(quantity, begin):
    """A first component with its largest size at 3 s, and to round-off again at 6 s, and a smaller one that grows."""
    first, second = [0.0, 1.0, 2.0, -4.0, 1.0, 0.0, 4.0 + 1e-12], [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.5]
    found = scaled_from(quantity, np.arange(7.0), np.stack([first, second], axis=1))
    np.testing.assert_equal(found, begin)


def test_unfit_scales_are_refused():
    for scale in ("largest", 0.0, [1.0, -1.0], [], float("nan"), None):
        with pytest.raises(ValueError, match="scale must be 'own', 'each', 'peak', or numbers greater than zero"):
            study.Quantity(lambda u: u, scale=scale)
    with pytest.raises(ValueError, match="scale of 'x' must be one number or one for each of its 3 components, not 2"):
        study.Quantity(lambda u: u, "x", scale=[1.0, 2.0]).scales(np.ones(3), np.ones(3))


@pytest.mark.slow
def test_a_final_value_is_compared_with_the_largest_value_of_its_own_component():
    """Two oscillators without coupling, of amplitudes 50 and 0.0081: final values are amplitude × cos ωt."""
    problem = study.Problem(stiffness=np.diag([1.0, 4.0]), u0=[50.0, 0.0081], title="apart")
    quantities = {"end": study.Quantity(lambda u: u, reduce="final", scale="each")}
    targets = _targets(problem, np.pi / 2 - 0.2, quantities)
    assert targets["end"].value == pytest.approx([50 * np.sin(0.2), -0.0081 * np.cos(0.4)], rel=1e-6)
    assert remarks_on_scales(targets) == []
    with pytest.warns(RuntimeWarning, match=r"the final value of 'end', 3.5e-05, .* along time, 0\.0081,"):
        remarks_on_scales(_targets(problem, np.pi / 4 - 2.16e-3, quantities))
