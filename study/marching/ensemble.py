"""Many runs side by side: in tiles that fit the cache next to a core, over all cores."""

import math
import os
import threading
from concurrent.futures import ThreadPoolExecutor

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from tqdm import tqdm

from study.marching.march import March, Outcome, march

#: Lanes of a tile: their state stays in the cache next to the core, whatever the size of the ensemble. Also a small
#: one fills a whole tile, or its loops would be compiled otherwise and its results differ in the last bits.
TILE = 64

#: Tiles that are marched in one call, at most.
GROUP = 64

#: Lane-steps of a group between two chances to be interrupted: less than a second.
PAUSE = 2**26


def cores() -> int:
    """Cores that a run may use: what ``OMP_NUM_THREADS`` grants (Snakemake sets it for its jobs), or all."""
    granted = os.environ.get("OMP_NUM_THREADS", "")
    if granted.isdigit() and int(granted):
        return int(granted)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@eqx.filter_jit
def _march_group(definition: March, u0, dt, own, until, every, samples: int, each_step: bool, progress=None):
    """One tile after the other, to step ``until``; ``own`` are the steps of each lane, or nothing."""

    def tile(lanes):
        u0, dt, own, progress = lanes
        end = until if own is None else jnp.minimum(until, own.max())
        return march(definition, u0, dt, end, every, samples, each_step, own, progress)

    return lax.map(tile, (u0, dt, own, progress))


def _in_groups(values: np.ndarray, shape: tuple[int, int, int], filler: float) -> np.ndarray:
    """Values of lanes by group, tile and lane of the tile, the places left over filled up."""
    room = np.full((np.prod(shape), *values.shape[1:]), filler, values.dtype)
    room[: len(values)] = values
    return room.reshape(*shape, *values.shape[1:])


def march_ensemble(definition: March, u0: np.ndarray, dt: np.ndarray, steps: np.ndarray, every: int, samples: int):
    """March every lane; the :class:`Outcome` as NumPy arrays with the lanes first and the samples behind them.

    A lane depends neither on its neighbours nor on the number of cores, to the bit; with step counts of their own, by
    which lanes are sorted so that the long ones share their tiles, to round-off. A tile takes as many Newton iterations
    as the slowest of its lanes, and ends when its last lane does.

    Parameters
    ----------
    u0, dt
        Of every lane, (lanes, ...) and (lanes,).
    steps
        One number, or one per lane.
    every, samples
        As in :func:`study.march.march`.
    """
    lanes = len(dt)
    on_cpu = jax.default_backend() == "cpu"
    tile = TILE if on_cpu else lanes
    workers = cores() if on_cpu else 1
    # a power of two, so that few sizes have to be compiled
    group = min(GROUP, 2 ** math.ceil(math.log2(-(-lanes // (tile * workers)))))
    shape = (-(-lanes // (tile * group)), group, tile)
    order = np.argsort(steps, kind="stable") if steps.ndim else np.arange(lanes)
    last = int(steps.max())
    # a lane that starts from NaN has failed before its first step, and costs none
    groups = (
        _in_groups(u0[order], shape, np.nan),
        _in_groups(dt[order], shape, 1.0),
        _in_groups(steps[order], shape, last) if steps.ndim else [None] * shape[0],
    )
    stopped = threading.Event()

    @jax.enable_x64(jax.enable_x64.value)  # which another thread does not know of its own
    def run(one):
        _, _, own = one
        end, progress, until = last if own is None else int(own.max()), None, 0
        while until < end and not stopped.is_set():
            until = min(until + max(1, PAUSE // (group * tile)), end)
            numbers = np.asarray(until), np.asarray(every)
            progress, outcome = _march_group(definition, *one, *numbers, samples, every == 1, progress)
            jax.block_until_ready(outcome)
        return jax.tree.map(np.asarray, outcome)

    silent = None if shape[0] > workers else True  # None: unless nobody watches
    with ThreadPoolExecutor(min(workers, shape[0])) as pool:
        try:
            outcomes = list(tqdm(pool.map(run, zip(*groups, strict=True)), total=shape[0], disable=silent, leave=False))
        except BaseException:
            stopped.set()
            pool.shutdown(cancel_futures=True)
            raise
    back = np.argsort(order)

    def gathered(parts, lane_axis=1):
        """The parts of all groups along the lanes in their first order; the places left over are dropped."""
        whole = np.moveaxis(np.stack(parts), lane_axis + 1, 2)
        return whole.reshape(-1, *whole.shape[3:])[:lanes][back]

    return Outcome(
        gathered([o.status for o in outcomes]),
        gathered([o.failed_at_step for o in outcomes]),
        {name: gathered([o.values[name] for o in outcomes]) for name in outcomes[0].values},
        {name: gathered([o.samples[name] for o in outcomes], lane_axis=2) for name in outcomes[0].samples},
    )
