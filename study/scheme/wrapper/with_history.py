"""A scheme on a force with a history: the history is committed at the end of every step."""

from typing import Any, ClassVar

import equinox as eqx

from study.mechanics.state import Effort
from study.scheme.base import Scheme, Wrapper, WrapperState


class StateWithHistory(WrapperState):
    """State of the wrapped scheme, and the history that the last step committed."""

    inner: Any
    history: Any


class WithHistory(Wrapper):
    r"""Another scheme on a force with a history, h.

    .. math::

        (p, h_1) = \text{force}(u_1, \dot u_1, h_0)

    Within a step, every iteration and every stage evaluates the force from the history h₀ that the previous step
    committed, for a straight motion from u₀ to the displacement of this iteration or stage. The end of the step commits
    h₁; the start commits the history after a straight motion from the state at rest to u₀. The composite methods of
    Bathe and the method of Noh and Bathe also commit at the ends of their earlier sub-steps. Their effort holds the
    history from which the last sub-step started. A march wraps its scheme in this wrapper if the problem has a history.
    Carries the state of the wrapped scheme and the history; one additional force per step.

    Parameters
    ----------
    scheme
        Any scheme.

    References
    ----------
    J. C. Simo, T. J. R. Hughes, Computational inelasticity, Springer, 1998, section 1.4.
    """

    scheme: Scheme
    title: str = eqx.field(default="With history", static=True)

    family: ClassVar[str] = "With history"
    source: ClassVar[str] = "Simo and Hughes (1998)"
    doi: ClassVar[str] = "10.1007/b98904"

    def start(self, problem, u0, v0, dt):
        problem = problem.remembering(problem.at_time(0.0).committed(u0, v0).history)
        inner, effort = self.scheme.start(problem, u0, v0, dt)
        return StateWithHistory(inner, problem.history), effort

    def step(self, problem, state, t, dt) -> tuple[StateWithHistory, Effort]:
        problem = problem.at(state)
        inner, effort = self.scheme.step(problem, state.inner, t, dt)
        if effort.committed is not None:
            problem = problem.remembering(effort.committed)
        return StateWithHistory(inner, problem.at_time(t + dt).committed(inner.u, inner.v).history), effort._replace(
            committed=None
        )
