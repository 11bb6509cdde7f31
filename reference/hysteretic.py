"""The smooth hysteresis of Bouc and Wen by CVODE, which solves its rate equation beside the motion.

    ü = f − c u̇ − b k u − (1 − b) k u_y y,    ẏ = (u̇ / u_y) (1 − ½ |y|ⁿ (1 + sgn(y u̇)))

The rate has a kink where u̇ or y is zero. CVODE finds these events by its root finding and starts anew there.
"""

import time

import numpy as np
from sksundae.cvode import CVODE

from reference.solution import ATOL_BELOW_RTOL, RouteFailed, Solution, Times, check_tolerance
from study.problem.definition import Problem
from study.problem.materials import BoucWen

SMALLEST_RTOL = 1e-14
MAX_NUM_STEPS = 1_000_000


def trajectory(problem: Problem, t: Times, rtol: float = 1e-12, method: str = "Adams") -> Solution:
    """Displacement and velocity at the increasing times ``t`` of one mass on a Bouc-Wen spring, without load.

    Raises
    ------
    ValueError
        If the tolerance cannot be reached, or the problem is another one.
    RouteFailed
        If CVODE stops early.
    """
    check_tolerance(f"CVODE {method}", rtol, SMALLEST_RTOL)
    spring = problem.force
    if not isinstance(spring, BoucWen) or np.ndim(problem.u0) or problem.load is not None:
        raise ValueError(f"'{problem.title}' is no single mass on a Bouc-Wen spring without load.")
    k, b = float(spring.stiffness), float(spring.hardening)
    bound = float(spring.yield_force) / k
    mass = 1.0 if problem.mass is None else float(problem.mass)
    damping = 0.0 if problem.damping is None else float(problem.damping)

    def fill(t, state, rate):
        u, v, y = state.tolist()
        rate[0], rate[1] = v, (-damping * v - b * k * u - (1 - b) * k * bound * y) / mass
        rate[2] = v / bound * (1 - abs(y) ** spring.exponent * (y * v > 0))

    def kinks(t, state, events):
        events[0], events[1] = state[1], state[2]

    kinks.terminal = [True, True]  # type: ignore[attr-defined]
    begin, evaluations = time.perf_counter(), 0
    # the first force is that after a motion straight to u0
    _, (_, y0) = spring(problem.u0, problem.v0, problem.history)
    now, state = 0.0, np.array([float(problem.u0), float(problem.v0), float(y0)])
    found = np.empty((len(t), 3))
    while now < t[-1]:
        options = {"rtol": rtol, "atol": rtol * ATOL_BELOW_RTOL, "max_num_steps": MAX_NUM_STEPS}
        solver = CVODE(fill, method=method, eventsfn=kinks, num_events=2, **options)
        ahead = np.flatnonzero(np.asarray(t) > now)
        part = solver.solve(np.append(now, np.asarray(t)[ahead]), state)
        evaluations += int(part.nfev)
        if not part.success:
            raise RouteFailed(f"CVODE {method} did not finish '{problem.title}': {part.message}")
        stop = t[-1] if part.t_events is None else float(part.t_events[-1])
        reached = ahead[np.asarray(t)[ahead] <= stop]
        # of two times alone CVODE returns all its steps between them
        found[reached] = part.y[np.searchsorted(part.t, np.asarray(t)[reached])]
        if stop <= now:
            raise RouteFailed(f"CVODE {method} does not leave the event of '{problem.title}' at t = {now:g}.")
        now, state = stop, part.y[-1] if part.t_events is None else part.y_events[-1]
    return Solution(found[:, 0], found[:, 1], evaluations, time.perf_counter() - begin)
