"""Measured and stochastic records of ground motion that differ in spacing and spectrum, for laws over many records."""

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from study.mechanics.ground import GroundMotion

#: Spacing in s of the samples from which every record is taken.
FINEST = 0.0025
#: Part of the duration in which the envelope rises, and at which it begins to fall to a tenth at the end.
RISE, FALL = 0.1, 0.4
#: Largest acceleration in m/s², about that of El Centro, 1940.
LARGEST = 3.0


def point_source(seed: int, spacing: float, corner: float, kappa: float, duration: float) -> GroundMotion:
    r"""A stochastic record with the spectrum of a point source.

    .. math::

        |A(f)| \propto \frac{f^2}{1 + (f/f_c)^2}\,e^{-\pi \kappa f}

    White noise is shaped by an envelope and then filtered. The record holds no frequency from half of its sampling rate
    on.

    Parameters
    ----------
    seed
        Seed of the noise.
    spacing, duration
        Time between two samples, a multiple of ``FINEST``, and length of the record, in s.
    corner
        Corner frequency f_c of the source in Hz, which is low for large events.
    kappa
        Decay κ in s of high frequencies, which is small on hard rock.

    References
    ----------
    D. M. Boore, Simulation of ground motion using the stochastic method, Pure Appl. Geophys. 160, 2003, 635-676.
    """
    t = FINEST * np.arange(round(duration / FINEST) + 1)
    part = t / duration
    envelope = np.minimum(part / RISE, 1) ** 2 * 0.1 ** (np.maximum(part - FALL, 0) / (1 - FALL))
    noise = np.random.default_rng(seed).standard_normal(len(t)) * envelope
    f = np.fft.rfftfreq(2 * len(t), FINEST)
    filtered = np.fft.rfft(noise, 2 * len(t)) * f**2 / (1 + (f / corner) ** 2) * np.exp(-np.pi * kappa * f)
    fine = np.fft.irfft(np.where(f < 0.5 / spacing, filtered, 0.0), 2 * len(t))[: len(t)]
    samples = fine[:: round(spacing / FINEST)]
    title = f"source {corner:g} Hz, κ {kappa:g} s, every {1e3 * spacing:g} ms, seed {seed}"
    return GroundMotion(LARGEST / np.abs(samples).max() * samples, spacing, title=title, source="Boore (2003)")


def _strongest(ground: GroundMotion, duration: float) -> GroundMotion:
    """The stretch of a record with the largest integral of the squared acceleration."""
    count = min(round(duration / float(ground.dt)) + 1, len(ground.acceleration))
    squares = np.lib.stride_tricks.sliding_window_view(np.square(ground.acceleration), count)
    first = int(squares.sum(axis=1).argmax())
    stretch = ground.acceleration[first : first + count]
    return GroundMotion(stretch, ground.dt, title=ground.title, source=ground.source)


def files_in(folder: str | Path) -> list[Path]:
    """Files of a folder with records in alphabetical order.

    Subfolders, hidden files and texts in Markdown, such as the terms of the records, are left out.

    Raises
    ------
    ValueError
        If the folder does not exist or holds no file.
    """
    if not Path(folder).is_dir():
        raise ValueError(f"there is no folder '{folder}'.")
    visible = [path for path in Path(folder).iterdir() if path.is_file() and not path.name.startswith(".")]
    files = sorted(path for path in visible if path.suffix != ".md")
    if not files:
        raise ValueError(f"the folder '{folder}' holds no file, and must hold records of acceleration.")
    return files


def family(
    spacings: Sequence[float],
    corners: Sequence[float],
    kappas: Sequence[float],
    seeds: int,
    duration: float,
    folder: str | None = None,
) -> list[GroundMotion]:
    """Measured records, and a stochastic record for every combination, each from its own noise.

    Of a measured record the stretch of the duration with the largest integral of the squared acceleration is taken. The
    whole records of a folder follow, whose files must state their units and spacings.

    Raises
    ------
    ValueError
        If the folder holds no file, or one that is not such a record.
    """
    combinations = itertools.product(spacings, corners, kappas, range(seeds))
    return [
        *(_strongest(record, duration) for record in GroundMotion.measured()),
        *(point_source(1 + n, *combination[:3], duration) for n, combination in enumerate(combinations)),
        *(GroundMotion.read(path) for path in (files_in(folder) if folder else ())),
    ]
