"""The state that a scheme carries from step to step, and the effort of a step."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from study.algebra.arrays import Vector
from study.algebra.counting import Counts


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
    forces, tangents
        Numbers of internal forces and of tangents that the iterations evaluated. What a step evaluates outside of its
        iterations is counted when the step is traced, and added by :mod:`study.scheme.contract`.
    factorisations, fixed_factorisations
        Numbers of matrices that were factorised: of iterations, and of systems whose matrix depends on the step size
        alone.
    """

    iterations: jax.Array | int = 0
    converged: jax.Array | bool = True
    committed: Any = None
    restarts: jax.Array | int = 0
    forces: jax.Array | int = 0
    tangents: jax.Array | int = 0
    factorisations: jax.Array | int = 0
    fixed_factorisations: jax.Array | int = 0

    def then(self, other: "Effort", committed: Any = None) -> "Effort":
        """Sum of the efforts of two balances, one after the other, with the history that was committed between them."""
        return Effort(
            self.iterations + other.iterations,
            self.converged & other.converged,
            committed,
            self.restarts + other.restarts,
            self.forces + other.forces,
            self.tangents + other.tangents,
            self.factorisations + other.factorisations,
            self.fixed_factorisations + other.fixed_factorisations,
        )

    def trial_effort(self) -> "Effort":
        """The evaluations of a trial step of its own size, as arrays, without its iterations."""
        none = jnp.zeros((), int)
        return Effort(
            none,
            jnp.ones((), bool),
            restarts=none,
            forces=none + self.forces,
            tangents=none + self.tangents,
            factorisations=none + self.factorisations + self.fixed_factorisations,
            fixed_factorisations=none,
        )

    def including(self, counts: Counts) -> "Effort":
        """The effort with the evaluations that were counted outside of iterations."""
        return self._replace(
            forces=self.forces + counts.forces,
            tangents=self.tangents + counts.tangents,
            fixed_factorisations=self.fixed_factorisations + len(counts.matrices),
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
