"""Single runs compared with C, heyoka and OpenSees, and single runs of schemes compared with each other."""

from collections.abc import Iterator

import numpy as np
import peer
from case import STEPS, Case, step_size, timed

import study
from reference import exact, taylor
from study.analysis.forces import forces_of
from study.marching.timing import Timed
from study.observer.base import Reduction
from study.observer.energy import EnergyDrift, MaxEnergyError
from study.problem.named import printed_periods
from study.program import opensees_run
from tools import opensees

#: Number of stages that a Newton iteration of the scheme solves together; one for other schemes.
STAGES = {"gauss4": 2}
#: Largest acceptable ratio to C, by spring and scheme; the ratio of average acceleration holds for other schemes.
TO_C = {
    "hardening": {"average_acceleration": 1.4, "central_difference": 1.4, "rk4": 1.1},
    "softening": {"average_acceleration": 0.75},
}


def cases(folder: str) -> Iterator[Case]:
    """All timed cases of single runs; the folder holds the compiled C code."""
    if peer.compiler():
        yield from against_c(folder)
    yield from tangents()
    yield from forces()
    yield from against_heyoka()
    yield from recording()
    yield from many_steps()
    yield from observers()
    yield from against_opensees()


def against_c(folder: str) -> Iterator[Case]:
    """A run that observes the energy, compared with the same formulas in C."""
    for spring, targets in TO_C.items():
        for name in peer.SCHEMES:
            ours = Timed(study.problems[spring], study.schemes[name], (MaxEnergyError(),))
            u0, dt = float(study.problems[spring].u0), step_size(spring)
            _, error = peer.single(spring, name, u0, dt, STEPS, folder)
            ds = study.run(spring, name, dt=dt, steps=STEPS, observe=["max_energy_error"])
            np.testing.assert_allclose(ds.max_energy_error, error, rtol=1e-4, err_msg=f"{name} in C differs")
            yield Case(
                f"{name}, {spring} : C",
                lambda ours=ours, dt=dt: ours.run(dt, STEPS)[0],
                lambda args=(spring, name, u0, dt, STEPS, folder): peer.single(*args)[0],
                targets.get(name, targets["average_acceleration"]),
                STEPS,
            )


def tangents() -> Iterator[Case]:
    """Every implicit scheme compared with average acceleration, by time per solution of a linear system."""

    def timed(spring, name):
        scheme, dt = study.schemes[name], step_size(spring)
        ds = study.run(spring, scheme, dt=dt, steps=STEPS, observe=["newton_iterations"])
        solutions = ds.newton_iterations.item() * STAGES.get(name, 1)
        run = Timed(study.problems[spring], scheme, (EnergyDrift(),))
        return lambda: run.run(dt, STEPS)[0] / solutions * STEPS

    for spring in TO_C:
        baseline = timed(spring, "average_acceleration")
        for name, scheme in study.schemes.items():
            if not scheme.explicit and name != "average_acceleration":
                yield Case(
                    f"{name}, {spring}, a tangent : average acceleration", timed(spring, name), baseline, 1.5, STEPS
                )


def forces() -> Iterator[Case]:
    """Every explicit scheme compared with central difference, by time per evaluation of the force."""
    for spring in TO_C:
        dt = step_size(spring)
        baseline = Timed(study.problems[spring], study.schemes["central_difference"], (EnergyDrift(),))
        for name, scheme in study.schemes.items():
            if scheme.explicit and name != "central_difference":
                forces = forces_of(scheme).per_step
                run = Timed(study.problems[spring], scheme, (EnergyDrift(),))
                yield Case(
                    f"{name}, {spring}, a force : central difference",
                    lambda run=run, dt=dt, n=forces: run.run(dt, STEPS)[0] / n,
                    lambda dt=dt, baseline=baseline: baseline.run(dt, STEPS)[0],
                    1.5,
                    STEPS,
                )


def against_heyoka() -> Iterator[Case]:
    """The scheme of highest order compared with heyoka, over 100 periods of the hardening spring to 1e-10."""
    problem, parts, periods = study.problems["hardening"], 32, 100
    exact_period, certified = exact.period(problem, printed_periods["hardening"])
    period = float(exact_period)
    t = period * (periods - 1 + np.arange(1, 17) / 16)
    truth = exact.folded(problem, t, exact_period, certified).u / float(problem.u0)
    samples = study.run("hardening", "extrapolation12", dt=period / parts, steps=parts * periods, every=parts // 16)
    samples_u, heyoka_u = samples.u.values[-16:], taylor.trajectory(problem, t, 1e-13).u
    for u in (samples_u, heyoka_u):
        assert np.max(np.abs(u / float(problem.u0) - truth)) < 1e-10
    run = Timed(problem, study.schemes["extrapolation12"], (EnergyDrift(),))
    yield Case(
        "extrapolation12, 100 periods to 1e-10 : heyoka",
        # heyoka's time excludes set-up and call; our run is ten times as long, so our set-up and call matter little
        lambda: run.run(period / parts, 10 * parts * periods)[0] / 10,
        lambda: taylor.trajectory(problem, t, 1e-13).seconds,
        1.0,
        parts * periods,
    )


def recording() -> Iterator[Case]:
    """Runs that record a trajectory, compared with runs that record no trajectory."""

    def run(steps, **more):
        return timed(
            lambda: study.run("hardening", "average_acceleration", dt=step_size("hardening"), steps=steps, **more)
        )

    for every, target in ((1, 1.5), (10, 1.1), (1000, 1.1)):
        yield Case(
            f"trajectory, every {every} : nothing recorded",
            lambda every=every: run(STEPS * 10, observe=["trajectory"], every=every),
            lambda: run(STEPS * 10, observe=["energy_drift"]),
            target,
            STEPS * 10,
        )


def many_steps() -> Iterator[Case]:
    """A long run compared with short runs, in proportion; the cost must be linear in the number of steps."""
    scheme = Timed(study.problems["hardening"], study.schemes["central_difference"], (MaxEnergyError(),))
    for steps in (10**7, 10**8):
        yield Case(
            f"{steps:.0e} steps : {STEPS:.0e} steps, in proportion",
            lambda steps=steps: scheme.run(step_size("hardening"), steps)[0],
            lambda steps=steps: (
                np.mean([scheme.run(step_size("hardening"), STEPS)[0] for _ in range(20)]) * (steps / STEPS)
            ),
            1.2,
            steps,
        )


def observers() -> Iterator[Case]:
    """Every scheme with all observers compared with one observer; XLA must still compile the longer loops natively."""

    def run(spring, name, **more):
        return timed(lambda: study.run(spring, name, dt=step_size(spring), steps=STEPS * 10, **more))

    # observers that need a neighbouring motion are left out, because another program computes their runs
    every_one = [
        o for o in study.observers.values() if not o.refusal(study.problems["hardening"]) and not o.needs_neighbour
    ]
    reductions = tuple(o for o in every_one if isinstance(o, Reduction))
    options = {"observe": every_one, "every": 10}
    for spring, names in {"hardening": list(study.schemes), "softening": peer.SCHEMES}.items():
        for name in names:
            yield Case(
                f"{name}, {spring}, all observers, records every 10 : none",
                lambda spring=spring, name=name: run(spring, name, **options),
                lambda spring=spring, name=name: run(spring, name, observe=["energy_drift"]),
                1.6,
                STEPS * 10,
            )
    for name, scheme in study.schemes.items():
        ours, bare = (Timed(study.problems["hardening"], scheme, chosen) for chosen in (reductions, (EnergyDrift(),)))
        yield Case(
            f"{name}, all reductions : none",
            lambda ours=ours: ours.run(step_size("hardening"), STEPS)[0],
            lambda bare=bare: bare.run(step_size("hardening"), STEPS)[0],
            1.6,
            STEPS,
        )


def against_opensees() -> Iterator[Case]:
    """Schemes of the study compared with the same schemes in OpenSees, if the extra ``opensees`` is installed."""
    try:
        opensees_run.interpreter()
    except ImportError as reason:
        print(reason)
        return
    for name in opensees.INTEGRATORS:
        ours = Timed(study.problems["hardening"], study.schemes[name], (EnergyDrift(),))
        yield Case(
            f"{name} : OpenSees",
            lambda ours=ours: ours.run(step_size("hardening"), STEPS)[0],
            lambda name=name: opensees.seconds("hardening", name, step_size("hardening"), 2000) * (STEPS / 2000),
            0.05,
            STEPS,
        )
