"""The state that a scheme carries from step to step, and the effort of a step."""

from typing import Any, NamedTuple

import jax

from study.algebra.arrays import Vector


class Effort(NamedTuple):
    """Effort of a step.

    Attributes
    ----------
    iterations, converged
        Number of Newton iterations, and whether they converged. An iteration takes one tangent and one linear solve;
        with a safeguard it may take several solves.
    committed
        History of the force from which the last sub-step started, if the step commits it between sub-steps; see
        :class:`study.scheme.wrapper.with_history.WithHistory`.
    restarts
        How often Newton's iteration failed and was started again with a safeguard.
    """

    iterations: jax.Array | int = 0
    converged: jax.Array | bool = True
    committed: Any = None
    restarts: jax.Array | int = 0

    def then(self, other: "Effort", committed: Any = None) -> "Effort":
        """Sum of the efforts of two balances, one after the other, with the history that was committed between them."""
        return Effort(
            self.iterations + other.iterations,
            self.converged & other.converged,
            committed,
            self.restarts + other.restarts,
        )


class Phase(NamedTuple):
    """Displacement u and velocity v = u̇, each of shape () or (n,)."""

    u: Vector
    v: Vector


class Motion(NamedTuple):
    """Displacement u, velocity v and (algorithmic) acceleration a at one time, each of shape () or (n,)."""

    u: Vector
    v: Vector
    a: Vector
