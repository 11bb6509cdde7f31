"""Motion of the ground, and its load on a structure."""

import reprlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jaxtyping import Float

from study.algebra.arrays import Scalar, Vector, VectorLike, as_float64
from study.algebra.reads import Reads, reads_of
from study.algebra.scalars import check_unmasked, is_number, is_whole
from study.mechanics.record_files import UNITS, Samples, read_record

#: Smallest and largest plausible peak of a record in g; beyond them the unit is wrong. The largest known is near 4 g.
PEAKS = (1e-6, 20.0)

#: Coefficients of the straight lines between neighbouring samples, shape (samples - 1, 2).
Lines = Float[np.ndarray, "lines two"]

_RECORDS = Path(__file__).parent / "records"


class GroundMotion(eqx.Module):
    """Acceleration of the ground along time: linear between samples a constant time apart.

    This is the convention of the field. From the time of the last sample on, the acceleration is zero. The kinks at the
    samples limit the order of every scheme whose steps do not end there. The samples around a time t follow from t/Δt,
    without a search.

    Parameters
    ----------
    acceleration
        Samples of shape (samples,), the first at t = 0.
    dt
        Time between two samples.
    title, source
        Name of the record, and its origin, such as the header of its file; ``source`` is empty if it is unknown.

    Raises
    ------
    ValueError
        If there are fewer than two samples, one is not a finite real number, or ``dt`` is not greater than zero.
    """

    acceleration: Samples
    dt: float
    title: str = eqx.field(static=True)
    source: str = eqx.field(static=True)
    #: Coefficients of the straight lines c + s (t/Δt) between neighbouring samples, as rows (c, s).
    _lines: Lines

    def __init__(self, acceleration: Samples, dt: float, *, title: str = "ground motion", source: str = ""):
        _check_numbers(acceleration, dt, title)
        self.acceleration, self.dt, self.title, self.source = as_float64(acceleration), as_float64(dt), title, source
        self._check()
        slope = self.acceleration[1:] - self.acceleration[:-1]
        numbers = jnp if isinstance(slope, jax.Array) else np
        self._lines = numbers.stack(
            [self.acceleration[:-1] - np.arange(len(slope), dtype=float) * slope, slope], axis=1
        )

    def _check(self) -> None:
        if isinstance(self.acceleration, jax.core.Tracer) or isinstance(self.dt, jax.core.Tracer):
            return
        if self.acceleration.ndim != 1 or len(self.acceleration) < 2 or not np.isfinite(self.acceleration).all():
            raise ValueError(f"'{self.title}' needs at least two samples of acceleration, all of them finite.")
        if not (np.isfinite(self.dt) and self.dt > 0):
            raise ValueError(f"the time between samples of '{self.title}' must be greater than zero, not {self.dt}.")

    def __call__(self, t: Scalar) -> Scalar:
        """Acceleration at the time t."""
        last = len(self.acceleration) - 1
        place = jnp.asarray(t) / self.dt
        # One index selects a whole line. XLA may compute the index twice, and next to a sample the results may be those
        # of two neighbouring intervals. Their lines meet there; an interpolation would mix samples of both intervals.
        intercept, slope = jnp.asarray(self._lines)[jnp.clip(place, 0, last - 1).astype(jnp.int32)]
        return jnp.where(place < last, intercept + slope * place, 0.0)

    def velocity(self, t: Scalar) -> Scalar:
        """Velocity at the time t of ground that starts at rest: the exact integral of the acceleration."""
        return self._motion(t)[0]

    def displacement(self, t: Scalar) -> Scalar:
        """Displacement at the time t of ground that starts at rest: the exact integral of the velocity."""
        return self._motion(t)[1]

    def _motion(self, t: Scalar) -> tuple[Scalar, Scalar]:
        a, dt = jnp.asarray(self.acceleration), self.dt
        v = jnp.cumsum(jnp.append(jnp.zeros(1), dt * (a[:-1] + a[1:]) / 2))
        u = jnp.cumsum(jnp.append(jnp.zeros(1), dt * v[:-1] + dt**2 * (2 * a[:-1] + a[1:]) / 6))
        last = len(a) - 1
        i = jnp.clip(jnp.asarray(t) / dt, 0, last - 1).astype(jnp.int32)
        elapsed = jnp.minimum(t, last * dt) - i.astype(float) * dt
        slope, time_after = (a[i + 1] - a[i]) / dt, jnp.maximum(t - last * dt, 0.0)
        v_t = v[i] + a[i] * elapsed + slope * elapsed**2 / 2
        return v_t, u[i] + v[i] * elapsed + a[i] * elapsed**2 / 2 + slope * elapsed**3 / 6 + v_t * time_after

    @property
    def reads(self) -> Reads:
        """What the record reads apart from its numbers: not its labels, so that records share a compiled program."""
        return reads_of(type(self).__call__)

    @property
    def kinks(self) -> np.ndarray:
        """Times at which the slope of the acceleration jumps, (samples,)."""
        return np.arange(len(self.acceleration)) * float(self.dt)

    @property
    def duration(self) -> float:
        """Time of the last sample."""
        return float(self.dt) * (len(self.acceleration) - 1)

    def scaled(self, factor: float) -> "GroundMotion":
        """The motion multiplied by a factor. Motions that differ in the factor share one compiled program."""
        if not (is_number(factor) or isinstance(factor, np.ndarray | jax.Array)):
            raise TypeError(f"the factor of '{self.title}' must be a number, not {factor!r}.")
        return GroundMotion(factor * self.acceleration, self.dt, title=self.title, source=self.source)

    @staticmethod
    def padded(motions: Sequence["GroundMotion"]) -> tuple[np.ndarray, np.ndarray]:
        """The accelerations of motions of unequal length, for an ensemble over records.

        A problem of the ensemble selects its record by number, so that all lanes share one table of the records::

            accelerations, dt = study.GroundMotion.padded(motions)

            def shaken(record):
                record = record.astype(int)
                ground = study.GroundMotion(jnp.asarray(accelerations)[record], jnp.asarray(dt)[record])
                return study.Problem(jnp.sin, u0=0.0, ground=ground)

            study.run(shaken, "rk4", dt=0.01, steps=3000, over={"record": np.arange(len(motions))})

        Returns
        -------
        tuple
            Accelerations of shape (motions, samples), with zeros after the last sample of a shorter motion, and times
            between samples (motions,). If the last sample of a shorter motion is not zero, its acceleration falls to
            zero within Δt; that of the motion itself jumps there.
        """
        if isinstance(motions, GroundMotion) or not len(motions):
            raise ValueError("padded takes a list of at least one GroundMotion.")
        samples = max(len(motion.acceleration) for motion in motions)
        rows = [np.pad(motion.acceleration, (0, samples - len(motion.acceleration))) for motion in motions]
        return np.stack(rows), np.array([motion.dt for motion in motions])

    @classmethod
    def read(cls, path: str | Path, unit: str | None = None, *, dt: float | None = None) -> "GroundMotion":
        """Read a record of acceleration and convert it to metres per second squared.

        The formats are AT2 files of the PEER ground motion database, ASCII files of the Engineering Strong Motion
        database (ESM), files of K-NET and KiK-net, and files of one or two columns. The first sample of an AT2 file
        belongs to t = DT, and the motion starts from zero at t = 0. The first sample of ESM, K-NET and of one column
        belongs to t = 0. The mean of a K-NET file is the offset of the instrument, and is subtracted. Two columns are
        times and accelerations, separated by blanks, tabs, commas or semicolons. A heading may precede columns; it may
        name them in the other order, and state their units, of times s or ms. The rest of a line after ``#`` or ``%``
        is skipped. Rows of more than three numbers without a heading are samples one after the other.

        Parameters
        ----------
        unit
            Unit of the file: ``g``, ``m/s2``, ``cm/s2``, ``mm/s2``, ``in/s2`` or ``ft/s2``. It may be omitted if the
            header states it.
        dt
            Time between two samples in s, for a file that does not state it.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ValueError
            If the unit is unknown, missing or wrong, if header, samples and ``dt`` disagree, or if samples are missing,
            not finite or not evenly spaced.
        """
        path = Path(path)
        if unit is not None and (not isinstance(unit, str) or unit not in UNITS):
            raise ValueError(f"unit must be one of {', '.join(UNITS)}, not {unit!r}.")
        if dt is not None and not (is_number(dt) and 0 < dt < np.inf):
            raise ValueError(f"dt must be a time in s greater than zero, not {dt!r}.")
        if not path.is_file():
            raise FileNotFoundError(f"there is no record '{path}'.")
        record = read_record(path, dt)
        if unit is None and record.unit is None:
            raise ValueError(f"'{path}' does not state its unit: give unit= as one of {', '.join(UNITS)}.")
        if None not in (unit, record.unit) and unit != record.unit:
            raise ValueError(f"the header of '{path}' states the unit {record.unit}, not {unit!r}.")
        file_unit = unit or str(record.unit)
        samples = UNITS[file_unit] * record.samples
        peak = np.abs(samples).max() / UNITS["g"]
        if not PEAKS[0] <= peak <= PEAKS[1]:
            raise ValueError(
                f"the peak of '{path}' would be {peak:.3g} g in the unit {file_unit!r}; give the file's unit."
            )
        return cls(samples, record.dt, title=path.stem, source=record.source)

    @classmethod
    def el_centro(cls) -> "GroundMotion":
        """The north-south ground acceleration at El Centro, 18 May 1940, of 31.18 s and a peak of 0.32 g.

        Peknold's correction, from the PEER ground motion database, with samples 0.02 s apart.
        """
        return cls.read(_RECORDS / "el_centro_1940_ns.at2", unit="g")

    @classmethod
    def measured(cls) -> list["GroundMotion"]:
        """21 horizontal components of measured ground motion: El Centro, 1940, and stretches of 30 s of others.

        Five further earthquakes of 1989 to 2019 with magnitudes of 4.1 to 7.8 gave 20 components at eight stations in
        California and New Zealand. Samples are 0.005 or 0.02 s apart, and peaks are 0.001 to 1.1 g. A stretch is that
        with the largest integral of the squared acceleration, so that it can begin within the shaking. The file
        ``records/README.md`` of this package states origins and terms.
        """
        with xr.open_dataset(_RECORDS / "measured.nc") as ds:
            rows = zip(ds.ground.values, ds.spacing.values, ds.record.values, ds.origin.values, strict=True)
            others = [cls(a[np.isfinite(a)], dt, title=str(title), source=str(origin)) for a, dt, title, origin in rows]
        return [cls.el_centro(), *others]

    @classmethod
    def kanai_tajimi(
        cls,
        seed: int,
        *,
        duration: float = 30.0,
        dt: float = 0.02,
        frequency: float = 5 * np.pi,
        damping: float = 0.6,
        density: float = 0.01,
        rise: float = 2.0,
        fall: float = 10.0,
        decay: float = 0.4,
    ) -> "GroundMotion":
        r"""A stochastic motion: white noise of the rock, filtered by the soil and shaped by an envelope.

        The soil is an oscillator, whose absolute acceleration has the spectral density

        .. math::

            S(\omega) = S_0\,\frac{\omega_g^4 + (2 \zeta_g \omega_g \omega)^2}
            {(\omega_g^2 - \omega^2)^2 + (2 \zeta_g \omega_g \omega)^2}

        for :math:`-\infty < \omega < \infty`. The envelope is :math:`(t/t_1)^2` up to t₁, one up to t₂ and
        :math:`e^{-c (t - t_2)}` from there on. The defaults describe firm soil and give a peak near 0.3 g.

        Parameters
        ----------
        seed
            Seed of the noise, a whole number; each seed gives its own motion. An ensemble cannot run over seeds, but
            over the accelerations of such motions.
        duration, dt
            Length of the record and time between two samples, in s.
        frequency, damping
            ω_g in rad/s and ζ_g of the soil.
        density
            S₀ in m² s⁻³.
        rise, fall, decay
            t₁ and t₂ in s, and c in 1/s.

        Raises
        ------
        ValueError
            If the seed is not a whole number, or another argument is no such number as it stands for.

        References
        ----------
        H. Tajimi, A statistical method of determining the maximum response of a building structure during an
        earthquake, Proc. 2nd World Conf. Earthq. Eng., 1960, 781-797.
        P. C. Jennings, G. W. Housner, N. C. Tsai, Simulated earthquake motions for design purposes, Proc. 4th World
        Conf. Earthq. Eng., 1969, 145-160 (the envelope).
        """
        if not is_whole(seed, 0):
            raise ValueError(
                f"seed must be a whole number of at least zero, not {reprlib.repr(seed)}; for an ensemble over seeds, "
                "make the records first and run over them, over={'record': [study.GroundMotion.kanai_tajimi(seed)"
                ".acceleration for seed in range(10)]}."
            )
        positive = {"duration": duration, "dt": dt, "frequency": frequency, "damping": damping, "rise": rise}
        for name, value in (positive | {"density": density}).items():
            if not (is_number(value) and 0 < value < np.inf):
                raise ValueError(f"{name} must be a number greater than zero, not {value!r}.")
        for name, value in {"fall": fall, "decay": decay}.items():
            if not (is_number(value) and 0 <= value < np.inf):
                raise ValueError(f"{name} must be a number of at least zero, not {value!r}.")
        t = dt * np.arange(round(duration / dt) + 1)
        noise = np.sqrt(2 * np.pi * density / dt) * np.random.default_rng(seed).standard_normal(len(t))
        s = 2j * np.pi * np.fft.rfftfreq(len(t), dt) / frequency
        filtered = np.fft.irfft(np.fft.rfft(noise) * (1 + 2 * damping * s) / (1 + 2 * damping * s + s**2), len(t))
        envelope = np.minimum(t / rise, 1) ** 2 * np.exp(-decay * np.maximum(t - fall, 0))
        source = "Tajimi (1960) and Jennings et al. (1969)"
        return cls(envelope * filtered, dt, title=f"stochastic record {seed}", source=source)


def _check_numbers(acceleration: Any, dt: Any, title: str) -> None:
    for value, ndim, meaning in ((acceleration, 1, "samples of acceleration"), (dt, 0, "a time between samples")):
        check_unmasked(f"'{title}'", value)
        try:
            numbers = value if isinstance(value, jax.core.Tracer) else np.asarray(value)
        except ValueError:  # rows of different lengths
            numbers = np.asarray(None)
        if numbers.ndim != ndim or np.dtype(numbers.dtype).kind not in "fiu":
            shape = "real numbers of shape (samples,)" if ndim else "a real number"
            raise ValueError(f"'{title}' needs {meaning} as {shape}, not {reprlib.repr(value)}.")


class GroundLoad(eqx.Module):
    """f(t) − M ι a(t): the load on a structure whose displacement is relative to the ground.

    Parameters
    ----------
    inertia
        M ι, with the displacement ι of the unknowns for a unit displacement of the ground.
    ground
        a(t).
    load
        f(t), or None.
    """

    inertia: VectorLike
    ground: GroundMotion
    load: Callable | None

    def __call__(self, t: Scalar) -> Vector:
        """The load at the time t."""
        ground_load = -jnp.asarray(self.inertia) * self.ground(t)
        return ground_load if self.load is None else self.load(t) + ground_load

    @property
    def kinks(self) -> np.ndarray:
        """Times at which the slope of the load jumps."""
        load_kinks = getattr(self.load, "kinks", [])
        return np.unique(np.concatenate([self.ground.kinks, load_kinks]))
