"""The parts of your own scheme.

A scheme is a :class:`study.Scheme`: frozen parameters with two pure functions, which JAX compiles, vectorises and
differentiates.

- ``start(problem, u0, v0, dt)`` returns the state at t = 0, and ``step(problem, state, t, dt)`` returns the state at
  t + Δt, both in a tuple with the :class:`Effort`. A step does not change fields, shapes or types of the state.
- A state is a :class:`Phase` (u, u̇), a :class:`Motion` (u, u̇, ü), or your own named tuple with ``u`` and ``v``.
- A :class:`study.OneStep` has ``increment(problem, state, t, dt)`` in place of ``step``. It also returns a
  state and the :class:`Effort`, but the fields ``u`` and ``v`` of this state hold the increments of u and u̇.
  :class:`study.Compensated` adds these increments by compensated sums. A :class:`study.OneStep` without its own
  ``start`` begins with the acceleration of the equation of motion.
- ``title``, ``source``, ``doi``, ``order``, ``explicit`` and ``stability_limit`` describe the scheme.
  ``order_with_damping`` has a default, to be replaced where it does not fit. ``family`` names the panel in which
  figures of the study draw the scheme.
- The observer ``effort`` counts the forces that a step evaluates by the functions below or by the problem. A scheme
  that evaluates them in a loop of its own adds the passes of the loop to the ``forces`` of its :class:`Effort`.

An explicit step solves the equation of motion for ü by :func:`acceleration`. An implicit step needs the
acceleration that balances the forces; :func:`balance` finds it by Newton's iteration. :func:`load` is f(t), and
:func:`at` returns the problem at the time t with f(t), as in ``balance(*at(problem, t + dt), ...)``. If a force takes
the time, a scheme that evaluates it without :func:`at`, :func:`acceleration` or ``problem.at_time(t)`` is refused.
"""

from study.mechanics.balance import acceleration as acceleration
from study.mechanics.balance import acceleration_within as acceleration_within
from study.mechanics.balance import at as at
from study.mechanics.balance import balance as balance
from study.mechanics.balance import initial_acceleration as initial_acceleration
from study.mechanics.balance import load as load
from study.mechanics.state import Effort as Effort
from study.mechanics.state import Motion as Motion
from study.mechanics.state import Phase as Phase
