r"""The step that keeps an error of free vibration over another duration.

A scheme of order p delays the motion by the same time in each period, so the phase error grows with the number n of
periods, as :math:`n\,\Delta t^p`. A scheme that dissipates also loses energy, as :math:`n\,\Delta t^q` with its order q
of loss, infinite if it keeps the energy. The loss changes the period, so that the phase error has a second part,
:math:`n^2 \Delta t^q`. The step that keeps an error is

.. math::

    \Delta t(n) = \Delta t(n_0)\,(n_0/n)^a, \quad a = \max(1/p,\ 2/q)

for the motion, and a = 1/q for the energy.

References
----------
E. Hairer, C. Lubich, G. Wanner, Geometric numerical integration, 2nd ed., Springer, 2006, chapters IX and XI.
"""

import math

#: Quantity whose step follows the law of the energy.
ENERGY = "energy"
#: Motions to which the law applies, in words.
FREE = "free vibration without damping, load, memory and kinks"


def step_exponent(order: int, order_of_loss: float, quantity: str = "displacement") -> float:
    """The exponent a in Δt ∝ n^(−a), with which the step that keeps an error of a quantity falls over n periods."""
    return 1 / order_of_loss if quantity == ENERGY else max(1 / order, 2 / order_of_loss)


def step_over(step: float, exponent: float, known: float, duration: float) -> float:
    """The step that keeps an error over ``duration``, from the step that keeps it over ``known``, both in s.

    A shorter duration keeps the step.
    """
    return step * min(known / duration, 1.0) ** exponent


def round_up(number: float) -> float:
    """The smallest whole number with three digits that is not smaller."""
    unit = max(10.0 ** (math.floor(math.log10(number)) - 2), 1.0)
    return float(math.ceil(number / unit * (1 - 1e-9)) * unit)


def round_down(step: float) -> float:
    """The largest step with two digits that is not larger."""
    unit = 10.0 ** (math.floor(math.log10(step)) - 1)
    return float(f"{math.floor(step / unit * (1 + 1e-9)) * unit:.1e}")
