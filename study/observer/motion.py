"""The motion along time, and quantities of it."""

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
    """A number of your own along time, a function of u and u̇.

    Parameters
    ----------
    function
        Takes u and u̇, each of shape () or (n,), and returns a number.
    name, long_name, units
        What the dataset calls it.
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
