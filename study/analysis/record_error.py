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
        Error by the error of the period.
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

        \varepsilon^2 = \Big(\frac{\delta}{\sqrt 2\,\zeta}\Big)^2
        + \frac{\int |H|^2\,|A - A_{\Delta t}|^2\,df}{\int |H|^2\,|A|^2\,df}, \quad
        H = \frac{1}{\omega^2 - (2\pi f)^2 + 4\pi i\,\zeta\omega f}

    The first term is the error by the relative error δ of the period, in a band of white noise:
    :math:`(\omega\Delta t)^2/12` with average acceleration, and half of it with central difference. In the second, A is
    the Fourier transform of the record, linear between its samples, and :math:`A_{\Delta t}` that of straight lines
    between its values at the steps. At steps that divide the spacing of the record, both are equal. At other steps,
    their difference at the frequency f of the oscillator is the power of the record near :math:`1/\Delta t \pm f`,
    which the steps cannot distinguish from f. Both terms are those of a long motion. The dataset ``record_error``
    compares them with runs of oscillators with 5 % of critical damping.

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
    response = 1 / np.abs(omega[..., None] ** 2 - frequency**2 + 2j * damping * omega[..., None] * frequency)
    missed_part, whole = (np.linalg.norm(response * np.fft.rfft(signal, count), axis=-1) for signal in (missed, record))
    delta = abs(modified.period_coefficient) * (omega * dt) ** 2
    return RecordError(delta / (math.sqrt(2) * damping), missed_part / whole)
