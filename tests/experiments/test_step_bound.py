"""Step bounds of motions in several potentials, against runs."""

import pytest

import study
from study.experiments import step_bound as experiment


def test_runs_confirm_the_modified_energy(monkeypatch):
    """A wrong coefficient of the modified energy in a potential without a closed form."""
    chosen = {"tanh": (*experiment.POTENTIALS["tanh"][:2], (0.5, 3)), "morse": experiment.POTENTIALS["morse"]}
    monkeypatch.setattr(experiment, "POTENTIALS", chosen)
    ds = experiment.step_bound(0.01, 10).sel(scheme="central_difference")
    assert ds.sizes["motion"] == 2 + 5 and ds.potential.values[-1] == "morse"
    predicted = ds.coefficient * ds.omega_step**2
    assert predicted.sel(quantity="energy").values == pytest.approx(0.01)
    assert (abs(ds.measured_error / predicted - 1) < 0.03).all()
    bound = study.step_bound(study.Problem(potential=chosen["morse"][1], u0=-0.3), "central_difference", 0.01, 10)
    assert ds.coefficient[3].values == pytest.approx(bound.coefficient.values[:2], rel=1e-9)
