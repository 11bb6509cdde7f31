"""Claims on the bound of the energy error: each check is tested where it holds and where it fails."""

import numpy as np
import xarray as xr

from paper.claims import step_bound as claims
from tests.paper.claims.made_up import filled


def _bound(errors):
    """A dataset like stability/step_bound.nc, with a predicted energy error of 1 % and the given measured ones."""
    along = {"scheme": claims.SCHEMES, "motion": range(len(errors)), "quantity": ["energy", "period"]}
    error = filled(1.0, **along) * np.reshape(errors, (-1, 1))
    data = xr.Dataset({"measured_error": error, "coefficient": filled(0.25, **along)})
    data["omega_step"] = filled(0.2, scheme=claims.SCHEMES, motion=range(len(errors)))
    data["convex_coefficient"] = ("scheme", [1 / 4, 1 / 6])
    titles = [f"spring {k}" for k in range(len(errors))]
    return data.assign_coords(potential_title=("motion", titles), u0=("motion", np.ones(len(errors))))


def test_the_modified_energy_predicts_or_not():
    held = claims.modified_energy_predicts(_bound([0.0101] * 19 + [0.02]))
    assert held.holds and held.ours == "38 of 40; 2.00" and held.qualification == "except for “spring 19” from 1"
    assert not claims.modified_energy_predicts(_bound([0.0101] * 9 + [0.02])).holds
    assert not claims.modified_energy_predicts(_bound([np.nan])).holds


def _rule(ratio):
    """A dataset like stability/step_rule.nc, with the given ratio of the energy error to the bound up to ωΔt = 0.1718.

    The texts print this step as 0.17.
    """
    steps = np.array([0.1, 0.1718, 0.3])
    data = filled(1.0, scheme=claims.SCHEMES, problem=claims.CONVEX, amplitude=[1.0, 2.0], omega_step=steps)
    error = data * np.where(steps < 0.18, ratio, 9.0) * steps**2
    error = error * xr.DataArray([1 / 4, 1 / 6], {"scheme": claims.SCHEMES})
    rule = error.to_dataset(name="max_energy_error")
    described = filled(0.2, problem=claims.CONVEX, amplitude=[1.0, 2.0])
    return rule.assign(described_up_to=described).assign_coords(scheme_title=("scheme", ["A", "B"]))


def test_the_tangent_bounds_the_energy_or_not():
    bound = _bound([0.01])
    held = claims.tangent_bounds_the_energy(bound, _rule(0.99))
    assert held.holds and not held.qualification
    nearly = claims.tangent_bounds_the_energy(bound, _rule(1.05))
    assert nearly.holds and "add up to 10 %" in nearly.qualification and "A: 1.05; B: 1.05" == nearly.ours
    exceeded = claims.tangent_bounds_the_energy(bound, _rule(1.9))
    assert not exceeded.holds and "16 of 16 runs" in exceeded.qualification
    assert not claims.tangent_bounds_the_energy(bound, _rule(np.nan)).holds
    # only half of the motions change their tangent so slowly that the bound holds
    half = _rule(1.9).assign(described_up_to=lambda ds: ds.described_up_to.where(ds.amplitude < 2, 0.0))
    assert "8 of 8 runs" in claims.tangent_bounds_the_energy(bound, half).qualification
