"""Many runs side by side: in tiles that fit the cache of a core, on all cores."""

import math
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from functools import partial
from typing import Any

import jax
import numpy as np
from tqdm import tqdm

from study.algebra.deadline import deadline, until
from study.marching.kernel import BLOCK
from study.marching.program import Program
from study.marching.result import Result
from study.marching.shapes import CountPerRun, DisplacementsOfLanes, PerRun
from study.settings import cores

#: Number of lanes of a tile. Their state stays in the cache of a core, whatever the size of the ensemble. Small
#: ensembles are padded to a tile; otherwise XLA compiles another loop and the last bits differ.
TILE = 64

#: Largest number of lanes that are marched one by one if the problem has several unknowns. The lanes then use the
#: compiled program of a single run. Tiles are faster only for more lanes.
FEW = 64

#: Initial displacements and velocities of all lanes, step size of all lanes or of each lane, and arguments of the
#: function that makes the problem of each lane, empty unless the ensemble is a family.
Begin = tuple[DisplacementsOfLanes, DisplacementsOfLanes, PerRun, dict[str, np.ndarray]]

#: Possible numbers of tiles in one call of the compiled program.
GROUPS = (1, 8, 64)

#: Largest number of bytes of a lane's state, samples and arguments up to which all groups have the largest size.
LIGHT = 1024


def _in_tiles(values: np.ndarray, shape: tuple[int, int, int], size: int, filler: Any) -> np.ndarray:
    """Values of the lanes, reshaped to (groups, ``size``, lanes of a tile, ...).

    ``shape`` is (groups, tiles of a group that hold lanes, lanes of a tile). Empty places hold ``filler``. They come
    first, so that the last lanes, the longest ones, fill their tiles. Successive tiles go to successive groups, so that
    all groups have long lanes.
    """
    groups, share, tile = shape
    room = np.full((math.prod(shape), *values.shape[1:]), filler, values.dtype)
    room[len(room) - len(values) :] = values
    room = room.reshape(share, groups, tile, *values.shape[1:]).swapaxes(0, 1)
    empty = np.full((groups, size - share, *room.shape[2:]), filler, values.dtype)
    return np.concatenate([room, empty], axis=1)


def _on_cores(run: Callable[..., Result], arguments: Sequence[tuple]) -> list[Result]:
    """Results of ``run`` for each tuple of arguments, on at most one thread per core. Ctrl-C ends all runs."""
    stopped = threading.Event()
    workers, end = cores() if jax.default_backend() == "cpu" else 1, deadline()

    # a new thread does not inherit the context, the precision and the deadline of this thread
    @jax.enable_x64(jax.enable_x64.value)
    @until(end)
    def in_context(arguments, context):
        return context.run(run, *arguments, on_pause=lambda step: not stopped.is_set())

    contexts = [copy_context() for _ in arguments]  # one for each, because a context runs in one thread at a time
    silent = None if len(arguments) > workers else True  # None shows the bar only in a terminal
    with ThreadPoolExecutor(min(workers, len(arguments))) as pool:
        try:
            return list(
                tqdm(pool.map(in_context, arguments, contexts), total=len(arguments), disable=silent, leave=False)
            )
        except BaseException:
            stopped.set()
            pool.shutdown(cancel_futures=True)
            raise


def march_one_by_one(program: Program, begin: Begin, steps: CountPerRun, every: int, samples: int) -> Result:
    """March every lane as a single run, with the program of a single run.

    Parameters and return value are those of :func:`march_in_tiles`.
    """

    def run(u0, v0, dt, steps, on_pause):
        return program.run(u0, v0, np.asarray(dt), steps, every, samples, on_pause=on_pause)

    u0, v0, dt, _ = begin
    sizes, counts = np.broadcast_to(dt, len(u0)), np.broadcast_to(steps, len(u0)).tolist()
    results = _on_cores(run, list(zip(u0, v0, sizes, counts, strict=True)))
    return jax.tree.map(lambda *lanes: np.stack(lanes), *results)


def march_in_tiles(program: Program, begin: Begin, steps: CountPerRun, every: int, samples: int) -> Result:
    """March every lane, side by side in tiles.

    The result of a lane depends neither on its neighbours nor on the number of cores, to the last bit. It equals that
    of a single run to round-off, since XLA compiles other loops (:mod:`study.marching.components`). Lanes with
    different numbers of steps are sorted by this number, so that long lanes share tiles; their results are then
    independent only to round-off. A tile takes as many Newton iterations as its slowest lane, and ends with its last
    lane.

    Parameters
    ----------
    begin
        Initial displacements and velocities (lanes, ...), step sizes () or (lanes,), and arguments of the function that
        makes the problems of a family (lanes, ...).
    steps
        Number of steps, of shape () or (lanes,).
    every, samples
        As in :meth:`study.marching.program.Program.run`.

    Returns
    -------
    Result
        NumPy arrays with the lanes along the first axis and the samples along the second.
    """
    u0, v0, dt, arguments = begin
    lanes = len(u0)
    on_cpu = jax.default_backend() == "cpu"
    tile = TILE if on_cpu else -(-lanes // BLOCK) * BLOCK
    tiles = -(-lanes // tile)
    share = min(GROUPS[-1], -(-tiles // cores())) if on_cpu else 1
    # few possible sizes keep the number of compiled programs small; empty tiles take no time, but memory
    heavy = sum(value[0].nbytes for value in [u0, *arguments.values()]) * (1 + samples) > LIGHT
    size = next(size for size in GROUPS if size >= share) if heavy or not on_cpu else GROUPS[-1]
    shape = (-(-tiles // share), share, tile)
    order = np.argsort(steps, kind="stable") if steps.ndim else np.arange(lanes)
    last = int(steps.max())
    # lanes that pad a tile start from NaN: they fail before their first step and add no Newton iterations
    in_tiles = partial(_in_tiles, shape=shape, size=size)
    tiled = {name: in_tiles(value[order], filler=value[order[-1]]) for name, value in arguments.items()}
    groups = (
        in_tiles(u0[order], filler=np.nan),
        in_tiles(v0[order], filler=0.0),
        in_tiles(dt[order], filler=dt[0]) if dt.ndim else np.full((shape[0], size), dt),
        in_tiles(steps[order], filler=0) if steps.ndim else [None] * shape[0],
        [{name: value[group] for name, value in tiled.items()} for group in range(shape[0])],
    )

    def run(u0, v0, dt, lane_steps, arguments, on_pause):
        # a group ends with its last lane; the number of steps of all groups makes them use one compiled program
        return program.run(u0, v0, dt, last, every, samples, lane_steps, on_pause=on_pause, arguments=arguments)

    results = _on_cores(run, list(zip(*groups, strict=True)))
    back = np.argsort(order)

    def gathered(parts, lane_axis=1):
        """Join the parts of all groups along the lanes, in their original order and without the padding."""
        whole = np.moveaxis(np.stack(parts, axis=1)[:share], lane_axis + 1, 2)
        return whole.reshape(-1, *whole.shape[3:])[-lanes:][back]

    return Result(
        gathered([r.status for r in results]),
        gathered([r.failed_at_step for r in results]),
        gathered([r.restarts for r in results]),
        {name: gathered([r.values[name] for r in results]) for name in results[0].values},
        {name: gathered([r.samples[name] for r in results], lane_axis=2) for name in results[0].samples},
    )
