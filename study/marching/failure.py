"""The message of a failed run: scheme, step, time and the likely cause."""

import jax
import jax.numpy as jnp
import numpy as np

from study.marching import stability
from study.marching.pure import final_state
from study.marching.result import COMPLETED, NO_SOLUTION, NOT_FINITE, UNBOUNDED, Result
from study.marching.shapes import PerRun
from study.mechanics.definition import Problem
from study.mechanics.frequencies import frequencies
from study.mechanics.function_checks import DOUBLE_WHERE
from study.scheme.base import Scheme

#: Reactions of :func:`study.run` to a failed run, and that of :data:`study.marching.run.sweep` to failed runs and to
#: steps beyond the stability limit: none.
ON_FAILURE, SILENT = ("warn", "raise", "ignore"), "silent"

#: Largest ωΔt of the stiffest mode at which smaller steps do not help Newton's iteration.
RESOLVED = 0.01

#: Displacements at which the derivative of a force is examined after a failure, as multiples of u̇ Δt from the last
#: state.
EXAMINED = np.linspace(-1.0, 2.0, 61)

#: Descriptions of failures, by status.
HOW = {
    NO_SOLUTION: "Newton's iteration found no balance of forces, not even with a safeguard",
    NOT_FINITE: "the state was no longer finite",
    UNBOUNDED: "the displacement left its bound",
}


class RunFailedWarning(RuntimeWarning):
    """A run failed: its values are NaN. Its samples are NaN from the failure on, or end there in a controlled run."""


def likely_cause(
    problem: Problem, scheme: Scheme, status: int, dt: float, motion: stability.SmallMotion | None = None
) -> str:
    """One sentence on the likely cause of a failure; in most cases it names a remedy.

    ``motion`` has the matrices of small motions about the start, by default those of the problem.
    """
    if stability.has_limit(scheme, problem):
        motion = stability.at_start(problem) if motion is None else motion
        if stability.excess(scheme, motion, dt, np.inf):
            stable, _ = stability.stable_part(scheme, motion, dt)
            remedy = "smaller steps or an implicit scheme" if stable else "another scheme, or steps of little growth"
            return f"{stability.sentence(scheme, motion, dt)}; take {remedy}."
    modes = frequencies(problem)
    highest = None if modes is None else modes[-1]
    beyond = ", and may be larger beyond the kinks of the force" if problem.kinked else ""
    at_start = "" if highest is None else f" (ωΔt of the stiffest mode is {highest * dt:.3g} at the start{beyond})"
    if highest == 0:
        at_start = " (at the start no mode oscillates, and the motion may also grow by itself)"
    if status == NO_SOLUTION and problem.massless:
        return (
            "the equation of an unknown without mass has no root or several at this point of the motion; check that "
            "its force determines the unknown."
        )
    if status == NO_SOLUTION and highest and highest * dt < RESOLVED:
        return f"the force jumps along the motion, because the step resolves every mode{at_start}; make it continuous."
    if status == NO_SOLUTION:
        return (
            "the force changes too much over a step, or the effective equation has no root or several; take smaller "
            "steps."
        )
    if not np.isfinite(problem.at_time(0.0).internal_force(problem.u0, problem.v0)).all():
        return "the force is not finite at the start."
    if scheme.explicit and not (highest and highest * dt < 1):
        limit = scheme.stability_limit
        known = f", ωΔt = {limit:.4g} without damping" if limit and np.isfinite(limit) else ""
        return (
            f"the step may be beyond the limit of stability of an explicit scheme{known}{at_start}; take smaller steps "
            "or an implicit scheme."
        )
    massless = ", or an unknown without mass has no stiffness" if problem.massless else ""
    return (
        f"the motion grows without bound, or the force is not finite along it{massless}; take smaller steps, or a "
        "scheme that conserves or dissipates energy."
    )


def cause_of_derivative(problem: Problem, t: float, u, v, dt: float) -> str:
    """A sentence if the derivative of the force is not finite within a step from a state, although the force is.

    Newton's iteration has no correction there. The sentence is empty if there is no such displacement.
    """

    def is_lost(part):
        now = problem.at_time(t + part * dt)
        force, slope = jax.jvp(lambda u: now.varying_force(u, v), (u + part * dt * v,), (jnp.ones_like(u),))
        return jnp.isfinite(force).all() & ~jnp.isfinite(slope).all()

    if problem.linear or not jax.vmap(is_lost)(jnp.asarray(EXAMINED)).any():
        return ""
    return f"the derivative of the force is not finite there, although the force is: {DOUBLE_WHERE}."


def sentence(
    result: Result,
    problem: Problem,
    scheme: Scheme,
    begin: tuple | None,
    dt: PerRun,
    motion: stability.SmallMotion | None,
    first_lane: int = 0,
) -> str:
    """Two sentences on the first failed run, with the number of failed lanes; empty if all runs completed.

    ``begin`` has the initial displacements and velocities; None for lanes with problems of their own. ``first_lane`` is
    the number of the first lane of the result.
    """
    failed = np.flatnonzero(result.status != COMPLETED)
    if not failed.size:
        return ""
    first = failed[0]
    status, step = (int(np.ravel(values)[first]) for values in (result.status, result.failed_at_step))
    size = float(np.broadcast_to(dt, np.shape(result.status)).ravel()[first])
    how = HOW[status]
    many = f"{failed.size} of {result.status.size} runs failed, the first of them, lane {first_lane + first}: "
    where = f"'{scheme.title}' failed on '{problem.title}' at step {step}, t = {step * size:.6g}, with dt = {size:.6g}"
    cause = ""
    if begin is not None and not (scheme.explicit or problem.linear):
        u, v = (jnp.asarray(x[first] if np.ndim(result.status) else x) for x in begin)
        if step > 1:  # the state before the step that failed
            before = final_state(problem, scheme, dt=size, steps=step - 1, u0=u, v0=v)
            u, v = before["u"], before["v"]
        cause = cause_of_derivative(problem, (step - 1) * size, u, v, size)
    cause = cause or likely_cause(
        problem, scheme, status, size, None if motion is None else motion.matrices_of_lane(first)
    )
    return f"{many if np.ndim(result.status) else ''}{where}: {how}. Likely cause: {cause}"
