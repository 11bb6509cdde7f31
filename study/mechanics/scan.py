"""Times at which a function of time has kinks, jumps or short pulses, from samples that are refined where it bends."""

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import ClosedJaxpr, jaxpr_as_fun
from jaxtyping import Float

from study.algebra.reads import Reads, reading, reads_of, reads_of_program
from study.mechanics.internal_force import numbers, switches

#: Number of intervals between the first samples, and the least number of them if the function has many values. It is a
#: prime number: a train of pulses whose period divides the duration would otherwise fall between the samples.
INTERVALS, FEWEST = 8191, 251

#: Caps on samples × values: of those that are computed at once, which bounds the memory, and of the first samples.
AT_ONCE, IN_ALL = 2**22, 2**25

#: Largest number of values that are compared one by one; more are first combined to this number by random weights.
COLUMNS = 32

#: Largest and smallest number of parts into which the neighbourhood of a sample is divided, and largest number of
#: divisions. The more neighbourhoods there are, the fewer parts they have.
MOST_PARTS, FEWEST_PARTS, LEVELS = 2048, 32, 16

#: Least ratio of the bend at a sample to the median bend for a refinement, and least growth of the bend by a division
#: for another one. At a kink the bend grows with the number of parts; where the function is smooth it stays the same.
SALIENT, GROWING = 8.0, 4.0

#: Smallest deviation from a straight line that counts, as a fraction of the range of the function.
SMALLEST = 1e-9

#: Largest bend before a smooth pulse if the function counts as quiet there, as a fraction of the bend in the pulse.
QUIET = 1e-2

#: Largest number of neighbourhoods that are divided. Those with the largest deviations are divided.
MOST = 4096

#: Number of samples between two times found, and least deviation from a straight line between them that counts, as a
#: fraction of the range.
BETWEEN, BULGE = 17, 1e-5

#: Width of a neighbourhood at which its division ends, as a fraction of the duration.
NARROW = 1e-12

#: Number of random times at which the function is compared with its samples.
AT_RANDOM = 63

#: Distance of further samples from a number of the program, as a fraction of the duration.
NEXT_TO = 1e-9

#: Largest number of results that are kept.
KEPT = 128

#: Times in seconds.
Times = Float[np.ndarray, "times"]

#: Values of a function at samples, and their bends.
Values = Float[np.ndarray, "*samples columns"]


def events(function: Callable, duration: float, intervals: int = INTERVALS) -> Times:
    """Times within ``duration`` at which a function of time jumps or has a kink, or at which a short pulse lies.

    The function is sampled at equidistant times, and at every number of its program, such as 3.3 in ``t > 3.3`` or the
    times of a table. Samples with an exceptional deviation from the straight line through their neighbours are refined
    again and again. A time is found if the bend grows with each refinement. A change of a comparison in the program is
    a jump, so both ends of ``(t > 3.3) & (t < 3.30001)`` are found. A smooth pulse after a quiet stretch gives three
    times: its start, its largest value and its end. Other smooth functions give no times. Between two times found, the
    time of the largest deviation from a straight line is added.

    A pulse that lasts at least two intervals is certain to be found. A shorter pulse is found if one of its times is a
    number of the program. With more than ``IN_ALL`` samples × values, there are fewer intervals.

    Parameters
    ----------
    function
        Function of the time, whose values have one shape. It is scanned again if what it reads has changed, and no
        program is compiled for it.
    duration
        Duration in s.
    intervals
        Number of intervals between the first samples.
    """
    return _kept_for(function, (duration, intervals), lambda: _scanned(function, duration, intervals))


def beside_jumps(function: Callable, times: Times, duration: float) -> Times:
    """The times, with a time on either side in place of each time at which the function jumps.

    At a jump a step sees one side only: a load may be zero at both ends of its pulse. A step that ends after the jump
    sees the load of the pulse. If the function jumps just after t = 0, as that of ``t > 0``, there is a time after it.
    """

    def times_and_sides() -> Times:
        starts, tiny = np.append(0.0, times), NEXT_TO * duration
        with jax.enable_x64(True):
            around = np.maximum((starts[:, None] + tiny * np.array([-1.0, 0.0, 1.0])).ravel(), 0.0)
            values = _evaluated(_traced(function), around)
        before, middle, after = np.moveaxis(values.reshape(len(starts), 3, -1), 1, 0)
        jumps = np.maximum(abs(after - before), abs(middle - before)).max(axis=1) > BULGE * np.abs(values).max()
        beside = np.concatenate([starts[~jumps], starts[jumps] - tiny, starts[jumps] + tiny])
        return np.unique(beside[beside > 0])

    return _kept_for(function, (duration, times.tobytes()), times_and_sides)


def _kept_for(function: Callable, arguments: tuple, compute: Callable[[], Times]) -> Times:
    """What ``compute`` returned for the same arguments and what the function reads now, or returns now."""
    reads = reads_of(lambda: function)
    if not reads.certain:
        with jax.enable_x64(True):
            reads = reads_of_program(_traced(function))
    key = reads, arguments
    if key in _kept:
        return _kept[key]
    if len(_kept) >= KEPT:
        _kept.pop(next(iter(_kept)), None)
    return _kept.setdefault(key, compute())


_kept: dict[tuple[Reads, tuple], Times] = {}


def _scanned(function: Callable, duration: float, intervals: int) -> Times:
    """The times that :func:`events` returns."""
    with jax.enable_x64(True):
        scan = _Scan(function, duration)
        t, values = scan.first(intervals)
        h = t[1] - t[0]
        deviation = _deviation(values)
        known, beside, deviations, at_random = scan.between(t, values)
        # samples at about a whole period of a load hide its oscillation, which random times show
        typical = np.maximum(np.median(deviation, axis=0), np.median(at_random, axis=0))
        salient = np.any(deviation > np.maximum(SALIENT * typical, SMALLEST), axis=1)
        first, last = _pairs(salient)  # a deviation with the index i belongs to the sample i + 1
        regions, strengths = np.stack([t[first], t[last + 2]], axis=1), np.maximum(deviation[first], deviation[last])

        struck = np.any(deviations > np.maximum(SALIENT * typical, SMALLEST), axis=1)
        known, beside, deviations = known[struck], beside[struck], deviations[struck]
        around = np.stack([beside - h, beside + h], axis=1)
        located = scan.divided(np.concatenate([regions, around]), np.concatenate([strengths, deviations]))
        located = np.concatenate([located, _pulses(t, values, deviation, salient, located)])
        for number, size in zip(known, deviations, strict=True):
            place = int(number / h)
            quiet = np.any(deviation[max(place - 9, 0) : max(place - 1, 1)].max(axis=0) < QUIET * size)
            if quiet and not np.any(abs(located - number) < h):
                located = np.append(located, [t[place], number, t[place + 1]])
        located = np.unique(located[(located > NEXT_TO * duration) & (located < (1 - NEXT_TO) * duration)])
        located = located[np.diff(located, prepend=0.0) > NEXT_TO * duration]
        return np.union1d(located, scan.farthest(located))


def _traced(function: Callable) -> ClosedJaxpr:
    """The program of a function of time, whose values become one row, with what it reads now."""
    with reading(Reads.unique()):
        return jax.make_jaxpr(lambda t: jnp.ravel(jnp.asarray(function(t), float)))(0.0)


def _evaluated(program: ClosedJaxpr, t: Times) -> np.ndarray:
    """Values of a program at the times, operation by operation: JAX has compiled most operations for other programs."""
    evaluate = partial(jax.core.eval_jaxpr, program.jaxpr, program.consts)
    try:
        (values,) = jax.vmap(evaluate)(jnp.asarray(t))
    except NotImplementedError:  # a function that calls the host may take one time only
        (values,) = jax.lax.map(evaluate, jnp.asarray(t))
    return np.asarray(values)


class _Scan:
    """A function of time and the signs of its comparisons, as columns of numbers of about the range one."""

    def __init__(self, function: Callable, duration: float):
        value = jaxpr_as_fun(_traced(function))

        def values_of_time(t):
            signs = jnp.sign(switches(lambda t: value(t)[0], t))
            return jnp.append(value(t)[0], signs) if signs.size else value(t)[0]

        known = numbers(value, 0.0)
        self._duration, self._program = duration, jax.make_jaxpr(values_of_time)(0.0)
        self._numbers = known[(known > 0) & (known < duration)]
        self._size = max(self._program.out_avals[0].size, 1)
        self._weights: np.ndarray | None = None
        self._scale = np.ones(())

    def _raw(self, t: Times) -> Values:
        """Values at the times, zero where they are not finite.

        They are computed in parts of few lengths, for which JAX compiles each operation once.
        """
        once = int(np.clip(AT_ONCE // self._size, 1, INTERVALS + 1))
        parts = []
        for begin in range(0, len(t), once):
            chunk = t[begin : begin + once]
            part = _evaluated(self._program, np.pad(chunk, (0, once - len(chunk)), mode="edge"))[: len(chunk)]
            parts.append(part if self._weights is None else part @ self._weights)
        values = np.concatenate(parts)
        return np.where(np.isfinite(values), values, 0.0)

    def first(self, intervals: int) -> tuple[Times, Values]:
        """Equidistant times, and the columns of values at them."""
        count = int(np.clip(IN_ALL // self._size, FEWEST, intervals))
        t = np.linspace(0.0, self._duration, count + 1)
        if self._size > COLUMNS:
            sample_times = np.append(t[:: max(count // 64, 1)], self._numbers[:64])
            spread = np.ptp(self._raw(sample_times), axis=0)
            random = np.random.default_rng(0).uniform(-1.0, 1.0, (self._size, COLUMNS))
            self._weights = random / np.where(spread > 0, spread, spread.max() or 1.0)[:, None]
        values = self._raw(t)
        spread = np.ptp(values, axis=0)
        self._scale = np.where(spread > 0, spread, 1.0)
        return t, values / self._scale

    def values(self, t: Times) -> Values:
        """Columns of values at the times."""
        return self._raw(t) / self._scale

    def between(self, t: Times, values: Values) -> tuple[Times, Times, Values, Values]:
        """The numbers of the program, a time next to each, and the deviation there from the chord between samples.

        The last array has deviations at random times.
        """
        tiny = NEXT_TO * self._duration
        known = self._numbers[(self._numbers > tiny) & (self._numbers < self._duration - tiny)]
        near = (known[:, None] + tiny * np.array([-1, 0, 1])).ravel()
        times = np.append(near, np.random.default_rng(0).uniform(0.0, self._duration, AT_RANDOM))
        place = np.minimum((times / (t[1] - t[0])).astype(int), len(t) - 2)
        part = ((times - t[place]) / (t[1] - t[0]))[:, None]
        deviations = np.abs(self.values(times) - (1 - part) * values[place] - part * values[place + 1])
        three = deviations[: len(near)].reshape(len(known), 3, values.shape[1])
        most = three.max(axis=2).argmax(axis=1)
        return known, near.reshape(-1, 3)[np.arange(len(known)), most], three.max(axis=1), deviations[len(near) :]

    def divided(self, regions: np.ndarray, strengths: Values) -> Times:
        """Times in the regions (regions, 2) at which the function jumps or has a kink.

        A region is divided as long as its deviation from a straight line falls less than that of a smooth function.
        ``strengths`` are the deviations by which the regions were found.
        """
        located = [np.zeros(0)]
        for level in range(LEVELS):
            most = np.argsort(strengths.max(axis=1, initial=0.0))[::-1][:MOST]
            regions, strengths = regions[most], strengths[most]
            if not len(regions):
                break
            parts = int(np.clip(INTERVALS // len(regions), FEWEST_PARTS, MOST_PARTS))
            t = np.linspace(regions[:, 0], regions[:, 1], parts + 1, axis=1)
            deviation = _deviation(self.values(t.ravel()).reshape(*t.shape, -1))
            growing = np.any(
                (deviation > SMALLEST) & (deviation > strengths[:, None] * GROWING * (3 / parts) ** 2), axis=2
            )
            # a jump between neighbouring numbers, or a kink whose deviation has become too small
            narrow = regions[:, 1] - regions[:, 0] <= NARROW * self._duration
            small = ~np.any(deviation > SMALLEST, axis=(1, 2)) & (level > 1)
            located.append(self._number_in(regions[narrow | small]))
            growing[narrow] = False
            place, first, last = _pairs(growing)
            regions = np.stack([t[place, first], t[place, last + 2]], axis=1)
            strengths = np.maximum(deviation[place, first], deviation[place, last])
        return np.concatenate([*located, self._number_in(regions)])

    def farthest(self, located: Times) -> Times:
        """The time between each two neighbouring times at which the function is farthest from a straight line.

        Without it, a step could reach from the start of a half-sine to its end, where the load is zero.
        """
        if len(located) < 2:
            return np.zeros(0)
        tiny = NEXT_TO * self._duration / 2
        t = np.linspace(located[:-1] + tiny, located[1:] - tiny, BETWEEN, axis=1)
        values = self.values(t.ravel()).reshape(*t.shape, -1)
        part = np.linspace(0.0, 1.0, BETWEEN)[:, None]
        deviations = np.abs(values - (1 - part) * values[:, :1] - part * values[:, -1:]).max(axis=2)
        return t[np.arange(len(t)), deviations.argmax(axis=1)][deviations.max(axis=1) > BULGE]

    def _number_in(self, regions: np.ndarray) -> Times:
        """The number of the program in each region (regions, 2), or the end of the region if there is none."""
        if not len(self._numbers):
            return regions[:, 1]
        wide = regions[:, 1] + (regions[:, 1] - regions[:, 0])
        number = self._numbers[np.maximum(np.searchsorted(self._numbers, wide, side="right") - 1, 0)]
        inside = (number >= 2 * regions[:, 0] - regions[:, 1]) & (number <= wide)
        return np.where(inside, number, regions[:, 1])


def _deviation(values: Values) -> Values:
    """Deviation of each inner sample from the straight line through its neighbours, which are equally far away."""
    return np.abs(values[..., 2:, :] - 2 * values[..., 1:-1, :] + values[..., :-2, :]) / 2


def _pairs(marked: np.ndarray) -> tuple[np.ndarray, ...]:
    """Indices of the first and last of each marked element or pair of neighbours along the last axis.

    A kink between two samples marks both, so they are one pair. Of several marked neighbours the first two are a pair,
    the next two another one, and so on. For an array of two axes the index along the first axis comes first.
    """
    place = np.broadcast_to(np.arange(marked.shape[-1]), marked.shape)
    run = place - np.maximum.accumulate(np.where(marked, -1, place), axis=-1)
    *others, first = np.nonzero(run % 2 == 1)
    follows = np.pad(marked, [(0, 0)] * (marked.ndim - 1) + [(0, 1)])[(*others, first + 1)]
    return (*others, first, first + follows)


def _pulses(t: Times, values: Values, deviation: Values, salient: np.ndarray, located: Times) -> Times:
    """Start, largest value and end of each smooth pulse, which are salient samples after quiet without a time found."""
    times: list[float] = []
    places = np.flatnonzero(salient)
    for pulse in np.split(places, np.flatnonzero(np.diff(places) > 2) + 1) if len(places) else ():
        first, last = pulse[0], pulse[-1] + 2  # samples next to the pulse
        before = deviation[max(2 * first - last, 0) : first]
        quiet = len(before) and np.any(before.max(axis=0) < QUIET * deviation[first : last - 1].max(axis=0))
        if quiet and not np.any((located >= t[first]) & (located <= t[last])):
            size = np.abs(values[first : last + 1] - values[first]).max(axis=1)
            times += [t[first], t[first + size.argmax()], t[last]]
    return np.array(times)
