"""Histories of structures, with the published start of the chain of Fermi, Pasta and Ulam."""

import numpy as np
import pytest
import xarray as xr

import study
from study.experiments import structure_history as experiment


def _reference(problem: str) -> xr.Dataset:
    """A reference with two samples, both of the start."""
    start = study.problems[problem]
    states = {name: (("t", "component"), np.stack([x, x])) for name, x in (("u", start.u0), ("v", start.v0))}
    return xr.Dataset(states, {"t": [0.0, 1.0]})


def test_the_chain_begins_with_the_energy_of_its_first_stiff_spring(monkeypatch):
    """I₁ = 1 and I₂ = I₃ = 0 (Hairer, Lubich and Wanner, Geometric numerical integration, section I.5.1)."""
    monkeypatch.setattr(experiment.io, "open_dataset", lambda name: _reference("fpu_chain"))
    ds = experiment.structure_history("fpu_chain", ["central_difference", "bathe"], 320, 0.5, 1)
    names = [f"oscillatory_energy_{spring}" for spring in (1, 2, 3)]
    for prefix in ("", "reference_"):
        energies = np.stack([ds[prefix + name].values[..., 0] for name in names], axis=-1)
        np.testing.assert_allclose(energies, np.broadcast_to([1.0, 0.0, 0.0], energies.shape), atol=1e-12)
    sums = sum(ds[name] for name in names)
    np.testing.assert_allclose(ds.max_sum_change, abs(sums - 1).max("t"), rtol=1e-12)
    assert (ds.max_sum_change > 0.01).all()


@pytest.mark.parametrize("problem, has_energy", [("stiff_soft", False), ("elastic_pendulum", True)])
def test_a_structure_from_rest_has_no_relative_error_of_energy(problem, has_energy):
    assert ("energy_error" in experiment._observers(problem, study.problems[problem])) == has_energy


def test_samples_are_a_whole_part_of_the_steps():
    whole, broken = (experiment._check({"periods": 1.0, "steps_per_period": 20, "every": k}, {}) for k in (4, 3))
    assert whole is None and broken == "every, 3, does not divide the number of steps, 20."
