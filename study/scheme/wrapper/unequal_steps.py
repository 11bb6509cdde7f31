"""A scheme on steps of different sizes: its carried acceleration is moved when the size of the step changes."""

from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp

from study.algebra.arrays import Vector
from study.mechanics.balance import acceleration
from study.scheme.base import Scheme, Wrapper, WrapperState

CORRECTIONS = ("difference", "balance", "none")


class StateOfStep(WrapperState):
    """State of the wrapped scheme, the acceleration with which its last step began, and the size of this step."""

    inner: Any
    before: Vector
    size: jax.Array


class UnequalSteps(Wrapper):
    r"""Another scheme on steps of different sizes.

    An α-method carries an acceleration that belongs to the time t₁ + s Δt, with its ``acceleration_offset`` s. If the
    next step has another size Δt', the method assumes that the acceleration belongs to t₁ + s Δt'. The method drops to
    first order unless the carried acceleration is moved to that time. Let ü₀ and ü₁ be the carried accelerations with
    which the last step began and ended, and a₁ the acceleration at t₁ itself. The move is

    .. math::

        \ddot u &\leftarrow \ddot u_1 + s \left(\frac{\Delta t'}{\Delta t} - 1\right) (\ddot u_1 - \ddot u_0)
            \quad\text{(difference)} \\
        \ddot u &\leftarrow a_1 + \frac{\Delta t'}{\Delta t} (\ddot u_1 - a_1), \quad
            M a_1 = f(t_1) - C \dot u_1 - p(u_1) \quad\text{(balance)}

    For equal steps, order and stability are those of the wrapped scheme. Carries the state of the wrapped scheme, the
    acceleration with which the last step began, and the size of this step. The correction ``balance`` takes one
    additional force per step, the correction ``difference`` none.

    Parameters
    ----------
    scheme
        A scheme with an ``acceleration_offset``.
    correction
        ``"difference"``, ``"balance"`` or ``"none"``, which leaves the acceleration as it is.

    Raises
    ------
    TypeError, ValueError
        If ``scheme`` has no ``acceleration_offset``, or if ``correction`` is another word.

    References
    ----------
    L. O. Jay, D. Negrut, Extensions of the HHT-α method to differential-algebraic equations in mechanics, Electron.
    Trans. Numer. Anal. 26, 2007, 190-208.
    """

    scheme: Scheme
    correction: str = eqx.field(default="difference", static=True)
    title: str = eqx.field(default="Unequal steps", static=True)

    family: ClassVar[str] = "Unequal steps"
    source: ClassVar[str] = "Jay and Negrut (2007)"
    doi: ClassVar[str] = ""

    def __check_init__(self):
        if self.scheme.acceleration_offset is None:
            raise TypeError(
                f"UnequalSteps takes a scheme with an acceleration_offset, which '{self.scheme.title}' does not have."
            )
        if self.correction not in CORRECTIONS:
            raise ValueError(f"correction must be one of {', '.join(map(repr, CORRECTIONS))}, not {self.correction!r}.")

    def start(self, problem, u0, v0, dt):
        inner, effort = self.scheme.start(problem, u0, v0, dt)
        return StateOfStep(inner, inner.a, jnp.asarray(dt, float)), effort

    def step(self, problem, state, t, dt):
        a, ratio = state.inner.a, dt / state.size
        if self.correction == "difference":
            a = a + self.scheme.acceleration_offset * (ratio - 1) * (a - state.before)
        elif self.correction == "balance":
            a_end = acceleration(problem, t, state.u, state.v)
            a = a_end + ratio * (a - a_end)
        inner, effort = self.scheme.step(problem, state.inner._replace(a=a), t, dt)
        return StateOfStep(inner, a, jnp.asarray(dt, float)), effort
