"""Trajectories and quantities of one's own."""

from functools import partial

import numpy as np
import pytest

import study
from study.problem import chains


def test_a_quantity_of_the_user_is_recorded():
    first = study.Quantity(partial(chains.oscillatory_energy, 0), "i_1", "energy of the first spring", "J")
    ds = study.run(chains.fpu_chain(), "rk4", dt=0.002, steps=10, observe=["trajectory", first])
    assert ds.i_1.dims == ("t",) and ds.i_1.attrs == {"long_name": "energy of the first spring", "units": "J"}
    assert ds.i_1[0] == pytest.approx(1.0)
    np.testing.assert_allclose(ds.i_1, (ds.v[:, 3] ** 2 + 2500 * ds.u[:, 3] ** 2) / 2, rtol=1e-12)
