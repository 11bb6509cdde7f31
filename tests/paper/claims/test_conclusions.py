"""Claims of the conclusions, on made-up datasets at both sides of their bounds."""

import pytest
import xarray as xr

from paper.claims import conclusions
from paper.claims.ledger import Verdict

PARTS = [0.01, 0.05, 0.1]


def _large_steps(**worst):
    """A dataset as large_steps.nc has it: errors at a twentieth of the period by problem, 99 % at larger steps."""
    schemes = ["average_acceleration", "central_difference", "houbolt"]
    dims = ["problem", "scheme", "dt_over_period"]
    error = xr.DataArray(99.0, dict(zip(dims, (list(worst), schemes, PARTS), strict=True)), dims).copy()
    for problem, value in worst.items():
        faithful = {"problem": problem, "scheme": ["average_acceleration", "central_difference"]}
        error.loc[faithful | {"dt_over_period": [0.01, 0.05]}] = 1.0
        error.loc[{"problem": problem, "scheme": "central_difference", "dt_over_period": 0.05}] = value
    return {"large_steps": xr.Dataset({"max_energy_error": error})}


@pytest.mark.parametrize(
    "worst, verdict",
    [
        ({"hardening": 9.9, "softening": 9.9, "double_well": 9.9}, Verdict.REPRODUCED),
        ({"hardening": 9.9, "softening": 9.9, "double_well": 10.1}, Verdict.QUALIFIED),
        ({"hardening": 10.1, "softening": 9.9, "double_well": 9.9}, Verdict.NOT_REPRODUCED),
        ({"hardening": 9.9, "softening": 10.1, "double_well": 9.9}, Verdict.NOT_REPRODUCED),
    ],
)
def test_reasonable_is_an_error_below_ten_per_cent(worst, verdict):
    finding = conclusions.reasonable_below_a_twentieth(_large_steps(**worst))
    assert finding.verdict == verdict
    beyond = [name for name, value in worst.items() if value > 10]
    assert finding.qualification.endswith(f"above 10 % on {', '.join(beyond)}" if beyond else "")
    assert bool(finding.qualification) == bool(beyond)
