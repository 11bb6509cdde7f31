"""Claims beyond the paper, on stability and structures: each check can come out either way."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import stability, structures
from tests.paper.claims.made_up import filled


@pytest.mark.parametrize(
    "a_step, apart, holds, ours",
    [(0.051, 75, True, "0.05; 75"), (0.049, 75, False, "0.05; 75"), (0.1, -1, False, "0.10; never")],
)
def test_a_map_is_chaotic_by_its_exponent_and_its_perturbation(a_step, apart, holds, ours):
    variables = {"lyapunov_exponent": ("dt", [a_step / 2.5]), "steps_until_apart": ("dt", [apart])}
    finding = stability.chaos_of_average_acceleration({"stability/bifurcation": xr.Dataset(variables, {"dt": [2.5]})})
    assert (finding.holds, finding.ours) == (holds, ours)


@pytest.mark.parametrize(
    "steps, holds, reason",
    [
        ([20, 20, 20], True, ""),
        ([20, np.nan, 20], True, "only on hardening and double well"),
        ([20, 21, np.nan], False, "only on hardening"),
        ([32, 21, np.nan], False, "only on none"),
    ],
)
def test_a_twentieth_is_reasonable_where_twenty_steps_suffice(steps, holds, reason):
    problems = ["hardening", "softening", "double_well"]
    needed = filled(99.0, problem=problems, scheme=["average_acceleration"], level=[1.0, 10.0], periods=[10, 100])
    needed.loc[{"level": 10.0, "periods": 100}] = np.reshape(steps, (3, 1))
    data = {"stability/robustness": xr.Dataset({"steps_needed": needed, "most_steps": 128})}
    finding = stability.a_twentieth_at_every_amplitude(data)
    assert (finding.holds, finding.qualification) == (holds, reason)
    assert ("more than 128" in finding.ours) == bool(np.isnan(steps).any())


def _structures(error=0.01, imbalance=1.0):
    """Runs on two structures that keep the balance of energies, and those of one scheme as they are given."""
    schemes = ["average_acceleration", "central_difference", "newmark_dissipative", "wilson_theta", "houbolt", "rk4"]
    along = {"problem": ["stiff_soft", "fpu_chain"], "scheme": schemes, "steps_per_period": [20]}
    runs = xr.Dataset({"status": filled(0, **along), "displacement_error": filled(error, **along)})
    return {"structures": runs.assign(max_energy_imbalance=filled(imbalance, **along))}


@pytest.mark.parametrize("error, holds", [(0.099, True), (0.101, False), (np.nan, False)])
def test_a_twentieth_on_structures_is_decided_by_the_displacement(error, holds):
    finding = structures.a_twentieth_on_structures(_structures(error))
    assert finding.holds == holds and ("failed" in finding.ours) == np.isnan(error)


@pytest.mark.parametrize("imbalance, kept", [(9.9, True), (10.1, False)])
def test_a_balance_is_kept_within_what_is_reasonable(imbalance, kept):
    data = _structures(imbalance=imbalance)
    assert bool(structures.kept(data).all()) == kept
    assert structures.damping_on_the_chain(data).holds != kept
    assert structures.explicit_on_stiff_structures(data).holds != kept
