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
from study.analysis.effective_equation import effective_coefficient, unique_up_to
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


@partial(jit, compiler=eqx.filter_jit)
def _newton(problem: Problem, coefficient, predictor, guess):
    """Displacement that Newton's iteration finds, (guesses, predictors); NaN if it does not converge."""

    def root(predictor, guess):
        a, effort = balance(
            problem, 0.0, predictor, jnp.zeros(()), coefficient, 0.0, guess=(guess - predictor) / coefficient
        )
        return jnp.where(effort.converged, predictor + coefficient * a, jnp.nan)

    return jax.vmap(jax.vmap(root, (0, None)), (None, 0))(predictor, guess)


class _Inexact(Newmark):
    """Newmark's method with a choice of the relative tolerance of Newton's iteration."""

    tolerance: float = 1e-12

    def new_acceleration(self, problem, t, u, v, c_u, c_v, guess):
        """New acceleration and effort; the iteration starts at the last acceleration."""
        return balance(problem, load(problem, t), u, v, c_u, c_v, guess, tolerance=self.tolerance)


def _steps_together(problem: str, dt: np.ndarray, steps: int, tolerances: Sequence[float]) -> np.ndarray:
    """Number of steps until a run parts from the run with Newmark's own tolerance, (tolerances, step sizes).

    The number is ``steps`` if the run never parts.
    """
    newmark = cast(Newmark, schemes_by_name["average_acceleration"])
    inexact = partial(_Inexact, beta=newmark.beta, gamma=newmark.gamma)
    exact = sweep(problem, newmark, dt=dt, steps=steps).u.values
    together = []
    for tolerance in tolerances:
        u = sweep(problem, inexact(tolerance=np.float64(tolerance)), dt=dt, steps=steps).u
        parted = ~(np.abs(u.values - exact) < PARTED)
        together.append(np.where(parted.any(axis=1), parted.argmax(axis=1), steps))
    return np.array(together)


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
    """Find the root of the effective equation at which Newton's iteration ends.

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
        ``root`` has the shape (scheme, guess, predictor), ``unique_up_to`` the shape (scheme,), and ``steps_together``
        the shape (newton_tolerance, step_size).

    Raises
    ------
    ValueError
        If a step of a scheme is not one effective equation.
    """
    progress(f"roots of the effective equation of {problem}")
    definition = problems_by_name[problem]
    step_sizes, predictors = (np.linspace(grid["first"], grid["last"], int(grid["count"])) for grid in (dt, predictor))
    kappa = np.array([effective_coefficient(schemes_by_name[name]) for name in schemes])
    roots_by_scheme = [np.asarray(_newton(definition, k * paper_step_size**2, predictors, predictors)) for k in kappa]
    return xr.Dataset(
        {
            "root": (
                ("scheme", "guess", "predictor"),
                np.stack(roots_by_scheme),
                {"long_name": f"root that Newton's iteration finds at a step of {paper_step_size} s", "units": "1"},
            ),
            "steps_together": (
                ("newton_tolerance", "step_size"),
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
            "newton_tolerance": (
                "newton_tolerance",
                list(tolerances),
                {"long_name": "tolerance of Newton's iteration", "units": "1"},
            ),
        },
        attrs={"title": f"Roots of the effective equation of the {definition.title}", "problem": problem},
    )
