"""``study.assess`` for many unknowns, or unknowns without mass: steps are halved until two schemes agree."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr

from study.algebra.matrices import diagonal, times
from study.assessment.arguments import Question
from study.assessment.program import assess_program
from study.assessment.progress import Progress
from study.marching.run import run, sweep
from study.mechanics.balance import load
from study.mechanics.definition import Problem
from study.mechanics.loads import record_of
from study.mechanics.tangent import FINDABLE
from study.observer.motion import Quantity
from study.program.definition import Program
from study.scheme.base import Scheme
from study.scheme.named import schemes as schemes_by_name

#: Largest number of unknowns at which displacement and velocity are compared if no quantities are given.
SHOWN = 256

#: Sizes of random states. The terms of the equation at these states distinguish problems, and internal forces at them
#: show which unknowns have a linear force.
SIZES = (1e-3, 1.0, 1e3)

#: Largest relative deviation of a force from linearity that counts as round-off.
ROUND_OFF = 1e-9

#: Names of explicit schemes that may also give the reference: their order is high, and their steps solve no equations.
#: If the problem fits none of them, these implicit schemes of different families take their place.
WITNESSES, IMPLICIT_WITNESSES = ("rk4", "nystrom4"), ("esdirk4", "generalized_alpha")


@dataclass(frozen=True)
class _Runs:
    """The runs of a problem, in the form that a :class:`study.Program` requires."""

    problem: Problem
    schemes: Mapping[str, Scheme]
    duration: float
    quantities: list[Quantity]
    source: str = field(init=False)

    #: True makes :class:`study.Program` use threads, which suffice because compiled marches run concurrently.
    starts_a_process = True

    def __post_init__(self):
        """Set ``source`` to a digest of the traced equation, the schemes, the reductions, and values at several states.

        The values are u₀, u̇₀, and the terms of the equation and the quantities at states of several sizes. They
        distinguish equations that differ only in numbers.
        """

        def evaluate(t, u, v):
            terms = self.problem.at_time(t).internal_force(u, v), load(self.problem, t), self.problem.momentum(v)
            damping = 0.0 if self.problem.damping is None else times(self.problem.damping, v)
            return terms, damping, [quantity.value(self.problem, t, u, v) for quantity in self.quantities]

        start = self.problem.u0, self.problem.v0
        options = self.schemes, [quantity.reduce for quantity in self.quantities]
        digest = hashlib.sha256(f"{jax.make_jaxpr(evaluate)(0.0, *start).jaxpr} {options}".encode())
        values = [start, *(jax.jit(evaluate)(0.5 * self.duration, *sample) for sample in _states(self.problem))]
        for numbers in jax.tree.leaves(values):
            digest.update(np.asarray(numbers).tobytes())
        object.__setattr__(self, "source", digest.hexdigest())

    @property
    def title(self) -> str:
        """Title of the problem."""
        return self.problem.title

    def __call__(self, scheme: str, dt: float) -> dict[str, np.ndarray]:
        """Times and quantities of a run; a reduced quantity is constant along time.

        A final value is that at the end of the duration, by a cubic through the last steps, because the last step may
        end before it.
        """
        from scipy.interpolate import BarycentricInterpolator  # imported here, because only large problems need it

        steps = int(np.floor(self.duration / dt * (1 + 1e-9)))
        observe = [
            replace(quantity, reduce=None) if quantity.reduce == "final" else quantity for quantity in self.quantities
        ]
        options: dict[str, Any] = {"dt": dt, "steps": steps, "observe": observe}
        ds = sweep(self.problem, self.schemes[scheme], **options)
        if ds.status.item():  # the run once more, which raises an error with the cause of the failure
            run(self.problem, self.schemes[scheme], **options, on_failure="raise")
        result: dict[str, np.ndarray] = {"t": dt * np.arange(steps + 1)}
        for quantity in self.quantities:
            value = ds[quantity.name].values
            if quantity.reduce == "final":
                value = np.asarray(BarycentricInterpolator(result["t"][-4:], value[-4:])(self.duration))
            result[quantity.name] = np.broadcast_to(value, (steps + 1, *value.shape)) if quantity.reduce else value
        return result


def _states(problem: Problem) -> list[np.ndarray]:
    """Random displacements and velocities of several sizes."""
    random = np.random.default_rng(0)
    return [size * random.standard_normal((2, np.size(problem.u0))) for size in SIZES]


def _not_linear(problem: Problem) -> np.ndarray:
    """Unknowns at which p(2u, 2v) − 2 p(u, v) + p(0, 0) exceeds round-off for random u and v."""

    @jax.jit
    def deviates(state):
        at_rest, once, twice = (problem.at_time(0.0).varying_force(*(factor * state)) for factor in (0, 1, 2))
        size = jnp.abs(twice) + 2 * jnp.abs(once) + jnp.abs(at_rest)
        return jnp.abs(twice - 2 * once + at_rest) > ROUND_OFF * size

    # both signs, because a stop acts only on one side
    both_sides = [deviates(sign * state) for state in _states(problem) for sign in (1, -1)]
    return np.flatnonzero(np.any(both_sides, axis=0))


def _spread(places: np.ndarray, count: int) -> np.ndarray:
    """At most ``count`` of the places, spread evenly."""
    return places[np.unique(np.linspace(0, len(places) - 1, min(count, len(places))).astype(int))]


def compared(problem: Problem) -> np.ndarray:
    """Up to ``SHOWN`` unknowns to compare: up to half of them where the force is not linear, the rest spread evenly.

    All of them have a mass: the velocity of an unknown without mass, and a multiplier, converge with lower orders.
    """
    mass = 1.0 if problem.mass is None else diagonal(problem.mass)
    eligible = np.flatnonzero(np.broadcast_to(np.asarray(mass) > 0, np.shape(problem.u0)))
    chosen = _spread(np.intersect1d(_not_linear(problem), eligible), SHOWN // 2)
    others = np.setdiff1d(eligible, chosen)
    return np.union1d(chosen, _spread(others, SHOWN - len(chosen)))


def program_of(
    problem: Problem,
    schemes: Mapping[str, Scheme],
    duration: float,
    quantities: Mapping[str, Quantity] | None,
    spacing: float | None,
) -> Program:
    """A problem as a program, with explicit schemes of high order as witnesses, or else implicit ones.

    Raises
    ------
    ValueError
        If a final value or a root mean square is to be relative to the peak, which its runs do not return.
    """
    if quantities is None:
        unknowns = compared(problem)
        quantities = {"displacement": Quantity(lambda u: u[unknowns]), "velocity": Quantity(lambda v: v[unknowns])}
    for name, quantity in quantities.items():
        if quantity.scale == "peak" and quantity.reduce in ("final", "rms"):
            raise ValueError(
                f"the quantity '{name}' needs a number as scale, because '{problem.title}' has more than {FINDABLE:,} "
                "unknowns or one without mass, and its runs do not return the peak of a final value."
            )
    titles = {scheme.title for scheme in schemes.values()}

    def fitting(names):
        candidates = {name: schemes_by_name[name] for name in names}
        return {name: scheme for name, scheme in candidates.items() if not scheme.refusal(problem)}

    known = fitting(WITNESSES) or fitting(IMPLICIT_WITNESSES)
    witnesses = {name: scheme for name, scheme in known.items() if scheme.title not in titles}
    named = [replace(quantity, name=name, long_name=name) for name, quantity in quantities.items()]
    runs = _Runs(problem, witnesses | dict(schemes), duration, named)
    return Program(runs, list(schemes), duration, spacing=spacing, witnesses=list(witnesses))


def assess_large(question: Question, progress: Progress) -> xr.Dataset:
    """Result of :func:`study.assess` for a problem that is assessed like a program.

    Raises
    ------
    ValueError
        If a controller is given; also as :func:`program_of` and
        :func:`study.assessment.program.assess_program`.
    """
    problem = question.problem
    if question.controller is not None:
        raise ValueError(
            f"controlled steps are assessed for up to {FINDABLE:,} unknowns, all with a mass; leave controller out."
        )
    program = program_of(problem, question.fit, question.duration, question.given, question.spacing)
    ds = assess_program(program, question.allowed, question.seconds, progress.report)
    remarks = [*question.remarks]
    if any(quantity.reduce in ("peak", "rms") for quantity in question.quantities.values()):
        remarks.append(
            "peaks and root mean squares are compared with those of the whole duration, also if the last step of a run "
            "ends before it"
        )
    remarks += [ds.attrs["remarks"]] if ds.attrs["remarks"] else []
    ds.attrs |= {"model": "\n".join(question.model), "asked_for": "; ".join(question.own_schemes)}
    ds.attrs |= {"remarks": "; ".join(remarks)} | record_of(problem.load)
    if question.given is None and np.size(problem.u0) > SHOWN:
        compared_unknowns = f"{SHOWN} of {np.size(problem.u0):,} unknowns"
        ds.attrs["starts"] += f" Errors were compared at {compared_unknowns}; others may have larger ones."
    return ds
