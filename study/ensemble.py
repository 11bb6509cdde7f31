"""Many runs side by side: in tiles that fit the cache next to a core, over all cores."""

import os
from concurrent.futures import ThreadPoolExecutor

import equinox as eqx
import jax
import numpy as np
from jax import lax
from tqdm import tqdm

from study.march import March, Outcome, march

#: Lanes of a tile: their state stays in the cache next to the core, whatever the size of the ensemble. Also a small
#: one fills a whole tile, or its loops would be compiled otherwise and its results differ in the last bits.
TILE = 128
#: Tiles between two chances to be interrupted, at most.
GROUP = 64


def cores() -> int:
    """Cores that a run may use: what ``OMP_NUM_THREADS`` grants (Snakemake sets it for its jobs), or all."""
    granted = os.environ.get("OMP_NUM_THREADS", "")
    if granted.isdigit() and int(granted):
        return int(granted)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@eqx.filter_jit
def _march_group(definition: March, u0, dt, steps, every, samples: int, each_step: bool) -> Outcome:
    """One tile after the other; ``steps`` is one number, or one per lane."""

    def tile(lanes):
        own = lanes[2] if steps.ndim else None
        until = steps if own is None else own.max()
        _, outcome = march(definition, lanes[0], lanes[1], until, every, samples, each_step, own)
        return outcome

    return lax.map(tile, (u0, dt, steps) if steps.ndim else (u0, dt))


def _in_groups(values: np.ndarray, shape: tuple[int, int, int], filler: float) -> np.ndarray:
    """Values of lanes by group, tile and lane of the tile, the places left over filled up."""
    room = np.full((np.prod(shape), *values.shape[1:]), filler, values.dtype)
    room[: len(values)] = values
    return room.reshape(*shape, *values.shape[1:])


def march_ensemble(definition: March, u0: np.ndarray, dt: np.ndarray, steps: np.ndarray, every: int, samples: int):
    """March every lane; the :class:`Outcome` as NumPy arrays with the lanes first and the samples behind them.

    A lane depends neither on its neighbours nor on the number of cores. A tile ends when its last lane does; lanes
    with step counts of their own are sorted by them first, so that the long ones share their tiles.

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
    group = min(GROUP, -(-lanes // (tile * workers)))
    shape = (-(-lanes // (tile * group)), group, tile)
    order = np.argsort(steps, kind="stable") if steps.ndim else np.arange(lanes)
    # a lane that starts from NaN has failed before its first step, and costs none
    groups = (
        _in_groups(u0[order], shape, np.nan),
        _in_groups(dt[order], shape, 1.0),
        _in_groups(steps[order], shape, 0) if steps.ndim else [steps] * shape[0],
    )

    def run(one):
        return jax.tree.map(np.asarray, _march_group(definition, *one, np.asarray(every), samples, every == 1))

    with ThreadPoolExecutor(min(workers, shape[0])) as pool:
        try:
            silent = None if shape[0] > workers else True  # None: unless nobody watches
            outcomes = list(tqdm(pool.map(run, zip(*groups, strict=True)), total=shape[0], disable=silent, leave=False))
        except BaseException:
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
