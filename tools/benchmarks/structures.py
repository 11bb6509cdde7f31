"""Structures: the cost of an unknown and of a Newton iteration."""

from collections.abc import Callable, Iterator

import jax.numpy as jnp
import numpy as np
from case import STEPS, Case, example, step_size, timed
from scipy import sparse
from scipy.linalg import get_lapack_funcs, solve_banded, solveh_banded
from scipy.sparse.linalg import splu

import study
from study.marching.timing import Timed
from study.problem import chains


def cases() -> Iterator[Case]:
    """All timed cases of structures."""
    yield from few_unknowns()
    yield from long_bars()
    yield from full_tangent()
    yield from sparse_plates()


def few_unknowns() -> Iterator[Case]:
    """Runs with two to three unknowns compared with runs with one unknown."""
    single = Timed(study.problems["hardening"], study.schemes["average_acceleration"], ())
    row = study.Problem(
        lambda u: jnp.stack([2 * u[0] - u[1], 2 * u[1] - u[0] - u[2], u[2] - u[1]]),
        u0=np.array([1.0, 0.5, 0.2]),
        title="three masses in a row",
    )
    for problem, dt in (
        (study.problems["stiff_soft"], 0.2618),
        (study.problems["stiff_soft_sine"], 0.2618),
        (row, 0.1),
        (chains.toda_chain(3), 0.1),
    ):
        several = Timed(problem, study.schemes["average_acceleration"], ())
        yield Case(
            f"average acceleration, {problem.title}, {len(problem.u0)} unknowns : hardening spring, one",
            lambda several=several, dt=dt: several.run(dt, STEPS)[0],
            lambda: single.run(step_size("hardening"), STEPS)[0],
            6.0,
            STEPS,
        )


def _iterations(problem, dt, steps) -> tuple[Callable[[], float], int]:
    """A function that makes a run and returns its seconds; and the number of Newton iterations of the run."""
    options = {"dt": dt, "steps": steps, "observe": ["newton_iterations"]}
    iterations = study.run(problem, "average_acceleration", **options).newton_iterations.item()
    return (lambda: timed(lambda: study.run(problem, "average_acceleration", **options))), int(iterations)


def long_bars() -> Iterator[Case]:
    """A Newton iteration on a bar compared with LAPACK's solution alone, of a system of the same size and form."""
    for n in (1_000, 10_000, 100_000, 1_000_000):
        bar = chains.impact_bar(n)
        ours, iterations = _iterations(bar, 1 / n, max(10, 1_000_000 // n))
        bands = np.array([np.full(n, -1.0), np.full(n, 4.0), np.full(n, -1.0)])
        # the baseline is one call of LAPACK's gtsv, which pivots, for every Newton iteration
        yield Case(
            f"bar of {n:,}, an unknown and iteration : LAPACK's tridiagonal solution",
            ours,
            lambda bands=bands, n=n, iterations=iterations: (
                iterations * timed(lambda: solve_banded((1, 1), bands, np.ones(n)))
            ),
            2.0,
            n * iterations,
        )


def full_tangent() -> Iterator[Case]:
    """A Newton iteration with a full tangent of a hundred unknowns compared with LAPACK's solution alone."""
    n = 100
    chain = chains.toda_chain(n)
    full = study.Problem(chain.force, chain.u0, chain.v0, tangent="dense", title="full chain")
    ours, iterations = _iterations(full, 0.1, 2_000)
    matrix = np.eye(n) + 0.01 * np.random.default_rng(0).normal(size=(n, n))
    gesv = get_lapack_funcs("gesv", [matrix])
    yield Case(
        f"{n} unknowns with a full tangent, an iteration : LAPACK's solution",
        ours,
        lambda: iterations / 100 * timed(lambda: [gesv(matrix, np.ones(n)) for _ in range(100)]),
        1.5,
        iterations,
    )


def sparse_plates() -> Iterator[Case]:
    """A Newton iteration on plates with few stops compared with SciPy's solution of its linear system alone."""
    dt = 5e-5
    for size, steps, baseline, solver, target in (
        ((100, 9), 200, "solveh_banded", _by_band, 1.4),
        ((100, 99), 20, "splu", _by_superlu, 0.5),
    ):
        plate = example("plate").cantilever(*size)
        ours, iterations = _iterations(plate, dt, steps)
        solve = solver(sparse.csc_array(sparse.diags_array(4 / dt**2 * plate.mass) + _as_sparse(plate.stiffness)))
        rhs = np.ones(len(plate.u0))
        yield Case(
            f"plate of {len(rhs):,} unknowns, an iteration : SciPy's {baseline}",
            ours,
            lambda solve=solve, rhs=rhs, iterations=iterations: (
                iterations / 10 * timed(lambda: [solve(rhs) for _ in range(10)])
            ),
            target,
            iterations,
        )


def _by_superlu(matrix) -> Callable:
    """Function that factorises a sparse matrix and solves with it, by SciPy."""
    return lambda rhs: splu(matrix).solve(rhs)


def _as_sparse(matrix) -> sparse.csc_array:
    """Convert a symmetric matrix of the study, which stores one triangle, to SciPy."""
    pattern = matrix.pattern
    lower = sparse.csc_array((matrix.values, (pattern.rows, pattern.columns)))
    return sparse.csc_array(lower + sparse.tril(lower, -1).T)


def _by_band(matrix) -> Callable:
    """Function that solves with a symmetric band matrix, by SciPy."""
    width = int(np.abs(np.subtract(*matrix.nonzero())).max())
    bands = np.stack([np.pad(matrix.diagonal(-d), (0, d)) for d in range(width + 1)])
    return lambda rhs: solveh_banded(bands, rhs, lower=True)
