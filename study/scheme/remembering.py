"""A scheme on a force with a history: the history is committed at the end of every step."""

from typing import Any, ClassVar, NamedTuple

import equinox as eqx

from study.algebra.arrays import Vector
from study.equilibrium.state import Effort
from study.scheme.base import Scheme, Wrapper


class Remembered(NamedTuple):
    """State of the scheme, and the history that the last step committed."""

    inner: Any
    history: Any

    @property
    def u(self) -> Vector:
        """Displacement."""
        return self.inner.u

    @property
    def v(self) -> Vector:
        """Velocity."""
        return self.inner.v


class Remembering(Wrapper):
    """Another scheme on a force with a history, h.

    p and h₁ = force(u₁, u̇₁, h₀)

    Within a step every iteration and every stage takes the force from the history h₀ that the step before committed, as
    if the motion led straight from u₀ to the displacement of the stage. The end of the step commits h₁; the start
    commits that of a motion from rest straight to the first displacement. A scheme of sub-steps, each with a balance at
    its end, commits at the end of each of them, and hands the last but one out in its effort. A march wraps its scheme
    in this one if the problem has a history. Carries the state of the scheme and the history; one force a step more.

    Parameters
    ----------
    scheme
        Any scheme.

    References
    ----------
    J. C. Simo, T. J. R. Hughes, Computational inelasticity, Springer, 1998, section 1.4.
    """

    scheme: Scheme
    title: str = eqx.field(default="Remembering", kw_only=True, static=True)

    family: ClassVar[str] = "Remembering"
    source: ClassVar[str] = "Simo and Hughes (1998)"
    doi: ClassVar[str] = "10.1007/b98904"

    @property
    def evaluations(self) -> int:
        return self.scheme.evaluations + 1

    def start(self, problem, u0, v0, dt):
        problem = problem.committed(u0, v0)
        inner, effort = self.scheme.start(problem, u0, v0, dt)
        return Remembered(inner, problem.history), effort

    def step(self, problem, state, t, dt) -> tuple[Remembered, Effort]:
        problem = problem.at(state)
        inner, effort = self.scheme.step(problem, state.inner, t, dt)
        if effort.committed is not None:
            problem = problem.remembering(effort.committed)
        return Remembered(inner, problem.committed(inner.u, inner.v).history), effort._replace(committed=None)
