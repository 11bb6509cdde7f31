"""How fast the study is: ratios of times that are taken side by side, by turns, on one core unless said otherwise.

``make benchmark`` runs it, prints the ratios as a table and writes them to ``results/benchmark.nc``.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import peer
import xarray as xr
from scipy.linalg import solve, solve_banded

import study
from reference import exact, taylor
from study import structures
from study.datasets import provenance, write
from study.observers import EnergyDrift, MaxEnergyError, NewtonIterations
from study.problems import printed_periods
from study.timing import Timed

REPEATS = 9
STEPS = 100_000
ENSEMBLE_STEPS = 1_000
FEW, MANY = 1_024, 16_384
LONG = 10_000
ALL = (MaxEnergyError(), EnergyDrift(), NewtonIterations())
COMPILE_AT_MOST = 0.3
#: Stages that one Newton iteration of a scheme solves for together.
STAGES = {"gauss4": 2}
#: The most that a ratio to C should be, by spring and scheme; other schemes in proportion.
TO_C = {
    "hardening": {"average_acceleration": 1.2, "central_difference": 1.25, "rk4": 1.0},
    "softening": {"average_acceleration": 0.7},
}


class Case(NamedTuple):
    """Two things to time by turns, each a function that returns seconds for the same work, or their units."""

    name: str
    ours: Callable[[], float]
    baseline: Callable[[], float]
    #: The most that the ratio should be.
    target: float
    #: Nanoseconds are per this many steps.
    steps: int


def _dt(problem: str) -> float:
    return printed_periods[problem] / 1000


def _timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def against_c(folder: str) -> Iterator[Case]:
    """A run with the energy observed against C of the same formula."""
    for spring, targets in TO_C.items():
        for name in peer.SCHEMES:
            ours = Timed(study.problems[spring], study.schemes[name], (MaxEnergyError(),))
            u0, dt = float(study.problems[spring].u0), _dt(spring)
            _, error = peer.single(spring, name, u0, dt, STEPS, folder)
            same = study.run(spring, name, dt=dt, steps=STEPS, observe=["max_energy_error"])
            np.testing.assert_allclose(same.max_energy_error / 100, error, rtol=1e-4, err_msg=f"{name} in C differs")
            yield Case(
                f"{name}, {spring} : C",
                lambda ours=ours, dt=dt: ours.run(dt, STEPS)[0],
                lambda args=(spring, name, u0, dt, STEPS, folder): peer.single(*args)[0],
                targets.get(name, targets["average_acceleration"]),
                STEPS,
            )


def tangents() -> Iterator[Case]:
    """Every implicit scheme against average acceleration, per tangent that is solved for."""

    def timed(spring, name):
        scheme, dt = study.schemes[name], _dt(spring)
        counted = study.run(spring, scheme, dt=dt, steps=STEPS, observe=["newton_iterations"])
        solved = counted.newton_iterations.item() * STAGES.get(name, 1)
        run = Timed(study.problems[spring], scheme, (EnergyDrift(),))
        return lambda: run.run(dt, STEPS)[0] / solved * STEPS

    for spring in TO_C:
        baseline = timed(spring, "average_acceleration")
        for name, scheme in study.schemes.items():
            if not scheme.explicit and name != "average_acceleration":
                yield Case(
                    f"{name}, {spring}, a tangent : average acceleration", timed(spring, name), baseline, 1.5, STEPS
                )


def forces() -> Iterator[Case]:
    """Every explicit scheme against central difference, per force that is evaluated."""
    for spring in TO_C:
        dt = _dt(spring)
        baseline = Timed(study.problems[spring], study.schemes["central_difference"], (EnergyDrift(),))
        for name, scheme in study.schemes.items():
            if scheme.explicit and name != "central_difference":
                run = Timed(study.problems[spring], scheme, (EnergyDrift(),))
                yield Case(
                    f"{name}, {spring}, a force : central difference",
                    lambda run=run, dt=dt, n=scheme.evaluations: run.run(dt, STEPS)[0] / n,
                    lambda dt=dt, baseline=baseline: baseline.run(dt, STEPS)[0],
                    1.5,
                    STEPS,
                )


def against_heyoka() -> Iterator[Case]:
    """The scheme of highest order against heyoka: 100 periods of the hardening spring to 1e-10."""
    problem, parts, periods = study.problems["hardening"], 32, 100
    exact_period, certified = exact.period(problem, printed_periods["hardening"])
    period = float(exact_period)
    t = period * (periods - 1 + np.arange(1, 17) / 16)
    truth = exact.folded(problem, t, exact_period, certified).u / float(problem.u0)
    samples = study.run("hardening", "extrapolation12", dt=period / parts, steps=parts * periods, every=parts // 16)
    ours, theirs = samples.u.values[-16:], taylor.trajectory(problem, t, 1e-13).u
    for u in (ours, theirs):
        assert np.max(np.abs(u / float(problem.u0) - truth)) < 1e-10
    run = Timed(problem, study.schemes["extrapolation12"], (EnergyDrift(),))
    yield Case(
        "extrapolation12, 100 periods to 1e-10 : heyoka",
        # heyoka's time has neither its set-up nor the call in it: ours is taken over ten times the periods
        lambda: run.run(period / parts, 10 * parts * periods)[0] / 10,
        lambda: taylor.trajectory(problem, t, 1e-13).seconds,
        1.0,
        parts * periods,
    )


def ensembles(folder: str) -> Iterator[Case]:
    """Lanes against a single run, against SIMD C, and against themselves in other numbers and company."""

    def run(spring, lanes, steps=ENSEMBLE_STEPS, dt=1.0, scheme="average_acceleration"):
        u0 = np.linspace(0.5, 1.0, lanes) * float(study.problems[spring].u0)
        arguments = {"u0": u0, "dt": dt * _dt(spring), "steps": steps, "observe": ["max_energy_error"]}
        return _timed(lambda: study.run(spring, scheme, **arguments))

    for spring, (to_single, to_c) in {"hardening": (0.08, 1.7), "softening": (0.3, 1.0)}.items():
        single = Timed(study.problems[spring], study.schemes["average_acceleration"], (MaxEnergyError(),))
        yield Case(
            f"{FEW} lanes, {spring} : single runs",
            lambda spring=spring: run(spring, FEW, LONG),
            lambda spring=spring, single=single: single.run(_dt(spring), FEW * LONG // 64)[0] * 64,
            to_single,
            FEW * LONG,
        )
        if peer.compiler():
            u0 = np.linspace(0.5, 1.0, FEW) * float(study.problems[spring].u0)
            arguments = spring, u0, _dt(spring), LONG, study.problems[spring].force, folder
            ends = study.run(spring, "average_acceleration", u0=u0, dt=_dt(spring), steps=LONG, every=LONG).u[:, -1]
            np.testing.assert_allclose(ends, peer.ensemble(*arguments)[1], atol=1e-6, err_msg="SIMD C differs")
            yield Case(
                f"{FEW} lanes, {spring} : SIMD C",
                lambda spring=spring: run(spring, FEW, LONG),
                lambda arguments=arguments: peer.ensemble(*arguments)[0],
                to_c,
                FEW * LONG,
            )
    for lanes in (8 * MANY, 1_000_000):
        yield Case(
            f"{lanes} lanes : {MANY} lanes, as often",
            lambda lanes=lanes: run("hardening", lanes, ENSEMBLE_STEPS // 4),
            lambda lanes=lanes: run("hardening", MANY, ENSEMBLE_STEPS // 4) * (lanes / MANY),
            1.1,
            lanes * ENSEMBLE_STEPS // 4,
        )
    mixed = np.linspace(1, 2 * ENSEMBLE_STEPS, MANY).astype(int)
    yield Case(
        f"lanes with 1 to {2 * ENSEMBLE_STEPS} steps : with {ENSEMBLE_STEPS} each",
        lambda: run("hardening", MANY, mixed),
        lambda: run("hardening", MANY),
        1.3,
        MANY * ENSEMBLE_STEPS,
    )
    unstable = np.where(np.arange(MANY) % 2, 1.0, 1e3)
    yield Case(
        "central difference, every second lane fails : none fails",
        lambda: run("hardening", MANY, dt=unstable, scheme="central_difference"),
        lambda: run("hardening", MANY, scheme="central_difference"),
        1.3,
        MANY * ENSEMBLE_STEPS,
    )

    def on_all_cores():
        granted = os.environ.pop("OMP_NUM_THREADS")
        seconds = run("hardening", MANY)
        os.environ["OMP_NUM_THREADS"] = granted
        return seconds

    yield Case("all cores : one core", on_all_cores, lambda: run("hardening", MANY), 0.6, MANY * ENSEMBLE_STEPS)


def recording() -> Iterator[Case]:
    """A trajectory against none."""

    def run(steps, **more):
        return _timed(lambda: study.run("hardening", "average_acceleration", dt=_dt("hardening"), steps=steps, **more))

    for every, target in ((1, 1.5), (10, 1.1), (1000, 1.1)):
        yield Case(
            f"trajectory, every {every} : nothing recorded",
            lambda every=every: run(STEPS * 10, observe=["trajectory"], every=every),
            lambda: run(STEPS * 10, observe=["energy_drift"]),
            target,
            STEPS * 10,
        )


def many_steps() -> Iterator[Case]:
    """A long run against a short one as many times: cost is linear in the number of steps."""
    scheme = Timed(study.problems["hardening"], study.schemes["central_difference"], (MaxEnergyError(),))
    for steps in (10**7, 10**8):
        yield Case(
            f"{steps:.0e} steps : {STEPS:.0e} steps, as often",
            lambda steps=steps: scheme.run(_dt("hardening"), steps)[0],
            lambda steps=steps: np.mean([scheme.run(_dt("hardening"), STEPS)[0] for _ in range(20)]) * (steps / STEPS),
            1.2,
            steps,
        )


def observers() -> Iterator[Case]:
    """Every scheme with all observers against none: the cliff of XLA's loops is out of reach."""

    def run(spring, name, **more):
        return _timed(lambda: study.run(spring, name, dt=_dt(spring), steps=STEPS * 10, **more))

    everything = {"observe": list(study.observers), "every": 10}
    for spring, names in {"hardening": list(study.schemes), "softening": peer.SCHEMES}.items():
        for name in names:
            yield Case(
                f"{name}, {spring}, all observers, records every 10 : none",
                lambda spring=spring, name=name: run(spring, name, **everything),
                lambda spring=spring, name=name: run(spring, name, observe=["energy_drift"]),
                1.6,
                STEPS * 10,
            )
    for name, scheme in study.schemes.items():
        ours, bare = (Timed(study.problems["hardening"], scheme, chosen) for chosen in (ALL, (EnergyDrift(),)))
        yield Case(
            f"{name}, all reductions : none",
            lambda ours=ours: ours.run(_dt("hardening"), STEPS)[0],
            lambda bare=bare: bare.run(_dt("hardening"), STEPS)[0],
            1.6,
            STEPS,
        )


def opensees() -> Iterator[Case]:
    """OpenSees, where its extra is installed, against the same scheme here."""
    from reference import opensees

    try:
        opensees.load()
    except opensees.NotInstalled as reason:
        print(reason)
        return
    for name in opensees.INTEGRATORS:
        ours = Timed(study.problems["hardening"], study.schemes[name], (EnergyDrift(),))
        yield Case(
            f"{name} : OpenSees",
            lambda ours=ours: ours.run(_dt("hardening"), STEPS)[0],
            lambda name=name: opensees.seconds("hardening", name, _dt("hardening"), 2000) * (STEPS / 2000),
            0.05,
            STEPS,
        )


def several_unknowns() -> Iterator[Case]:
    """Two unknowns against one; a bar's Newton iteration, and one of a full matrix, against LAPACK's solution alone."""
    one = Timed(study.problems["hardening"], study.schemes["average_acceleration"], ())
    for name, dt in (("stiff_soft", 0.2618), ("stiff_soft_sine", 0.2618)):
        two = Timed(study.problems[name], study.schemes["average_acceleration"], ())
        yield Case(
            f"average acceleration, {name}, two unknowns : hardening, one",
            lambda two=two, dt=dt: two.run(dt, STEPS)[0],
            lambda: one.run(_dt("hardening"), STEPS)[0],
            6.0,
            STEPS,
        )

    def iterations(problem, dt, steps):
        """Seconds of a run on its Newton iterations, with their number."""
        given = {"dt": dt, "steps": steps, "observe": ["newton_iterations"]}
        solved = study.run(problem, "average_acceleration", **given).newton_iterations.item()
        return (lambda: _timed(lambda: study.run(problem, "average_acceleration", **given))), int(solved)

    for n in (1_000, 10_000, 100_000, 1_000_000):
        bar = structures.impact_bar(n)
        ours, solved = iterations(bar, 1 / n, max(10, 1_000_000 // n))
        bands = np.array([np.full(n, -1.0), np.full(n, 4.0), np.full(n, -1.0)])
        # LAPACK's gtsv, which pivots, once for every Newton iteration
        yield Case(
            f"bar of {n:,}, an unknown and iteration : LAPACK's tridiagonal solution",
            ours,
            lambda bands=bands, n=n, solved=solved: solved * _timed(lambda: solve_banded((1, 1), bands, np.ones(n))),
            2.0,
            n * solved,
        )
    n = 100
    chain = structures.toda_chain(n)
    full = study.Problem(chain.force, chain.u0, chain.v0, tangent="dense", title="full chain")
    ours, solved = iterations(full, 0.1, 2_000)
    matrix = np.eye(n) + 0.01 * np.random.default_rng(0).normal(size=(n, n))
    yield Case(
        f"{n} unknowns with a full tangent, an iteration : LAPACK's solution",
        ours,
        lambda: solved * _timed(lambda: solve(matrix, np.ones(n), check_finite=False)),
        1.5,
        solved,
    )


_COMPILE = """
import sys, time, jax, study
from study.observers import MaxEnergyError
from study.timing import Timed
misses = []
jax.monitoring.register_event_listener(lambda name, **_: misses.append(1) if name.endswith("cache_misses") else None)
jax.jit(lambda x: x + 1)(1.0)
for problem in ("hardening", "softening"):
    for name, scheme in study.schemes.items():
        print(problem, name, Timed(study.problems[problem], scheme, (MaxEnergyError(),)).compile_time)
print(len(misses))
"""


def compilation() -> pd.DataFrame:
    """Seconds to trace and compile by problem and scheme, in a first and a second process, and programs compiled."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"XDG_CACHE_HOME": folder}
        columns = {}
        for process in ("first process", "second process"):
            done = subprocess.run(
                [sys.executable, "-c", _COMPILE], env=environment, capture_output=True, text=True, check=True
            )
            *lines, compiled = done.stdout.split("\n")[:-1]
            values = {tuple(line.split()[:2]): float(line.split()[2]) for line in lines}
            columns[process] = pd.Series(values | {("programs", "compiled"): float(compiled)})
    return pd.DataFrame(columns)


def measure(cases: list[Case]) -> xr.Dataset:
    """Every case by turns; the first turn is a warm-up."""
    ours, baseline = np.empty((len(cases), REPEATS)), np.empty((len(cases), REPEATS))
    for c, case in enumerate(cases):
        for repeat in range(-1, REPEATS):
            pair = case.ours(), case.baseline()
            if repeat >= 0:
                ours[c, repeat], baseline[c, repeat] = 1e9 * np.array(pair) / case.steps
        print(f"{case.name}: {np.median(ours[c] / baseline[c]):.3f}", flush=True)
    ratio = ours / baseline
    quartiles = np.quantile(ratio, [0.25, 0.75], axis=1)
    dims = ("case", "repeat")
    return xr.Dataset(
        {
            "time": (dims, ours, {"long_name": "time of a step", "units": "ns"}),
            "baseline_time": (dims, baseline, {"long_name": "time of a step of the baseline", "units": "ns"}),
            "ratio": ("case", np.median(ratio, axis=1), {"long_name": "median ratio of the two", "units": "1"}),
            "spread": ("case", quartiles[1] - quartiles[0], {"long_name": "its interquartile range", "units": "1"}),
            "target": ("case", [c.target for c in cases], {"long_name": "the most that it should be", "units": "1"}),
        },
        {
            "case": ("case", [c.name for c in cases], {"long_name": "what is timed : its baseline"}),
            "repeat": ("repeat", np.arange(REPEATS), {"long_name": "repeat", "units": "1"}),
        },
    )


def main(output: Path) -> None:
    """Measure, print, write."""
    os.environ["OMP_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as folder:
        if not peer.compiler():
            print("no C compiler: the comparisons with C are left out; install gcc, or name a compiler in CC.")
        cases = [
            *(against_c(folder) if peer.compiler() else ()),
            *tangents(),
            *forces(),
            *against_heyoka(),
            *ensembles(folder),
            *recording(),
            *many_steps(),
            *observers(),
            *opensees(),
            *several_unknowns(),
        ]
        ds = measure(cases)
    table = pd.DataFrame(
        {
            "ns": ds.time.median("repeat").round(1),
            "baseline ns": ds.baseline_time.median("repeat").round(1),
            "ratio": ds.ratio.round(3),
            "±": ds.spread.round(3),
            "at most": ds.target,
            "": np.where(ds.ratio <= ds.target, "", "missed"),
        },
        index=ds.case.values,
    )
    compiled = compilation()
    print(table.to_string(), "\n", compiled.to_string())
    slow = compiled["first process"].drop(index=("programs", "compiled"))
    print(
        f"compiling takes at most {slow.max():.2f} s ({', '.join(slow.idxmax())}); it should take {COMPILE_AT_MOST} s."
    )
    process = ("process", ["first", "second"], {"long_name": "process"})
    times = compiled.drop(index=("programs", "compiled"))
    ds = ds.assign_coords(
        process=process, program=("program", [", ".join(p) for p in times.index], {"long_name": "program"})
    )
    ds["compile_time"] = ("program", "process"), times.values, {"long_name": "time to trace and compile", "units": "s"}
    ds.attrs = provenance("Ratios of times, side by side", "tests/benchmarks/benchmark.py")
    write(ds, output)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
