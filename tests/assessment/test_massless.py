"""``study.assess`` for unknowns without mass, compared with SciPy and the matrix exponential."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import study
from study.program import search

#: Simulated time, and the quantity whose errors are measured.
DURATION, DISPLACEMENT = 1.0, {"drift": study.Quantity(lambda u: u[0])}


def _maxwell():
    """A mass on a spring, and a spring of 300 in series with a dashpot of 4, whose joint has no mass."""
    stiffness = np.array([[400.0, -300.0], [-300.0, 300.0]])
    problem = study.Problem(
        stiffness=stiffness, u0=[1.0, 1.0], mass=np.array([1.0, 0.0]), damping=np.array([0.0, 4.0]), title="Maxwell"
    )
    # the first-order system of displacement, velocity and joint
    system = np.array([[0.0, 1.0, 0.0], [-400.0, 0.0, 300.0], [75.0, 0.0, -75.0]])
    return problem, lambda t: np.array([(expm(time * system) @ [1.0, 0.0, 1.0])[0] for time in t])


def _bouc_wen():
    """Bouc and Wen's ż = u̇ − (½ |u̇| |z|^½ z + ½ u̇ |z|^1.5)/z₀^1.5 as an equation of its own, with n = 1.5."""

    def rate(v, z, xp):
        size = xp.abs(z) / 0.3
        return v * (1 - 0.5 * size**1.5) - 0.5 * xp.abs(v) * size**0.5 * z / 0.3

    def force(u, v):
        return jnp.stack([20 * u[0] + 80 * u[1], v[1] - rate(v[0], u[1], jnp)])

    problem = study.Problem(
        force, u0=[0.0, 0.01], v0=[8.0, 8.0 * float(rate(1.0, 0.01, np))], mass=np.array([1.0, 0.0]), title="Bouc-Wen"
    )

    def exact(t):
        def rates(t, y):
            return [y[1], -20 * y[0] - 80 * y[2], rate(y[1], y[2], np)]

        return solve_ivp(rates, (0, DURATION), [0.0, 8.0, 0.01], t_eval=t, rtol=1e-12, atol=1e-13, max_step=0.01).y[0]

    return problem, exact


@pytest.fixture(autouse=True)
def _few_runs(monkeypatch, tmp_path):
    """Keep runs in a temporary folder, and confirm steps by the fewest runs."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(search, "MOST_CONFIRMING", search.FEWEST_CONFIRMING)


@pytest.mark.parametrize("make", [pytest.param(_maxwell, marks=pytest.mark.exhaustive), _bouc_wen])
def test_errors_are_those_against_an_independent_solution(make):
    """It alone assesses a model with an unknown without mass, whose reference has no certified route."""
    problem, exact = make()
    options = {"duration": DURATION, "allowed_errors": [0.01], "quantities": DISPLACEMENT}
    ds = study.assess(problem, "average_acceleration", **options)
    row = ds.sel(scheme="average_acceleration", quantity="drift", allowed_error=0.01)
    dt, uncertainty = float(row.recommended_step_size), float(row.reference_uncertainty)
    run = study.run(problem, "average_acceleration", dt=dt, steps=int(DURATION / dt * (1 + 1e-9)))
    size = np.abs(exact(np.linspace(0, DURATION, 2001))).max()
    error = np.abs(run.u.values[:, 0] - exact(run.t.values)).max() / size
    assert 0 < error <= 0.01 and uncertainty < 1e-3
    assert float(row.recommended_error) == pytest.approx(error, abs=uncertainty)
