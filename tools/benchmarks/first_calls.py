"""First calls on a structure, with compilation, compared with a hand-written loop; lanes compared with single runs."""

import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from case import Case, example, timed
from jax import lax

import study
from study.algebra.elimination import eliminate

STEPS, DURATION, LANES = 3000, 31.2, 8
DT = DURATION / STEPS


def _by_hand(frame: study.Problem) -> Callable:
    """Average acceleration on the frame with Newton's iteration, written by hand for this problem alone."""
    mass, damping = jnp.diag(jnp.asarray(frame.mass)), jnp.asarray(frame.damping)
    force, load, c_v, c_u = frame.force, frame.load, DT / 2, DT**2 / 4
    assert load is not None

    def run(u0):
        v0 = jnp.zeros_like(u0)
        a0 = (load(jnp.zeros(())) - force(u0)) / jnp.diag(mass)

        def step(i, carry):
            u, v, a, us, vs = carry
            u_predicted, v_predicted = u + DT * v + c_u * a, v + c_v * a
            rhs = load((i + 1.0) * DT) - damping @ v_predicted

            def iterate(state):
                a, _, count = state
                place = u_predicted + c_u * a
                residual = mass @ a + c_v * damping @ a + force(place) - rhs
                [change] = eliminate(mass + c_v * damping + c_u * jax.jacfwd(force)(place), residual)
                size = c_u * jnp.sqrt(change @ change)
                return a - change, size > 1e-12 * jnp.sqrt(u_predicted @ u_predicted), count + 1

            a, *_ = lax.while_loop(lambda s: s[1] & (s[2] < 50), iterate, (a, jnp.array(True), 0))
            u, v = u_predicted + c_u * a, v_predicted + c_v * a
            return u, v, a, us.at[i + 1].set(u), vs.at[i + 1].set(v)

        room = jnp.zeros((STEPS + 1, len(u0)))
        return lax.fori_loop(0, STEPS, step, (u0, v0, a0, room, room))[3:]

    return run


def first(call: Callable[[], Any]) -> float:
    """Seconds of a call that has to compile its programs."""
    jax.clear_caches()
    jax.config.update("jax_enable_compilation_cache", False)
    start = time.perf_counter()
    jax.block_until_ready(call())
    seconds = time.perf_counter() - start
    jax.config.update("jax_enable_compilation_cache", True)
    return seconds


def _as_often(call: Callable[[], Any]) -> float:
    return LANES * timed(call)


def cases() -> Iterator[Case]:
    """All timed cases: first calls of one run and of eight lanes, and eight lanes compared with eight runs."""
    frame = example("frame").frame
    by_hand = _by_hand(frame)
    u0 = np.linspace(0.0, 1e-3, LANES)[:, None] * np.ones(3)

    def ours(scheme: str, **options: Any) -> np.ndarray:
        return study.run(frame, scheme, dt=DT, steps=STEPS, **options).u.values

    for scheme, alone, lanes in (("average_acceleration", 1.4, 1.5), ("bathe", 2.1, 2.3), ("rk4", 0.8, 0.95)):
        single, ensemble = partial(ours, scheme), partial(ours, scheme, u0=u0)
        yield Case(
            f"first run of a frame, {scheme} : average acceleration by hand",
            partial(first, single),
            partial(first, lambda: jax.jit(by_hand)(jnp.zeros(3))),
            alone,
            1,
        )
        yield Case(
            f"first run of {LANES} frames, {scheme} : average acceleration by hand",
            partial(first, ensemble),
            partial(first, lambda: jax.jit(jax.vmap(by_hand))(jnp.asarray(u0))),
            lanes,
            1,
        )
        yield Case(
            f"{LANES} frames, {scheme} : as many single runs",
            partial(timed, ensemble),
            partial(_as_often, single),
            0.5,
            LANES * STEPS,
        )
