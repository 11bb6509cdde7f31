"""The largest step that keeps an error, and the finer steps that confirm it.

The searches for the steps of problems and for the steps of programs share this module.
"""

import numpy as np
from jaxtyping import Float

#: Smallest ratio of an allowed error to the uncertainty of the reference at which steps are recommended.
CERTAIN = 10.0

#: Smallest step that counts as confirming a recommended step, as a fraction of the recommended step.
TWENTIETH = 1 / 20

#: Quantile of the errors at the steps up to an octave below a step. The margin for untried steps is the largest of
#: these errors minus the quantile.
USUAL = 0.9

#: Name of a quantity, and its allowed error.
Limit = tuple[str, float]

#: Steps, or the errors of these steps.
Steps = Float[np.ndarray, "step"]


def largest_with_margin(dt: Steps, error: Steps, allowed: float) -> float:
    r"""Largest step that keeps an error with a margin for scatter; zero if there is none.

    All given steps must keep the error without this margin. The result is the largest step Δt that meets the condition

    .. math::

        2 \max_{\Delta t/2 < h \le \Delta t} e(h) - Q_{0.9}\,e(h) \le e_\text{allowed}

    with the errors e(h) of the steps h, and their quantile :math:`Q_{0.9}` over the same octave. If a step does not
    meet it, the steps up to one percent smaller are skipped.
    """
    while dt.size:
        step = dt.max()
        octave = error[dt > step / 2]
        if 2 * octave.max() - np.quantile(octave, USUAL) <= allowed:
            return step
        dt, error = dt[dt < 0.99 * step], error[dt < 0.99 * step]
    return 0.0
