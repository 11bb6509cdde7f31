"""diffrax: the explicit Runge-Kutta method Dopri8 under step size control."""

import diffrax
import jax.numpy as jnp
import numpy as np

from study.problem import Problem

RTOL, ATOL = 1e-14, 1e-16
MAX_STEPS = 1_000_000


def _final_and_saved(problem: Problem, t1, t: np.ndarray | None = None):
    """Solution from 0 to ``t1``, saved at ``t`` or at the end; steps are clipped to these times, never interpolated."""
    times = jnp.asarray([t1] if t is None else t)
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(lambda t, y, args: jnp.stack([y[1], -problem.force(y[0])])),
        diffrax.Dopri8(),
        t0=0.0,
        t1=t1,
        dt0=None,
        y0=jnp.stack([problem.u0, problem.v0]),
        stepsize_controller=diffrax.ClipStepSizeController(diffrax.PIDController(rtol=RTOL, atol=ATOL), step_ts=times),
        saveat=diffrax.SaveAt(ts=times),
        max_steps=MAX_STEPS,
    )
    return np.asarray(solution.ys)


def trajectory(problem: Problem, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity at the times ``t`` (shape (n,)) of an undamped, unloaded oscillator."""
    y = _final_and_saved(problem, t[-1], t)
    return y[:, 0], y[:, 1]


def period(problem: Problem, estimate: float) -> float:
    """Twice the time to the next turning point: Newton's iteration on the velocity, each time integrated anew."""
    t = 0.5 * estimate
    for _ in range(8):
        ((u, v),) = _final_and_saved(problem, t)
        correction = v / float(problem.force(u))
        t += correction
        if abs(correction) <= 4 * np.finfo(float).eps * t:
            break
    return 2 * t
