"""``study.record_error``: the error of a step under a record of ground motion, without a run."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.signal import czt

from study.algebra.scalars import is_number
from study.marching.arguments import resolve
from study.mechanics.ground import GroundMotion
from study.scheme.base import Scheme
from study.scheme.named import schemes
from study.scheme.newmark import Newmark

#: Number of points in the spacing of a record at which motions are compared.
POINTS = 8
#: Number of points in time, zeros included, that resolve the frequencies of a record of a few samples.
FEWEST = 2**15
#: Factor by which signals are weakened until their periodic continuation, so that it does not disturb them.
DAMPED = 1e6

#: A number, or one for each period.
_Errors = Float[np.ndarray, "..."]


class RecordError(NamedTuple):
    """Largest errors of the displacement of linear oscillators along time, over the peak; each of shape (periods,).

    Attributes
    ----------
    period_error
        Error of the response of the scheme, if the record were linear between its values at the steps.
    load_error
        Error by the part of the record that the steps pass over.
    total
        Largest sum of both errors along time.
    """

    period_error: _Errors
    load_error: _Errors
    total: _Errors


def _pulses(samples, spacing, frequency):
    """Fourier transform of pulses of the size of samples times their spacing."""
    ratio = np.exp(-1j * spacing * (frequency[1] - frequency[0]))
    return spacing * czt(samples, len(frequency), ratio, np.exp(1j * spacing * frequency[0]))


def _lines(samples, spacing, frequency):
    """Fourier transform of the straight lines between samples."""
    z = 1j * frequency * spacing
    after, before = ((x + np.expm1(-x)) / x**2 for x in (z, -z))  # of the two halves of a triangle
    ends = samples[0] * before + samples[-1] * np.exp(-z * (len(samples) - 1)) * after
    return (after + before) * _pulses(samples, spacing, frequency) - spacing * ends


def record_error(
    ground: GroundMotion,
    dt: float,
    period: _Errors | float,
    damping: float = 0.05,
    scheme: str | Scheme = "average_acceleration",
) -> RecordError:
    r"""Error of the displacement of a linear oscillator under a record, without a run.

    .. math::

        \varepsilon = \frac{\max_t |e|}{\max_t |u|}, \quad
        \hat u = H A, \quad \hat e = (H_{\Delta t} P - H A_{\Delta t}) + H (A_{\Delta t} - A), \quad
        H = \frac{1}{\omega^2 - \Omega^2 + 2 i\,\zeta\omega\Omega}

    A is the Fourier transform of the record, linear between its samples, P that of pulses at the steps, each as large
    as the value of the record times Δt, and :math:`A_{\Delta t}` that of straight lines between these values.
    :math:`H_{\Delta t}` is the response of the scheme. The two parts of the error are those of the period and of the
    load. In long noise about the frequency of the oscillator the first is about
    :math:`\delta/(\sqrt 2\,\zeta)`, with the relative error δ of the period, if δ is well below ζ:
    :math:`(\omega\Delta t)^2/12` with average acceleration, and half of it with central difference. At steps that
    divide the spacing of the record the second is zero. At other steps it is the response to the power of the record
    near :math:`1/\Delta t \pm f`, which the steps cannot distinguish from the frequency f of the oscillator. The
    largest values are sought at eight points in a spacing; between the steps, the displacement of the scheme is the
    harmonic one through its values at the steps. An exponential window suppresses the periodic continuation. The
    dataset ``record_error`` compares the error with that of runs. Error and peak are those up to the end of the record,
    not of the free vibration that follows. Errors below 1e-6, and oscillators whose period is near the spacing, are not
    resolved.

    Parameters
    ----------
    ground
        The record.
    dt
        Step size in s.
    period
        Period of the oscillator in s, or an array of periods.
    damping
        Damping ratio ζ, below 1.
    scheme
        A Newmark method with γ = ½, or the name of one.

    Raises
    ------
    KeyError
        If there is no scheme of that name.
    TypeError
        If ``ground`` is not a record.
    ValueError
        If the scheme is another one, a number is not positive, ζ is not below 1, the step is not stable or as long as
        the record, or the record is zero at all times.
    """
    if not isinstance(ground, GroundMotion):
        raise TypeError(f"ground must be a record, such as study.GroundMotion.read(path), not {ground!r}.")
    if not np.any(ground.acceleration):
        raise ValueError(f"'{ground.title}' is zero at all times, so that a relative error has no meaning.")
    for name, value in (("dt", dt), ("damping", damping)):
        if not (is_number(value) and 0 < value < math.inf):
            raise ValueError(f"{name} must be a positive number, not {value!r}.")
    if damping >= 1:
        raise ValueError(f"damping must be a fraction of the critical damping below 1, such as 0.05, not {damping!r}.")
    if dt >= ground.duration:
        raise ValueError(f"dt must be less than the duration of '{ground.title}', {ground.duration:g} s, not {dt!r}.")
    if not np.size(period) or not all(is_number(value) and 0 < value < math.inf for value in np.ravel(period)):
        raise ValueError(f"period must be a positive number or an array of them, not {period!r}.")
    scheme = resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
    if not (isinstance(scheme, Newmark) and scheme.gamma == 0.5):
        raise ValueError(
            f"the error of '{scheme.title}' under a record is not known without a run: it is for Newmark's methods "
            "with gamma = 0.5, such as central_difference."
        )
    beta, limit = scheme.beta, scheme.stability_limit
    omega = 2 * np.pi / np.asarray(period, float)
    if limit is not None and np.max(omega) * dt >= limit:
        raise ValueError(f"dt must be below {limit / np.max(omega):.4g} s, the stability limit of '{scheme.title}'.")
    record, spacing = np.asarray(ground.acceleration), float(ground.dt)
    at_steps = np.interp(dt * np.arange(math.ceil(ground.duration / dt - 1e-9) + 1), ground.kinks, record)
    fine = spacing / POINTS
    t = fine * np.arange(POINTS * (len(record) - 1) + 1)
    count = max(2 ** math.ceil(math.log2(2 * len(t))), FEWEST)
    decay = math.log(DAMPED) / (count * fine)
    frequency = 2 * np.pi * np.fft.rfftfreq(count, fine) - 1j * decay
    omega, angle = omega[..., None], frequency * dt
    response = 1 / (omega**2 - frequency**2 + 2j * damping * omega * frequency)
    # the difference equation of Newmark's method for harmonics below half of the frequency of the steps
    second = 4 * np.sin(angle / 2) ** 2
    mean = 1 - beta * second
    # a run from rest sees half of the first pulse, but for the terms of its first two steps
    start = at_steps[0] * dt * ((1 - 4 * beta) * damping * omega * dt / 2 - 1j * beta * np.sin(angle) - mean / 2)
    # at the last step the record has ended
    of_scheme = (mean * _pulses(at_steps[:-1], dt, frequency) + start) / (
        mean * omega**2 - second / dt**2 + 2j * damping * omega * np.sin(angle) / dt
    )
    of_scheme = np.where(angle.real < np.pi, of_scheme, 0.0)
    whole, of_load = response * _lines(record, spacing, frequency), response * _lines(at_steps, dt, frequency)
    parts = (of_scheme - of_load, of_load - whole, of_scheme - whole, whole)
    motions = (np.exp(decay * t) * np.fft.irfft(part, count)[..., : len(t)] for part in parts)
    *errors, peak = (np.abs(motion).max(axis=-1) for motion in motions)
    return RecordError(*(error / peak for error in errors))
