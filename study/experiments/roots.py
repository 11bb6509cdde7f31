"""Roots of the effective equation of a large step, and the root that Newton's iteration finds.

The equation is u + κΔt² p(u) = ũ with the predictor ũ. Which of several roots is found depends on where the iteration
starts and on its tolerance.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import cast

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr

from study.algebra.jit import jit
from study.analysis.effective_equation import effective_coefficient, number_of_roots, unique_up_to
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Numbers, RecordedSteps, Schemes, Size, Spring, StepSizes, Tolerances
from study.experiments import coordinates
from study.marching.run import sweep
from study.mechanics.balance import balance, load
from study.mechanics.definition import Problem
from study.problem.named import problems as problems_by_name
from study.scheme.named import schemes as schemes_by_name
from study.scheme.newmark import Newmark

#: Difference of displacements at which two runs count as parted.
PARTED = 0.1
#: Starts of Newton's iteration, as factors of the acceleration before the step.
GUESSES = {"last_acceleration": 1.0, "none": 0.0}


@partial(jit, compiler=eqx.filter_jit)
def _newton(problem: Problem, coefficient, predictor, guess):
    """Displacement that Newton's iteration finds, and number of iterations, each (guesses, predictors).

    The displacement is NaN if the iteration does not converge.
    """

    def one(predictor, guess):
        a, effort = balance(
            problem, 0.0, predictor, jnp.zeros(()), coefficient, 0.0, guess=(guess - predictor) / coefficient
        )
        found = predictor + coefficient * a
        return jnp.where(effort.converged, found, jnp.nan), effort.iterations

    return jax.vmap(jax.vmap(one, (0, None)), (None, 0))(predictor, guess)


class _Inexact(Newmark):
    """Newmark's method with a choice of tolerance and start of Newton's iteration.

    Attributes
    ----------
    tolerance
        Relative tolerance of the iteration.
    part_of_last
        Factor by which the acceleration before the step is multiplied to start the iteration.
    """

    tolerance: float = 1e-12
    part_of_last: float = 1.0

    def new_acceleration(self, problem, t, u, v, c_u, c_v, guess):
        """New acceleration and effort; the iteration starts at a multiple of the last acceleration."""
        return balance(problem, load(problem, t), u, v, c_u, c_v, self.part_of_last * guess, tolerance=self.tolerance)


def _steps_together(problem: str, dt: np.ndarray, steps: int, tolerances: Sequence[float]) -> np.ndarray:
    """Number of steps until a run parts from the run with Newmark's own tolerance, (starts, tolerances, step sizes).

    The number is ``steps`` if the run never parts.
    """
    newmark = cast(Newmark, schemes_by_name["average_acceleration"])
    inexact = partial(_Inexact, beta=newmark.beta, gamma=newmark.gamma)
    exact = sweep(problem, newmark, dt=dt, steps=steps).u.values
    together = np.empty((len(GUESSES), len(tolerances), len(dt)), int)
    for g, part in enumerate(GUESSES.values()):
        for k, tolerance in enumerate(tolerances):
            u = sweep(
                problem,
                inexact(tolerance=np.float64(tolerance), part_of_last=np.float64(part)),
                dt=dt,
                steps=steps,
            ).u
            parted = ~(np.abs(u.values - exact) < PARTED)
            together[g, k] = np.where(parted.any(axis=1), parted.argmax(axis=1), steps)
    return together


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse schemes whose step is not one effective equation."""
    for name in options["schemes"]:
        try:
            effective_coefficient(schemes_by_name[name])
        except ValueError as error:
            return f"schemes: {error}"
    return None


@experiment("stability/roots", check=_check)
def roots(
    problem: Spring,
    schemes: Schemes,
    dt: StepSizes,
    predictor: Numbers,
    paper_step_size: Size,
    tolerances: Tolerances,
    steps: RecordedSteps,
) -> xr.Dataset:
    """Count the roots of the effective equation, and find the root at which Newton's iteration ends.

    A step of the schemes solves u + κΔt² p(u) = ũ, with the predictor ũ and the effective coefficient κ of the scheme.

    Parameters
    ----------
    schemes
        Schemes whose step is one effective equation.
    dt, predictor
        ``first``, ``last`` and ``count`` of the step sizes, and of the predictors ũ.
    paper_step_size
        Step size of Xie (1996), at which Newton's iteration is started from every guess.
    tolerances
        Tolerances of Newton's iteration in runs of the average acceleration method.
    steps
        Number of steps of these runs.

    Returns
    -------
    xarray.Dataset
        ``number_of_roots`` has the shape (scheme, step_size, predictor). ``root`` and ``newton_iterations`` have the
        shape (scheme, guess, predictor), and ``steps_together`` has the shape (start, newton_tolerance, dt).

    Raises
    ------
    ValueError
        If a step of a scheme is not one effective equation.
    """
    progress(f"roots of the effective equation of {problem}")
    definition = problems_by_name[problem]
    step_sizes, predictors = (np.linspace(one["first"], one["last"], int(one["count"])) for one in (dt, predictor))
    kappa = np.array([effective_coefficient(schemes_by_name[name]) for name in schemes])
    count = np.stack([number_of_roots(definition, k * step_sizes**2, predictors) for k in kappa])
    found, iterations = zip(
        *(map(np.asarray, _newton(definition, k * paper_step_size**2, predictors, predictors)) for k in kappa),
        strict=True,
    )
    along = ("scheme", "guess", "predictor")
    return xr.Dataset(
        {
            "number_of_roots": (
                ("scheme", "step_size", "predictor"),
                count.astype(np.int8),
                {"long_name": "number of roots of the effective equation", "units": "1"},
            ),
            "root": (
                along,
                np.stack(found),
                {"long_name": f"root that Newton's iteration finds at a step of {paper_step_size} s", "units": "1"},
            ),
            "newton_iterations": (
                along,
                np.stack(iterations).astype(np.int32),
                {"long_name": f"Newton iterations at a step size of {paper_step_size} s", "units": "1"},
            ),
            "effective_coefficient": (
                "scheme",
                kappa,
                {"long_name": "coefficient of the force in the effective equation over dt squared", "units": "1"},
            ),
            "steps_together": (
                ("start", "newton_tolerance", "step_size"),
                _steps_together(problem, step_sizes, steps, tolerances),
                {
                    "long_name": f"steps of the average acceleration method until a displacement differs by {PARTED} "
                    f"from the run of the finest tolerance, {steps} where it never does",
                    "units": "1",
                },
            ),
            "unique_up_to": (
                "scheme",
                [unique_up_to(definition, schemes_by_name[name], predictors) for name in schemes],
                {"long_name": "step size up to which the effective equation has one root", "units": "s"},
            ),
            "paper_step_size": ((), paper_step_size, {"long_name": "step size of the paper", "units": "s"}),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            "step_size": ("step_size", step_sizes, {"long_name": "step size", "units": "s"}),
            "predictor": ("predictor", predictors, {"long_name": "predictor of the displacement", "units": "1"}),
            "guess": ("guess", predictors, {"long_name": "first displacement of Newton's iteration", "units": "1"}),
            "start": ("start", list(GUESSES), {"long_name": "first acceleration of Newton's iteration"}),
            "newton_tolerance": (
                "newton_tolerance",
                list(tolerances),
                {"long_name": "tolerance of Newton's iteration", "units": "1"},
            ),
        },
        attrs={"title": f"Roots of the effective equation of the {definition.title}", "problem": problem},
    )
