"""One record at many intensities, and many structures under one record.

An incremental dynamic analysis follows the peak drift of a yielding oscillator while the record of El Centro grows. A
fragility sample draws a thousand oscillators, and counts the oscillators that exceed a drift. Both are ensembles over
arguments of the function that makes the problem.

    python examples/intensities.py
"""

import numpy as np

import study
from study import materials

RECORD = study.GroundMotion.el_centro()
DRIFT = study.Quantity(lambda u: u, name="drift", reduce="peak", long_name="peak drift", units="m")
#: Arguments of every run: twelve seconds, with four steps between two samples of the record.
RUN = {"dt": 0.005, "steps": 2400, "observe": [DRIFT]}


def oscillator(intensity=1.0, period=0.5, strength=0.15):
    """A unit mass under the scaled record; ``period`` is in s, and ``strength`` is yield force divided by weight."""
    stiffness = (2 * np.pi / period) ** 2
    spring = materials.elastoplastic(stiffness=stiffness, yield_force=strength * 9.81, hardening=0.02)
    damping = 2 * 0.05 * 2 * np.pi / period
    return study.Problem(spring, u0=0.0, damping=damping, ground=RECORD.scaled(intensity), title="yielding oscillator")


def analysis():
    """Peak drift at twenty intensities of the record."""
    return study.run(oscillator, "average_acceleration", over={"intensity": np.linspace(0.1, 2.0, 20)}, **RUN)


def fragility(count=1000, save=None):
    """Peak drift of oscillators whose period and strength scatter by twenty percent; ``save`` as in ``study.run``."""
    scatter = np.exp(0.2 * np.random.default_rng(1).normal(size=(2, count)))
    over = {"period": 0.5 * scatter[0], "strength": 0.15 * scatter[1]}
    return study.run(oscillator, "average_acceleration", over=over, save=save, **RUN)


if __name__ == "__main__":
    print((1e3 * analysis().drift).round(1).to_series().to_string(header=False))
    drift = fragility().drift
    for limit in (0.02, 0.04, 0.08):
        print(f"{100 * float((drift > limit).mean()):.0f} % exceed {1e3 * limit:.0f} mm")
