"""The motion along time, and quantities that follow from it."""

from collections.abc import Callable

import equinox as eqx

from study.observer.base import Record


class Trajectory(Record):
    """Displacement and velocity along time."""

    variables = {
        "u": {"long_name": "displacement", "units": "1"},
        "v": {"long_name": "velocity", "units": "s-1"},
    }

    def sample(self, problem, initial, state):
        return {"u": state.u, "v": state.v}


class Quantity(Record):
    """Your own quantity along time, a function of u and u̇.

    Parameters
    ----------
    function
        Function of u and u̇, each of shape () or (n,), that returns a number. It must be written with ``jax.numpy``.
    name, long_name, units
        Name and attributes of the variable in the dataset.
    """

    function: Callable
    name: str = eqx.field(static=True)
    long_name: str = eqx.field(static=True)
    units: str = eqx.field(default="1", static=True)

    @property
    def variables(self) -> dict[str, dict[str, str]]:  # type: ignore[override]
        return {self.name: {"long_name": self.long_name, "units": self.units}}

    def sample(self, problem, initial, state):
        return {self.name: self.function(state.u, state.v)}
