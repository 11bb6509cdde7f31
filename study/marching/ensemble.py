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

from study.marching.march import March, march
from study.marching.result import Result
from study.marching.shapes import Counts, DisplacementsOfLanes, OfLanes

#: Lanes of a tile; their state stays in the cache next to the core, whatever the size of the ensemble. Small ensembles
#: are padded to a tile; otherwise XLA compiles another loop and the last bits differ.
TILE = 64

#: Maximum number of tiles that one call marches.
GROUP = 64

#: Lane-steps of a group between two chances to interrupt it: less than a second.
PAUSE = 2**26


def cores() -> int:
    """Cores that a run may use: ``OMP_NUM_THREADS`` if set (Snakemake sets it for its jobs), otherwise all of them."""
    granted = os.environ.get("OMP_NUM_THREADS", "")
    if granted.isdigit() and int(granted):
        return int(granted)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@eqx.filter_jit
def _march_group(definition: March, u0, dt, own, until, every, samples: int, each_step: bool, progress=None):
    """March tile by tile to step ``until``; ``own`` holds the number of steps of each lane, or is None."""

    def tile(lanes):
        u0, dt, own, progress = lanes
        end = until if own is None else jnp.minimum(until, own.max())
        return march(definition, u0, dt, end, every, samples, each_step, own, progress)

    return lax.map(tile, (u0, dt, own, progress))


def _in_groups(values: np.ndarray, shape: tuple[int, int, int], filler: float) -> np.ndarray:
    """Values of the lanes, of shape (groups, tiles, lanes of a tile, ...); empty places hold ``filler``."""
    room = np.full((np.prod(shape), *values.shape[1:]), filler, values.dtype)
    room[: len(values)] = values
    return room.reshape(*shape, *values.shape[1:])


def march_ensemble(
    definition: March, u0: DisplacementsOfLanes, dt: OfLanes, steps: Counts, every: int, samples: int
) -> Result:
    """March every lane.

    A lane depends neither on its neighbours nor on the number of cores, to the last bit. If lanes have their own
    numbers of steps, they are sorted by them, so that long lanes share tiles; then this holds to round-off. A tile
    takes as many Newton iterations as its slowest lane, and ends with its last lane.

    Parameters
    ----------
    u0, dt
        Initial displacements and step sizes, (lanes, ...) and (lanes,).
    steps
        One number, or one per lane.
    every, samples
        As in :func:`study.marching.march.march`.

    Returns
    -------
    Result
        NumPy arrays with the lanes along the first axis and the samples along the second.
    """
    lanes = len(dt)
    on_cpu = jax.default_backend() == "cpu"
    tile = TILE if on_cpu else lanes
    workers = cores() if on_cpu else 1
    # powers of two keep the number of compiled sizes small
    group = min(GROUP, 2 ** math.ceil(math.log2(-(-lanes // (tile * workers)))))
    shape = (-(-lanes // (tile * group)), group, tile)
    order = np.argsort(steps, kind="stable") if steps.ndim else np.arange(lanes)
    last = int(steps.max())
    # lanes that fill up a tile start from NaN: they fail before their first step and cost nothing
    groups = (
        _in_groups(u0[order], shape, np.nan),
        _in_groups(dt[order], shape, 1.0),
        _in_groups(steps[order], shape, last) if steps.ndim else [None] * shape[0],
    )
    stopped = threading.Event()

    @jax.enable_x64(jax.enable_x64.value)  # a new thread does not inherit the precision of this one
    def run(one):
        u0, dt, own = one
        end, progress, until = last if own is None else int(own.max()), None, 0
        while until < end and not stopped.is_set():
            until = min(until + max(1, PAUSE // (group * tile)), end)
            numbers = np.asarray(until), np.asarray(every)
            progress, result = _march_group(definition, u0, dt, own, *numbers, samples, every == 1, progress)
            jax.block_until_ready(result)
        return jax.tree.map(np.asarray, result)

    silent = None if shape[0] > workers else True  # None shows the bar in a terminal only
    with ThreadPoolExecutor(min(workers, shape[0])) as pool:
        try:
            results = list(tqdm(pool.map(run, zip(*groups, strict=True)), total=shape[0], disable=silent, leave=False))
        except BaseException:
            stopped.set()
            pool.shutdown(cancel_futures=True)
            raise
    back = np.argsort(order)

    def gathered(parts, lane_axis=1):
        """Join the parts of all groups along the lanes, in their original order and without the padding."""
        whole = np.moveaxis(np.stack(parts), lane_axis + 1, 2)
        return whole.reshape(-1, *whole.shape[3:])[:lanes][back]

    return Result(
        gathered([r.status for r in results]),
        gathered([r.failed_at_step for r in results]),
        {name: gathered([r.values[name] for r in results]) for name in results[0].values},
        {name: gathered([r.samples[name] for r in results], lane_axis=2) for name in results[0].samples},
    )
