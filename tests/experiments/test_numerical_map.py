"""Iterates of numerical maps."""

import numpy as np

import study
from study.experiments.numerical_map import numerical_map


def test_the_numerical_map_keeps_every_iterate():
    ds = numerical_map(
        "double_well", ["energy_momentum"], [1.0, 2.0], {"first": 0.5, "last": 1.2, "count": 3}, steps=20
    )
    alone = study.run("double_well", "energy_momentum", dt=2.0, u0=[1.2], steps=20)
    np.testing.assert_allclose(ds.u.sel(scheme="energy_momentum", step_size=2.0, u0=1.2), alone.u[0], rtol=1e-6)
    assert (ds.status == 0).all()
