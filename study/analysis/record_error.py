"""``study.record_error``: the error of a step under a record of ground motion, without a run."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from study.algebra.scalars import is_number
from study.analysis.step_bound import modified_energy
from study.marching.arguments import resolve
from study.mechanics.ground import GroundMotion
from study.scheme.base import Scheme
from study.scheme.named import schemes

#: Number of points in the spacing of a record at which the record is compared with the load that the steps see.
POINTS = 8

#: A number, or one for each period.
_Errors = Float[np.ndarray, "..."]


class RecordError(NamedTuple):
    """Largest errors of the displacement of linear oscillators along time, over the peak; each of shape (periods,).

    Attributes
    ----------
    period_error
        Error by the response of the scheme, in a band of white noise by the error of its period.
    load_error
        Error by the part of the record that the steps pass over.
    """

    period_error: _Errors
    load_error: _Errors

    @property
    def total(self) -> _Errors:
        """Root of the sum of both squares."""
        return np.hypot(self.period_error, self.load_error)


def record_error(
    ground: GroundMotion,
    dt: float,
    period: _Errors | float,
    damping: float = 0.05,
    scheme: str | Scheme = "average_acceleration",
) -> RecordError:
    r"""Error of the displacement of a linear oscillator under a record, without a run.

    .. math::

        \varepsilon^2 = \frac{\int |H_{\Delta t} - H|^2\,|A|^2\,df + \int |H|^2\,|A - A_{\Delta t}|^2\,df}
        {\int |H|^2\,|A|^2\,df}, \quad H = \frac{1}{\omega^2 - \Omega^2 + 2 i\,\zeta\omega\Omega}, \quad
        \Omega = 2\pi f

    A is the Fourier transform of the record, linear between its samples, and H the response to a harmonic load. The
    first term is the error of the response :math:`H_{\Delta t}` of the scheme. With average acceleration it is H at the
    frequency :math:`(2/\Delta t)\tan(\Omega\Delta t/2)`. In a band of white noise the term is about
    :math:`\delta/(\sqrt 2\,\zeta)`, with the relative error δ of the period, if δ is well below ζ:
    :math:`(\omega\Delta t)^2/12` with average acceleration, and half of it with central difference. In the second term
    :math:`A_{\Delta t}` is the transform of straight lines between the values of the record at the steps. At steps that
    divide the spacing of the record, it is A. At other steps, their difference at the frequency f of the oscillator is
    the power of the record near :math:`1/\Delta t \pm f`, which the steps cannot distinguish from f. Both terms are
    those of a long motion. The dataset ``record_error`` compares them with runs of oscillators with 5 % of critical
    damping. In runs with 20 and 40 % under two records, errors of central difference were up to 2.5 times as large, and
    those of average acceleration up to 1.8 times.

    Parameters
    ----------
    ground
        The record.
    dt
        Step size in s.
    period
        Period of the oscillator in s, or an array of periods.
    damping
        Damping ratio ζ.
    scheme
        A Newmark method with γ = ½, the implicit midpoint rule, or the name of one.

    Raises
    ------
    KeyError
        If there is no scheme of that name.
    TypeError
        If ``ground`` is not a record.
    ValueError
        If the error of the period of the scheme is not known here, a number is not positive, the step is not stable, or
        the record is zero at all times.
    """
    if not isinstance(ground, GroundMotion):
        raise TypeError(f"ground must be a record, such as study.GroundMotion.read(path), not {ground!r}.")
    if not np.any(ground.acceleration):
        raise ValueError(f"'{ground.title}' is zero at all times, so that a relative error has no meaning.")
    for name, value in (("dt", dt), ("damping", damping)):
        if not (is_number(value) and 0 < value < math.inf):
            raise ValueError(f"{name} must be a positive number, not {value!r}.")
    if not all(is_number(value) and 0 < value < math.inf for value in np.ravel(period)):
        raise ValueError(f"period must be a positive number or an array of them, not {period!r}.")
    scheme = resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
    modified, limit = modified_energy(scheme), scheme.stability_limit
    omega = 2 * np.pi / np.asarray(period, float)
    if limit is not None and np.max(omega) * dt >= limit:
        raise ValueError(f"dt must be below {limit / np.max(omega):.4g} s, the stability limit of '{scheme.title}'.")
    spacing = float(ground.dt) / POINTS
    t = spacing * np.arange(POINTS * (len(ground.acceleration) - 1) + 1)
    steps = dt * np.arange(math.ceil(t[-1] / dt - 1e-9) + 1)
    record = np.interp(t, ground.kinks, ground.acceleration)
    missed = record - np.interp(t, steps, np.interp(steps, ground.kinks, ground.acceleration))
    count = 2 ** math.ceil(math.log2(2 * len(t)))  # zeros follow, in which the response decays
    frequency = 2 * np.pi * np.fft.rfftfreq(count, spacing)
    omega, angle = omega[..., None], frequency * dt
    response = 1 / (omega**2 - frequency**2 + 2j * damping * omega * frequency)
    # the difference equation of Newmark's method for harmonics below half of the frequency of the steps
    second = np.where(angle < np.pi, 4 * np.sin(angle / 2) ** 2, 0.0)
    mean = 1 - (1 / 12 - 2 * modified.period_coefficient) * second
    by_scheme = mean / (mean * omega**2 - second / dt**2 + 2j * damping * omega * np.sin(angle) / dt)
    off = np.where(angle < np.pi, by_scheme - response, 0.0)
    transformed = np.fft.rfft(record, count)
    parts = (off * transformed, response * np.fft.rfft(missed, count), response * transformed)
    period_part, missed_part, whole = (np.linalg.norm(part, axis=-1) for part in parts)
    return RecordError(period_part / whole, missed_part / whole)
