"""Lanes that march component by component are single runs."""

import logging
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.marching import components, equal_run
from study.marching.ensemble import FEW

RECORD = np.random.default_rng(1).normal(size=300)


def _chain(n, **more):
    stiffness = np.linspace(40.0, 90.0, n)

    def force(u):
        ends = jnp.zeros(1, u.dtype)
        stretch = jnp.diff(u, prepend=ends)
        pull = jnp.asarray(stiffness, u.dtype) * stretch * (1 + 2 * stretch * stretch)
        return pull - jnp.concatenate([pull[1:], ends])

    def potential(u):
        stretch = jnp.diff(u, prepend=jnp.zeros(1, u.dtype))
        return jnp.sum(jnp.asarray(stiffness, u.dtype) * (stretch**2 + stretch**4) / 2)

    return study.Problem(force, np.zeros(n), mass=np.linspace(1.0, 2.0, n), potential=potential, **more)


def _coupled(u):
    return 20 * u + 3 * (u - u[::-1])


def _sliding(u, v, slip):
    new = jnp.clip(u, slip - 0.05, slip + 0.05)
    return _coupled(u) + 60 * (u - new), new


#: Functions without arguments that make problems, by what is special about them.
PROBLEMS = {
    "dense with full damping and a load": lambda: _chain(
        3, damping=0.1 + 0.2 * np.eye(3), load=lambda t: 3 * jnp.sin(2 * t) * jnp.ones(3)
    ),
    "tridiagonal": lambda: _chain(8, tangent="tridiagonal", damping=np.full(8, 0.1)),
    "record": lambda: _chain(
        2, load=lambda t: jnp.interp(t, jnp.linspace(0.0, 6.0, 300), jnp.asarray(RECORD)) * jnp.ones(2)
    ),
    "contact": lambda: study.Problem(lambda u: _coupled(u) + jnp.where(u > 0.05, 500 * (u - 0.05), 0.0), np.zeros(2)),
    "velocity": lambda: study.Problem(lambda u, v: _coupled(u) + 0.5 * v * jnp.abs(v), np.zeros(2)),
    "history": lambda: study.Problem(_sliding, np.zeros(2), history=np.zeros(2)),
}


@cache
def _problem(name):
    return PROBLEMS[name]()


def _check_lanes(monkeypatch, name, scheme, dt=0.02, tolerance=1e-9, **more):
    """Five lanes by components and one by one have the same results."""
    problem = _problem(name)
    n = len(problem.u0)
    u0 = np.linspace(-0.2, 0.3, 5)[:, None] * np.linspace(1, 2, n)
    observe = ["trajectory", "newton_iterations", "effort"]
    arguments = {"u0": u0, "v0": 5 * u0[::-1], "dt": dt, "steps": 12, "observe": observe} | more
    one_by_one = study.run(problem, scheme, **arguments)
    assert (one_by_one.status == 0).all() and np.abs(one_by_one.u.diff("t" if np.ndim(dt) == 0 else "sample")).max() > 0
    monkeypatch.setattr(equal_run, "FEW", 0)
    monkeypatch.setattr(components, "together", None)  # nothing but the start is mapped by jax.vmap
    lanes = study.run(problem, scheme, **arguments)
    for variable in one_by_one.data_vars:
        size = np.nanmax(np.abs(one_by_one[variable].values))
        np.testing.assert_allclose(
            lanes[variable], one_by_one[variable], rtol=0, atol=tolerance * size, err_msg=variable
        )


@pytest.mark.slow
def test_every_scheme_by_components_is_a_single_run(monkeypatch, sampled_kind):
    """An operation of one scheme that is wrong for lanes of several unknowns only."""
    _check_lanes(monkeypatch, "dense with full damping and a load", sampled_kind)


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize(
    "scheme", ["average_acceleration", pytest.param("central_difference", marks=pytest.mark.exhaustive)]
)
def test_every_kind_of_problem_by_components_is_a_single_run(monkeypatch, problem, scheme):
    _check_lanes(monkeypatch, problem, scheme, dt=np.linspace(0.01, 0.02, 5))


@pytest.mark.slow
def test_components_keep_single_precision(monkeypatch):
    _problem("contact")  # is made in double precision
    with jax.enable_x64(False):
        observe = ["trajectory"]
        _check_lanes(monkeypatch, "contact", "average_acceleration", tolerance=1e-5, observe=observe)


@pytest.mark.slow
def test_every_observer_observes_components(caplog):
    """A single observer with an operation that has no rule would slow all lanes down."""
    problem = _problem("dense with full damping and a load")
    named = [name for name, observer in study.observers.items() if not observer.refusal(problem)]
    assert {"peak", "energy_balance", "lyapunov_exponent", "oscillations", "internal_force"} <= set(named)
    with caplog.at_level(logging.INFO, components.LOG.name):
        study.run(problem, "average_acceleration", dt=0.02, steps=2, u0=np.ones((FEW + 1, 3)), observe=named)
    assert [record.message for record in caplog.records if record.name == components.LOG.name] == []


def _operations(u, k):
    """Results of operations of every kind, on u (3,) and an index that all lanes share."""
    square = jnp.outer(u, 2 * u)
    last = jnp.asarray(u[0] > 0, int)
    return [
        [jnp.full(2, -x) for x in u],
        (u[k], u[last], u[::-1], u[jnp.array([2, 1])], u.at[1].set(3.0), u.at[jnp.array([0, 2])].set(u[1:])),
        (u.at[7].get(mode="fill"), jnp.roll(u, 1), jnp.pad(u, 2), jax.lax.pad(u, 0.0, [(-1, 2, 1)]), jnp.stack([u, u])),
        (jnp.cumsum(u), jnp.flip(jnp.cumsum(u[::-1])), u.max(), jnp.all(u > 0), jnp.prod(u), u @ u, square @ u),
        jnp.einsum("ijk,kjl->jil", jnp.arange(12.0).reshape(2, 2, 3), jnp.arange(12.0).reshape(3, 2, 2) * u[1]),
        jax.lax.while_loop(lambda c: c[0] < 3 * u[0], lambda c: (c[0] + 1, c[1] * u), (0.0, u)),
        jax.lax.while_loop(lambda c: c[0] < k, lambda c: (c[0] + 1, c[1] * u), (0, u)),
        jax.lax.cond(u[0] > 0, lambda: u, lambda: 2 * u),
        jax.lax.switch(k, [lambda: u, lambda: 2 * u, lambda: 3 * u]),
        jax.lax.fori_loop(0, 4, lambda i, x: x.at[i % 3].set(x[(i + 1) % 3] + u[i % 3]), u),
        jax.lax.scan(lambda c, x: (c + x, c * x), u[0], u, reverse=True),
        jnp.interp(u[0], jnp.arange(200.0), jnp.sin(jnp.arange(200.0))),
        (jnp.sum(jnp.arange(200.0) * u[0]), jnp.linspace(0, u[0], 200)[7:9], jnp.zeros((0, 2)) * u[0], k),
        (jnp.copysign(u, -u[0]), jnp.sort(u), jnp.argmax(u), jax.lax.bitcast_convert_type(u, jnp.uint32)),
        (jax.jacfwd(lambda x: x**3)(u), jax.grad(lambda x: jnp.sum(x**3))(u), jnp.triu(square), square[None].T),
    ]


@pytest.mark.parametrize("function", [_operations, lambda u, k: jnp.linalg.qr(jnp.diag(u + 3))[1]])
def test_an_operation_of_components_is_that_of_whole_arrays(function, caplog):
    u, k = np.random.default_rng(0).normal(size=(16, 3)), np.int64(1)
    with caplog.at_level(logging.INFO, components.LOG.name):
        result = jax.jit(lambda u: components.joined(components.each(function)(u, k)))(u)
    right = jax.jit(jax.vmap(function, (0, None)))(u, k)
    assert jax.tree.structure(result) == jax.tree.structure(right)  # type: ignore[operator]
    for ours, theirs in zip(jax.tree.leaves(result), jax.tree.leaves(right), strict=True):
        assert ours.dtype == theirs.dtype
        np.testing.assert_allclose(ours, theirs, rtol=1e-13, atol=1e-13)
    assert ["'qr'" in record.message for record in caplog.records] == [True] * (function is not _operations)
