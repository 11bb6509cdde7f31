"""Callable objects that Python cannot hash as functions of a problem and of a quantity."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

import study


@dataclasses.dataclass
class Spring:
    """A dataclass, which Python cannot hash."""

    k: float = 4.0

    def __call__(self, u):
        return self.k * u


@dataclasses.dataclass(frozen=True)
class OfDictionary:
    """A dataclass whose hash fails, because a dictionary in it has none."""

    values: dict

    def __call__(self, u):
        return self.values["k"] * u


@dataclasses.dataclass
class Push:
    """A constant load that declares a time."""

    force: float = 2.0
    kinks: tuple = (0.5,)

    def __call__(self, t):
        return self.force * jnp.ones_like(t)


@pytest.mark.slow
@pytest.mark.parametrize("spring", [Spring(), OfDictionary({"k": 4.0})])
def test_an_object_without_a_hash_is_a_force_a_load_and_a_quantity(spring):
    """With k u = f + (k u₀ − f) cos ωt, also after the load has changed."""
    push = Push()
    problem = study.Problem(spring, u0=1.0, load=push)
    observe = study.Quantity(spring, name="pull", reduce="final")
    for force in (2.0, 3.0):
        push.force = force
        exact = force + (4.0 - force) * np.cos(2.0)
        equal = [study.run(problem, "rk4", dt=0.01, steps=100, observe=observe) for _ in range(2)]
        controlled = study.run(problem, "rk4", tolerance=1e-9, duration=1.0, observe=[observe, "trajectory"])
        for ds in (*equal, controlled):
            assert float(ds.pull) == pytest.approx(exact, rel=1e-6)
        assert 0.5 in controlled.t.values
        assert float(study.final_state(problem, "rk4", dt=0.01, steps=100)["u"]) == pytest.approx(exact / 4, rel=1e-6)


def test_two_problems_with_one_object_without_a_hash_share_a_program(compiled):
    spring = Spring()
    first, second = (study.Problem(spring, u0=1.0) for _ in range(2))
    study.run(first, "rk4", dt=0.01, steps=100)
    count = len(compiled)
    study.run(second, "rk4", dt=0.01, steps=100)
    assert len(compiled) == count
