"""What a scheme carries from step to step, and the effort of a step."""

from typing import NamedTuple

import jax


class Effort(NamedTuple):
    """What a step took: Newton iterations (each one tangent and one solve), and whether they converged."""

    iterations: jax.Array | int = 0
    converged: jax.Array | bool = True

    def then(self, other: "Effort") -> "Effort":
        """What two balances took together."""
        return Effort(self.iterations + other.iterations, self.converged & other.converged)


class Phase(NamedTuple):
    """Displacement and velocity, each of shape () or (n,)."""

    u: jax.Array
    v: jax.Array


class Motion(NamedTuple):
    """Displacement, velocity and (algorithmic) acceleration at one time, each of shape () or (n,)."""

    u: jax.Array
    v: jax.Array
    a: jax.Array
