"""The effort of a run."""

import jax.numpy as jnp

from study.observer.base import Reduction


class NewtonIterations(Reduction):
    """Newton iterations of a run: their sum, and the largest number in one step."""

    variables = {
        "newton_iterations": {"long_name": "Newton iterations in all steps", "units": "1"},
        "max_newton_iterations": {"long_name": "most Newton iterations in one step", "units": "1"},
    }

    def start(self, problem, state):
        return jnp.zeros((), int), jnp.zeros((), int)

    def update(self, carried, problem, state, t, effort):
        total, most = carried
        return total + effort.iterations, jnp.maximum(most, effort.iterations)

    def result(self, carried, problem, state):
        return dict(zip(self.variables, carried, strict=True))
