"""Claims on the growth of errors with the length of the run: each check is tested where it holds and where it fails."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import error_growth as claims
from tests.paper.claims.made_up import filled

SCHEMES = ["central_difference", "bathe"]


def _growth(kept=1.0, lost=2.0, error=0.09):
    """A dataset like error_growth.nc, whose phase errors grow with the given powers; the energy is lost at 1000."""
    along = {"problem": ["hardening"], "scheme": SCHEMES, "steps_per_period": [32, 64]}
    powers = xr.DataArray([kept, lost], dims="scheme")
    data = filled(1e-4, **along, periods=[1, 10, 100, 1000]).to_dataset(name="phase_error")
    data["phase_error"] = data.phase_error * data.periods**powers
    data["max_energy_error"] = xr.full_like(data.phase_error, 0.01)
    data["max_energy_error"][0, 1, :, -1] = 0.9
    data["flagged"] = xr.zeros_like(data.phase_error).expand_dims(measure=["phase_error"])
    data["extrapolated_error"] = ("problem", "scheme"), [[0.05, error]]
    data["extrapolated_steps_per_period"] = ("problem", "scheme"), [[200.0, 300.0]]
    return data.assign_coords(
        order_of_loss=("scheme", [np.inf, 3]), allowed_error=0.1, scheme_title=data.scheme, problem_title=data.problem
    )


def test_the_phase_error_grows_with_the_law_or_not():
    finding = claims.phase_error_grows(_growth())
    assert finding.holds and finding.ours == "1.00 and 2.00"
    assert (
        not claims.phase_error_grows(_growth(kept=1.5)).holds and not claims.phase_error_grows(_growth(lost=1.0)).holds
    )
    resonant = claims.phase_error_grows(_growth(kept=1.5)).qualification
    assert resonant.endswith("resonate with the motion: central_difference on hardening")
    growth = _growth()
    growth["phase_error"][0, 1, :, 3] = 1e9  # after the energy is lost
    assert claims.exponents(growth, "phase_error").values.tolist() == [[pytest.approx(1), pytest.approx(2)]]
    assert not claims.phase_error_grows(_growth().isel(scheme=[0])).holds


def test_extrapolated_steps_keep_the_error_or_not():
    assert claims.extrapolated_steps_keep(_growth()).ours == "2 of 2; 0.90"
    beyond = claims.extrapolated_steps_keep(_growth(error=0.107))
    assert not beyond.holds and beyond.ours == "1 of 2; 1.07" and beyond.qualification.endswith("bathe on hardening")
    assert not claims.extrapolated_steps_keep(_growth(error=np.nan)).holds
    none = {"extrapolated_steps_per_period": _growth().extrapolated_steps_per_period * np.nan}
    assert not claims.extrapolated_steps_keep(_growth().assign(none)).holds
