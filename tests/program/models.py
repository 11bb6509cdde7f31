"""Programs that users might write without this package: oscillators, and programs whose runs fail or are wrong."""

import os
import signal
import sys
from functools import partial
from pathlib import Path

import numpy as np

DURATION = 20.0
SCHEMES = ["average_acceleration", "central_difference"]


def oscillator(hardening, scheme, dt):
    """A run of the oscillator ü + u + h u³ = 0 from u = 1 at rest."""
    u, v, a = 1.0, 0.0, -1.0 - hardening
    steps = int(np.ceil(DURATION / dt * (1 - 1e-9)))
    path = np.empty((steps + 1, 2))
    path[0] = u, v
    for i in range(steps):
        before = a
        if scheme == "central_difference":
            u += dt * v + dt**2 / 2 * a
            a = -u - hardening * u**3
        else:
            predicted, weight = u + dt * v + dt**2 / 4 * a, dt**2 / 4
            for _ in range(20):
                u = predicted + weight * a
                a -= (a + u + hardening * u**3) / (1 + weight * (1 + 3 * hardening * u**2))
            u = predicted + weight * a
        v += dt / 2 * (before + a)
        path[i + 1] = u, v
    return {"t": dt * np.arange(steps + 1), "displacement": path[:, 0], "velocity": path[:, 1]}


linear, hardening = partial(oscillator, 0.0), partial(oscillator, 0.5)


def fails(mistake, scheme, dt):
    """The linear oscillator with a scheme ``wrong``, whose runs fail by the ``mistake``, by a signal only if dt > 1."""
    if scheme != "wrong":
        return linear(scheme, dt)
    right = linear("central_difference", dt)
    right["displacement"] *= 1 + 1e-9  # otherwise both schemes would be one
    if mistake == "raised":
        raise ValueError("no convergence")
    if mistake == "exit_code":
        sys.exit(3)
    if mistake == "signal":
        if dt > 1:
            os.kill(os.getpid(), signal.SIGSEGV)
        return right
    t = right["t"]
    return {
        "nothing": None,
        "unusable": right | {"velocity": [1.0, 2.0]},
        "not_finite": right | {"velocity": np.where(t > 10, np.nan, t)},
        "unequal_times": right | {"t": t**1.01},
        "too_short": {name: values[: len(t) // 2] for name, values in right.items()},
    }[mistake]


def ignores_the_step(scheme, dt):
    """The linear oscillator, with a scheme ``wrong`` that always takes the same step size."""
    if scheme != "wrong":
        return linear(scheme, dt)
    fixed_step = DURATION / 2048
    return {
        name: values[:: max(round(dt / fixed_step), 1)]
        for name, values in linear("central_difference", fixed_step).items()
    }


class Remembers:
    """A program whose displacements become larger with every run of the second scheme."""

    def __init__(self):
        self.runs = 0

    def __call__(self, scheme, dt):
        self.runs += scheme == "central_difference"
        right = linear(scheme, dt)
        return right | {"displacement": right["displacement"] * (1 + 1e-3 * self.runs)}


def two_motions(scheme, dt):
    """A program whose two schemes solve different problems."""
    return linear(scheme, dt) if scheme == "central_difference" else oscillator(0.02, scheme, dt)


def sampled(every, scheme, dt):
    """The linear oscillator with an output at every n-th step."""
    return {name: values[::every] for name, values in linear(scheme, dt).items()}


def recorded(interval, scheme, dt):
    """The linear oscillator with an output at the first step after every interval, as by a recorder of OpenSees."""
    right = linear(scheme, dt)
    kept = [0]
    for place, t in enumerate(right["t"]):
        if t - right["t"][kept[-1]] >= interval * (1 - 1e-9):
            kept.append(place)
    return {name: values[kept] for name, values in right.items()}


def shifted(factor, begin, scheme, dt):
    """The linear oscillator with times t · factor + begin."""
    right = linear(scheme, dt)
    return right | {"t": right["t"] * factor + begin}


#: Cubic stiffness of the spring ``from_module``; tests change it while this module is loaded.
HARDENING = 0.0


def from_module(scheme, dt):
    """The oscillator whose hardening is a variable of this module."""
    return oscillator(HARDENING, scheme, dt)


def from_file(file, scheme, dt):
    """The oscillator whose hardening stands in a file."""
    return oscillator(float(Path(file).read_text()), scheme, dt)


def from_environment(scheme, dt):
    """The oscillator whose hardening is a variable of the environment."""
    return oscillator(float(os.environ["HARDENING"]), scheme, dt)
