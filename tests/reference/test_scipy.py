"""SciPy's solvers."""

import numpy as np
import pytest

import study
from reference import exact, scipy


@pytest.mark.parametrize("method", ["DOP853", "Radau"])
def test_scipy_meets_the_reference_and_refuses_tolerances_out_of_reach(method):
    problem, t = study.problems["double_well"], np.linspace(0.5, 8.0, 16)
    solution = scipy.trajectory(problem, t, 1e-9, method=method)
    np.testing.assert_allclose(solution.u, exact.trajectory(problem, t).u, atol=1e-6)
    with pytest.raises(ValueError, match=f"SciPy {method} cannot reach a tolerance of 1e-16"):
        scipy.trajectory(problem, t, 1e-16, method=method)
    with pytest.raises(ValueError, match=f"SciPy {method} needs times that are finite"):
        scipy.trajectory(problem, t[::-1], 1e-6, method=method)
