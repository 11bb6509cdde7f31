"""Tongues of Mathieu's equation, against the theory of Hill's equation and of its difference equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import study
from study.experiments.mathieu import _check, edges, exact_edges
from study.problem.oscillators import mathieu

EPSILON = np.array([0.05, 0.4, 0.8])


@pytest.mark.parametrize("tongue", [1, 2])
def test_motions_on_the_edges_of_theory_repeat(tongue):
    """On an edge the double eigenvalue of the monodromy matrix is (−1)ⁿ, so that its trace is ±2."""
    for delta in exact_edges(tongue, 0.5):

        def rate(t, x, delta=delta):
            return [*x[2:], *(-(delta + np.cos(2 * t)) * x[:2])]

        end = solve_ivp(rate, (0, np.pi), [1, 0, 0, 1], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
        assert end[0] + end[3] == pytest.approx(2 * (-1) ** tongue, abs=1e-9)


@pytest.mark.slow
def test_the_edges_of_central_difference_are_eigenvalues_of_its_difference_equation():
    """δ is an eigenvalue of −D² − 2ε cos 2t on a circle of N points, with D² the second difference and u(π) = ±u(0)."""
    steps, dt = 10, np.pi / 10
    ours = edges("central_difference", steps, 2, EPSILON)
    for e, epsilon in enumerate(EPSILON):
        for tongue, sign, which in ((1, -1, [0, 1]), (2, 1, [1, 2])):
            step = np.eye(steps, k=1)
            step[-1, 0] = sign
            second = (step - 2 * np.eye(steps) + step.T) / dt**2
            matrix = -second - np.diag(2 * epsilon * np.cos(2 * dt * np.arange(steps)))
            np.testing.assert_allclose(ours[e, tongue - 1], np.linalg.eigvalsh(matrix)[which], rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("scheme, frequency", [("central_difference", np.sin), ("average_acceleration", np.tan)])
def test_narrow_tongues_are_where_the_numerical_frequency_resonates(scheme, frequency):
    """Free motion has the numerical frequency n at √δ = 2/Δt sin(nΔt/2), or with tan; ε moves the centre by its square.

    J. W. Strutt's expansion for the exact equation is δ = 1 − ε²/8 and δ = 4 + ε²/6 in the middle of the tongues.
    """
    dt, n = np.pi / 10, np.array([1, 2])
    centre = edges(scheme, 10, 2, EPSILON[:1]).mean(axis=-1)[0]
    np.testing.assert_allclose(centre, (2 / dt * frequency(n * dt / 2)) ** 2, atol=EPSILON[0] ** 2 / 4)


@pytest.mark.parametrize("scheme", ["average_acceleration", "rk4"])
def test_edges_approach_theory_with_the_order_of_the_scheme(scheme):
    coarse, fine = (
        edges(scheme, steps, 2, EPSILON[1:]) - np.stack([exact_edges(n, EPSILON[1:]).T for n in (1, 2)], axis=1)
        for steps in (40, 80)
    )
    np.testing.assert_allclose(np.log2(coarse / fine), study.schemes[scheme].order, atol=0.15)


@pytest.mark.slow
def test_long_runs_grow_within_the_edges_only():
    """The edges of a scheme that carries its acceleration, and a narrow tongue that its dissipation closes."""
    narrow, (lower, upper) = edges("hht_alpha", 10, 2, np.array([0.1, 0.8]))[:, 1]
    assert np.isnan(narrow).all()
    # the last lanes are 0.002 apart, and the tongue of theory is 0.005 wide
    delta = np.r_[lower - 0.02, lower + 0.02, upper - 0.02, upper + 0.02, np.linspace(4.3, 4.42, 60)]
    over = {"delta": delta, "epsilon": np.repeat([0.8, 0.1], [4, 60])}
    ds = study.run(mathieu, "hht_alpha", dt=np.pi / 10, steps=1500, over=over, on_failure="ignore")
    u = abs(ds.u)
    grows = u.isel(t=slice(1000, None)).max("t") > u.isel(t=slice(500)).max("t")
    np.testing.assert_array_equal(grows, [False, True, True, False, *[False] * 60])


@pytest.mark.parametrize(
    "epsilon, tongues, what",
    [
        ({"first": 0.0, "last": 0.5}, 1, "first, 0.0, must be positive"),
        ({"first": 0.1, "last": 0.95}, 1, "at 0.95 tongue 1 leaves"),
        ({"first": 0.1, "last": 0.8}, 3, "None"),
    ],
)
def test_tongues_that_cannot_be_found_are_refused(epsilon, tongues, what):
    assert what in str(_check({"epsilon": epsilon, "tongues": tongues}, {}))


def test_a_tongue_that_is_far_from_its_place_is_not_called_closed():
    with pytest.raises(ValueError, match="with 3 steps per period, tongue 2 of 'average_acceleration' is not within"):
        edges("average_acceleration", 3, 2, EPSILON)
