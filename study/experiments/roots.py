"""Which of several roots? The effective equation of a large step, and what Newton's start and tolerance make of it."""

from collections.abc import Sequence
from functools import partial
from typing import Annotated, cast

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from annotated_types import Len

from study.analysis.effective_equation import effective_coefficient, number_of_roots, unique_up_to
from study.equilibrium.balance import balance, load
from study.marching.run import run
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Numbers, RecordedSteps, Schemes, Size, Spring, Tolerances
from study.problem.definition import Problem
from study.problem.named import problems
from study.scheme.named import schemes as registry
from study.scheme.newmark import Newmark

#: Runs that differ by so much in displacement no longer answer the same question.
PARTED = 0.1
#: Where Newton's iteration may start: from the acceleration before the step, or from none.
GUESSES = {"last_acceleration": 1.0, "none": 0.0}


@eqx.filter_jit
def _newton(problem: Problem, coefficient, predictor, guess):
    """Displacement that Newton finds from each guess of it, and in how many iterations."""

    def one(predictor, guess):
        a, effort = balance(
            problem, 0.0, predictor, jnp.zeros(()), coefficient, 0.0, guess=(guess - predictor) / coefficient
        )
        found = predictor + coefficient * a
        return jnp.where(effort.converged, found, jnp.nan), effort.iterations

    return jax.vmap(jax.vmap(one, (0, None)), (None, 0))(predictor, guess)


class _Inexact(Newmark):
    """Newmark's method with a choice of where Newton's iteration starts and ends."""

    tolerance: float = eqx.field(default=1e-12, kw_only=True)
    part_of_last: float = eqx.field(default=1.0, kw_only=True)

    def new_acceleration(self, problem, t, u, v, c_u, c_v, guess):
        """Newton's iteration from a part of the last acceleration to the tolerance."""
        return balance(problem, load(problem, t), u, v, c_u, c_v, self.part_of_last * guess, tolerance=self.tolerance)


def _steps_together(problem: str, dt: np.ndarray, steps: int, tolerances: Sequence[float]) -> np.ndarray:
    """Steps until a run leaves that of the finest tolerance, (guesses, tolerances, step sizes); ``steps`` if never."""
    newmark = cast(Newmark, registry["average_acceleration"])
    inexact = partial(_Inexact, newmark.beta, newmark.gamma)
    exact = run(problem, newmark, dt=dt, steps=steps).u.values
    together = np.empty((len(GUESSES), len(tolerances), len(dt)), int)
    for g, part in enumerate(GUESSES.values()):
        for k, tolerance in enumerate(tolerances):
            u = run(
                problem, inexact(tolerance=np.float64(tolerance), part_of_last=np.float64(part)), dt=dt, steps=steps
            ).u
            parted = ~(np.abs(u.values - exact) < PARTED)
            together[g, k] = np.where(parted.any(axis=1), parted.argmax(axis=1), steps)
    return together


def _no_equation(o, c) -> str | None:
    for name in o["schemes"]:
        try:
            effective_coefficient(registry[name])
        except ValueError as error:
            return f"schemes: {error}"
    if o["dt"]["first"] <= 0:
        return f"dt: first must be greater than zero, not {o['dt']['first']}."
    return None


@experiment(
    "stability/roots",
    check=_no_equation,
    values=lambda o, c: 3 * o["dt"]["count"] * o["steps"] + 4001 * o["dt"]["count"] * o["predictor"]["count"],
    steps=lambda o, c: o["dt"]["count"] * o["steps"] * (1 + len(GUESSES) * len(o["tolerances"])),
)
def roots(
    problem: Spring,
    schemes: Schemes,
    dt: Numbers,
    predictor: Numbers,
    paper_dt: Size,
    tolerances: Annotated[Tolerances, Len(3, 3)],
    steps: RecordedSteps,
) -> xr.Dataset:
    """Number of roots over step size and predictor, Newton's choice at one step size, and how long tolerances agree.

    Parameters
    ----------
    schemes
        Those with a single effective equation a step.
    dt, predictor
        ``first``, ``last`` and ``count`` of the step sizes, and of the predictors ũ.
    paper_dt
        Step size at which Newton's choice is looked at.
    tolerances, steps
        Of Newton in the average acceleration method, and how long its runs are.
    """
    progress(f"roots of the effective equation of {problem}")
    definition = problems[problem]
    step_sizes, predictors = (np.linspace(one["first"], one["last"], int(one["count"])) for one in (dt, predictor))
    kappa = np.array([effective_coefficient(registry[name]) for name in schemes])
    count = np.stack([number_of_roots(definition, k * step_sizes**2, predictors) for k in kappa])
    found, iterations = zip(
        *(map(np.asarray, _newton(definition, k * paper_dt**2, predictors, predictors)) for k in kappa), strict=True
    )
    along = ("scheme", "guess", "predictor")
    return xr.Dataset(
        {
            "number_of_roots": (
                ("scheme", "dt", "predictor"),
                count.astype(np.int8),
                {"long_name": "number of roots of the effective equation", "units": "1"},
            ),
            "root": (
                along,
                np.stack(found),
                {"long_name": f"displacement that Newton finds at a step size of {paper_dt} s", "units": "1"},
            ),
            "newton_iterations": (
                along,
                np.stack(iterations).astype(np.int32),
                {"long_name": f"Newton iterations at a step size of {paper_dt} s", "units": "1"},
            ),
            "effective_coefficient": (
                "scheme",
                kappa,
                {"long_name": "coefficient of the force in the effective equation over dt squared", "units": "1"},
            ),
            "steps_together": (
                ("start", "newton_tolerance", "dt"),
                _steps_together(problem, step_sizes, steps, tolerances),
                {
                    "long_name": f"steps of the average acceleration method until a displacement differs by {PARTED} "
                    f"from that of the finest tolerance, {steps} where it never does",
                    "units": "1",
                },
            ),
            "unique_up_to": (
                "scheme",
                [unique_up_to(definition, registry[name], predictors) for name in schemes],
                {"long_name": "step size up to which the effective equation has one root", "units": "s"},
            ),
            "paper_dt": ((), paper_dt, {"long_name": "step size of the paper", "units": "s"}),
        },
        coords={
            **labels.scheme_coordinates(schemes),
            "dt": ("dt", step_sizes, {"long_name": "step size", "units": "s"}),
            "predictor": ("predictor", predictors, {"long_name": "predictor of the displacement", "units": "1"}),
            "guess": ("guess", predictors, {"long_name": "displacement at which Newton starts", "units": "1"}),
            "start": ("start", list(GUESSES), {"long_name": "acceleration at which Newton starts"}),
            "newton_tolerance": (
                "newton_tolerance",
                list(tolerances),
                {"long_name": "tolerance of Newton", "units": "1"},
            ),
        },
        attrs={"title": f"Roots of the effective equation of the {definition.title}", "problem": problem},
    )
