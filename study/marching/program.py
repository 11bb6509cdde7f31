"""The compiled functions of a march, and the calls that a run makes to them."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.algebra.deadline import check_time
from study.algebra.jit import jit
from study.algebra.reads import Reads, reading, reads_of
from study.marching import kernel
from study.marching.march import March
from study.marching.result import COMPLETED, NO_SOLUTION, Result
from study.marching.shapes import CountPerRun, Displacements, PerRun
from study.mechanics.definition import Problem
from study.mechanics.ground import GroundLoad, GroundMotion
from study.scheme.base import Scheme

#: Maximum numbers of samples for which a program has room, in a run of one call and in a run of several calls. Few
#: different numbers keep the number of compiled programs small. The overhead of a call is a tenth of a millisecond.
AT_ONCE, IN_STRETCHES = 2**13, 2**17

#: Largest number of values of one variable for which a program has room.
ROOM = 2**19

#: Number of steps between two pauses of a run with one unknown; these steps take about a second. A run can be
#: interrupted only at a pause.
PAUSE = 2**24

#: As ``PAUSE``, for lanes side by side. A step of a lane takes a quarter of the time of a step of a single run.
PAUSE_OF_LANES = 2**26

#: As ``PAUSE``, for lanes in kernels on a GPU. A step of a lane takes some hundredths of a nanosecond there, and a
#: hundred times as long if a kernel is refused.
PAUSE_OF_KERNELS = 2**34

#: Largest number of steps between two pauses of lanes in kernels: a step takes a microsecond, however few the lanes.
STEPS_OF_KERNELS = 2**17

#: Least number of steps between two pauses for which short runs have a program of their own, which saves the time to
#: pass their progress between calls. Longer steps take so long that this time does not count.
SHORT_STEPS = 2**13

#: Names of fields that are labels and change nothing in a march.
LABELS = ("title", "source", "doi")


def unlabelled(part: Any) -> Any:
    """A copy of a march, problem, record or scheme without its labels and those of its parts; other objects unchanged.

    With the labels, a program would be compiled again if only a label changes.
    """
    if not isinstance(part, March | Problem | Scheme | GroundMotion | GroundLoad):
        return part
    copy = object.__new__(type(part))
    for name, value in vars(part).items():
        is_label = name in LABELS and isinstance(value, str)
        object.__setattr__(copy, name, "" if is_label else unlabelled(value))
    return copy


class _Form:
    """All of a march except its arrays of numbers; the compiled program depends on it."""

    def __init__(self, structure, constants: tuple, reads: Reads):
        self.structure, self.constants, self.reads = structure, constants, reads
        self._hash = hash((structure, constants, reads))

    def __hash__(self):
        return self._hash

    def __eq__(self, other):
        return self is other or (
            isinstance(other, _Form)
            and self.structure == other.structure
            and self.constants == other.constants
            and self.reads == other.reads
        )

    def march(self, numbers: list) -> March:
        """The march with these numbers."""
        rest = iter(numbers)
        return jax.tree.unflatten(self.structure, [next(rest) if c is None else c for c in self.constants])


#: Forms with a kernel that XLA could not compile.
_without_kernels: set[_Form] = set()

#: All forms so far. Equal forms are represented by one object, which JAX compares by identity.
_forms: dict[_Form, _Form] = {}


def _each_tile(march: March, function: Callable, lanes: tuple) -> Any:
    """Result of ``function(*lanes)``; for an ensemble, its results for each tile along the first axis of ``lanes``."""
    return lax.map(lambda tile: function(*tile), lanes) if march.lanes else function(*lanes)


def _proceed(march: March, counts, each_step: bool, stored, progress, initial, dt, lane_steps):
    until, every, first = counts
    end = until if lane_steps is None else jnp.minimum(until, lane_steps.max())
    progress, stored = march.proceed(progress, stored, initial, dt, end, every, first, each_step, lane_steps)
    return progress, stored, march.result(progress)


@partial(jit, static_argnums=(0, 4, 5))
def _whole(form: _Form, numbers: list, counts, begin: tuple, room: int, each_step: bool, lane_steps):
    """Samples and result of a run in one call, which saves the time to pass its progress between calls."""
    march = form.march(numbers)

    def run(u0, v0, dt, arguments, lane_steps):
        tile_march = march.with_arguments(arguments)
        progress, initial, stored = tile_march.start(u0, v0, dt, room)
        return _proceed(tile_march, counts, each_step, stored, progress, initial, dt, lane_steps)[1:]

    return _each_tile(march, run, (*begin, lane_steps))


@partial(jit, static_argnums=(0, 3))
def _start(form: _Form, numbers: list, begin: tuple, room: int):
    march = form.march(numbers)

    def start(u0, v0, dt, arguments):
        return march.with_arguments(arguments).start(u0, v0, dt, room)

    return _each_tile(march, start, begin)


@partial(jit, static_argnums=(0, 3), donate_argnums=4)
def _stretch(form: _Form, numbers: list, counts, each_step: bool, stored, lanes: tuple):
    """Progress, samples and result of a run after one more stretch, and whether every run has failed."""
    march = form.march(numbers)

    def stretch(stored, progress, initial, dt, arguments, lane_steps):
        return _proceed(march.with_arguments(arguments), counts, each_step, stored, progress, initial, dt, lane_steps)

    progress, stored, result = _each_tile(march, stretch, (stored, *lanes))
    return progress, stored, result, jnp.all(result[0] != 0)


def _stretches(steps: int, every: int, samples: int, room: int, pause: int) -> Iterator[tuple[int, int]]:
    """Stretches of a run, each marched by one call: number of the first sample in the room, and step at the end.

    A stretch ends where the room for samples is full, where a pause is due, or at the end of the run.
    """
    begin = 0
    for first in range(0, samples + 1, room):
        is_last = first + room > samples
        end = steps if is_last else min(steps, (first + room - 1) * every)
        while begin < end:
            begin = min(begin + pause, end)
            yield first, begin


def as_result(result: tuple, samples: dict[str, np.ndarray]) -> Result:
    """Result of a march, from ``Progress.failure``, the values of the reductions, and the samples."""
    failure, values = jax.tree.map(np.asarray, result)
    restarts = values.pop("newton_restarts", np.zeros(failure.shape, int))
    status = np.where(failure == 0, COMPLETED, NO_SOLUTION + failure % 3)
    return Result(status, failure // 3 - 1, restarts, values, samples)


def _canonical(tree: Any) -> Any:
    """The tree with arrays of NumPy in the precision of JAX, which may pass them on without converting them."""

    def canonical(leaf):
        return np.asarray(leaf, jax.dtypes.canonicalize_dtype(leaf.dtype)) if isinstance(leaf, np.ndarray) else leaf

    return jax.tree.map(canonical, tree)


class Program:
    """A march, split into its numbers and its compiled program.

    Marches that differ only in numbers or in labels share the compiled program.
    """

    def __init__(self, march: March):
        march = unlabelled(march)
        leaves, structure = jax.tree.flatten(march)
        self.numbers = _canonical([leaf for leaf in leaves if eqx.is_array(leaf)])
        form = _Form(structure, tuple(None if eqx.is_array(leaf) else leaf for leaf in leaves), reads_of(march))
        self.form = _forms.setdefault(form, form)
        self._march, self._has_records, self._lanes = march, bool(march.records), march.lanes
        self._is_scalar = np.ndim(march.problem.u0) == 0

    def run(
        self,
        u0: Displacements,
        v0: Displacements,
        dt: PerRun,
        steps: int,
        every: int,
        samples: int,
        lane_steps: CountPerRun | None = None,
        pause: int | None = None,
        on_pause: Callable[[int], bool] = lambda step: True,
        arguments: Any = None,
    ) -> Result:
        """March to the end, or until every run has failed.

        Parameters
        ----------
        u0, v0, dt
            Initial displacements and velocities and step sizes: of one run, or (tiles, lanes, ...) of an ensemble.
        steps
            Number of steps.
        every, samples
            Number of steps between two samples, and number of samples after the first one.
        lane_steps
            Number of steps of each lane, if they differ.
        pause
            Largest number of steps between two pauses, at which the run can be interrupted; by default the steps of
            about a second.
        on_pause
            Function called with the number of steps at each pause; the run ends there if the function returns False.
        arguments
            Arguments of the function that makes the problems of a family, each (tiles, lanes, ...).

        Returns
        -------
        Result
            NumPy arrays; samples after a failure or after the end of a lane are meaningless.
        """
        program = self._with_steps_alone() if self.form in _without_kernels else self
        begin = _canonical((u0, v0, dt, arguments))
        with reading(self.form.reads):
            try:
                return program._run(begin, steps, every, samples, lane_steps, pause, on_pause)
            except jax.errors.JaxRuntimeError as error:
                if not program._march.in_kernels:
                    raise
                kernel.report_refusal(error)
                _without_kernels.add(self.form)
            return self._with_steps_alone()._run(begin, steps, every, samples, lane_steps, pause, on_pause)

    def _with_steps_alone(self) -> "Program":
        """The program without kernels."""
        return Program(replace(self._march, in_kernels=False))

    def _run(self, begin, steps, every, samples, lane_steps, pause, on_pause) -> Result:
        u0 = begin[0]
        room = self._room(u0, AT_ONCE)
        # a march without an inner loop is faster if steps are short, as with one unknown
        each_step = every == 1 and self._is_scalar
        if pause is None:
            unknowns = math.prod(u0.shape[2:] if self._lanes else u0.shape)
            lanes = max(1, np.isfinite(u0).sum() / unknowns)  # without those that pad a tile
            in_kernels = self._march.in_kernels
            most = PAUSE_OF_KERNELS if in_kernels else PAUSE_OF_LANES if self._lanes else PAUSE
            pause = max(1, int(most / (lanes * unknowns**1.5)))
            pause = min(pause, STEPS_OF_KERNELS) if in_kernels else pause
        if samples < room and max(steps, SHORT_STEPS) <= pause:
            counts = np.array([steps, every, 0])
            stored, result = _whole(self.form, self.numbers, counts, begin, room, each_step, lane_steps)
            place = (slice(None),) * self._lanes + (slice(samples + 1),)
            return as_result(result, {name: np.array(np.asarray(values)[place]) for name, values in stored.items()})
        room = self._room(u0, IN_STRETCHES)
        return self._in_stretches(begin, steps, every, samples, lane_steps, room, each_step, pause, on_pause)

    def _room(self, u0: Displacements, most: int) -> int:
        """Number of samples for which a program has room: a power of two, which is one if the march has no records."""
        return min(most, 2 ** max(0, int(math.log2(ROOM / u0.size)))) if self._has_records else 1

    def _in_stretches(self, begin, steps, every, samples, lane_steps, room, each_step, pause, on_pause) -> Result:
        begin, lane_steps = jax.device_put((begin, lane_steps))
        progress, initial, stored = _start(self.form, self.numbers, begin, room)
        before = (slice(None),) * self._lanes
        shapes = {n: (*v.shape[: self._lanes], samples + 1, *v.shape[self._lanes + 1 :]) for n, v in stored.items()}
        whole = {name: np.empty(shape) for name, shape in shapes.items()}
        for first, until in _stretches(steps, every, samples, room, pause):
            counts = np.array([until, every, first])
            lanes = progress, initial, *begin[2:], lane_steps
            progress, stored, result, ended = _stretch(self.form, self.numbers, counts, each_step, stored, lanes)
            new = min(room, samples + 1 - first)
            for name, values in stored.items():
                whole[name][(*before, slice(first, first + new))] = np.asarray(values)[(*before, slice(new))]
            # reading a value waits for the end of the stretch, so that Ctrl-C acts between two stretches
            if ended or not on_pause(until):
                break
            check_time()
        for values in whole.values():
            values[(*before, slice(first + new, None))] = np.nan
        return as_result(result, whole)
