"""Ensembles compared with single runs, with C, and with ensembles of other sizes or of other mixtures of lanes."""

import os
from collections.abc import Iterator

import jax.numpy as jnp
import numpy as np
import peer
from case import Case, step_size, timed

import study
from study.marching.timing import Timed
from study.observer.energy import MaxEnergyError
from study.observer.outcome import OutcomeObserver

STEPS, LONG = 1_000, 10_000
FEW, MANY = 1_024, 16_384


def chain(unknowns: int, scale: float = 1.0) -> study.Problem:
    """A chain of cubic springs with damping, pulled by a pulse of this scale."""

    def force(u):
        stretch = jnp.diff(u, prepend=jnp.zeros(1))
        pull = 500 * stretch * (1 + 20 * stretch * stretch)
        return pull - jnp.concatenate([pull[1:], jnp.zeros(1)])

    return study.Problem(
        force,
        np.zeros(unknowns),
        damping=np.ones(unknowns),
        load=lambda t: 3 * scale * jnp.sin(7 * t) * jnp.exp(-((t - 3) ** 2)) * jnp.ones(unknowns),
        tangent="tridiagonal" if unknowns > 4 else "dense",
    )


def chains() -> Iterator[Case]:
    """Lanes of few unknowns, compared with single runs."""
    for scheme, sizes in {"central_difference": (2, 4, 8, 16), "average_acceleration": (2, 3, 4, 8)}.items():
        for unknowns in sizes:
            problem, u0 = chain(unknowns), np.linspace(0, 0.1, FEW)[:, None] * np.ones(unknowns)
            arguments = {"scheme": scheme, "dt": 0.004, "observe": "peak", "bound": 1e9}
            yield Case(
                f"{FEW} lanes, {unknowns} unknowns, {scheme} : single runs",
                lambda problem=problem, u0=u0, a=arguments: timed(lambda: study.run(problem, u0=u0, steps=STEPS, **a)),
                lambda problem=problem, a=arguments: timed(lambda: study.run(problem, steps=FEW * STEPS // 8, **a)) * 8,
                0.6,
                FEW * STEPS,
            )


def cases(folder: str) -> Iterator[Case]:
    """All timed cases of ensembles; the folder holds the compiled C code."""

    def run(spring, lanes, steps=STEPS, dt=1.0, scheme="average_acceleration", observe=("max_energy_error",)):
        u0 = np.linspace(0.5, 1.0, lanes) * float(study.problems[spring].u0)
        arguments = {"u0": u0, "dt": dt * step_size(spring), "steps": steps, "observe": observe}
        return timed(lambda: study.run(spring, scheme, **arguments))

    for spring, (to_single, to_c) in {"hardening": (0.08, 1.7), "softening": (0.3, 1.0)}.items():
        single = Timed(study.problems[spring], study.schemes["average_acceleration"], (MaxEnergyError(),))
        yield Case(
            f"{FEW} lanes, {spring} : single runs",
            lambda spring=spring: run(spring, FEW, LONG),
            lambda spring=spring, single=single: single.run(step_size(spring), FEW * LONG // 64)[0] * 64,
            to_single,
            FEW * LONG,
        )
        if peer.compiler():
            u0 = np.linspace(0.5, 1.0, FEW) * float(study.problems[spring].u0)
            arguments = spring, u0, step_size(spring), LONG, study.problems[spring].force, folder
            ends = study.run(spring, "average_acceleration", u0=u0, dt=step_size(spring), steps=LONG, every=LONG).u[
                :, -1
            ]
            np.testing.assert_allclose(ends, peer.ensemble(*arguments)[1], atol=1e-6, err_msg="SIMD C differs")
            yield Case(
                f"{FEW} lanes, {spring} : SIMD C",
                lambda spring=spring: run(spring, FEW, LONG),
                lambda arguments=arguments: peer.ensemble(*arguments)[0],
                to_c,
                FEW * LONG,
            )
    yield from chains()
    for lanes in (8 * MANY, 1_000_000):
        yield Case(
            f"{lanes} lanes : {MANY} lanes, in proportion",
            lambda lanes=lanes: run("hardening", lanes, STEPS // 4),
            lambda lanes=lanes: run("hardening", MANY, STEPS // 4) * (lanes / MANY),
            1.1,
            lanes * STEPS // 4,
        )
    maps = OutcomeObserver.of(study.problems["hardening"]), "lyapunov_exponent"
    yield Case(
        "as for the maps of stability : energy alone",
        lambda: run("hardening", FEW, LONG, dt=20, observe=maps),
        lambda: run("hardening", FEW, LONG, dt=20),
        2.0,
        FEW * LONG,
    )
    mixed = np.linspace(1, 2 * STEPS, MANY).astype(int)
    yield Case(
        f"lanes with 1 to {2 * STEPS} steps : with {STEPS} each",
        lambda: run("hardening", MANY, mixed),
        lambda: run("hardening", MANY),
        1.3,
        MANY * STEPS,
    )
    unstable = np.where(np.arange(MANY) % 2, 1.0, 1e3)
    yield Case(
        "central difference, every second lane fails : none fails",
        lambda: run("hardening", MANY, dt=unstable, scheme="central_difference"),
        lambda: run("hardening", MANY, scheme="central_difference"),
        1.3,
        MANY * STEPS,
    )

    def on_all_cores():
        granted = os.environ.pop("OMP_NUM_THREADS")
        seconds = run("hardening", MANY)
        os.environ["OMP_NUM_THREADS"] = granted
        return seconds

    yield Case("all cores : one core", on_all_cores, lambda: run("hardening", MANY), 0.6, MANY * STEPS)
