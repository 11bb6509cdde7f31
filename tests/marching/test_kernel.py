"""Lanes that march in kernels are single runs, and the kernels are lowered for CUDA; JAX interprets them on a CPU."""

import contextlib
import logging
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.marching import equal_run, kernel, program
from study.marching.march import March
from study.marching.result import UNBOUNDED

#: Schemes of every kind: explicit, with stages, implicit, with sub-steps, with damping, of several steps.
SCHEMES = ("central_difference", "rk4", "average_acceleration", "bathe", "generalized_alpha", "houbolt")

#: Schemes whose kernels for three storeys would take long to compile.
REFUSED = ("extrapolation12", "gauss4", "kahan_li8")

RECORDS = [study.GroundMotion(np.random.default_rng(n).normal(size=n), dt) for n, dt in ((90, 0.02), (150, 0.01))]
ACCELERATIONS, SPACINGS = study.GroundMotion.padded(RECORDS)


@pytest.fixture
def refusals(caplog):
    """Messages of lanes that march without a kernel."""
    with caplog.at_level(logging.INFO, kernel.LOG.name):
        yield lambda: [record.message for record in caplog.records if record.name == kernel.LOG.name]


def _frame(scale=1.0):
    """Three storeys with cubic springs, full damping and a pulse of the ground."""
    mass, stiffness = np.full(3, 1e5), np.array([6e7, 5e7, 4e7])

    def force(u):
        drift = jnp.diff(u, prepend=jnp.zeros(1))
        shear = stiffness * drift * (1 + 20 * drift * drift)
        return shear - jnp.concatenate([shear[1:], jnp.zeros(1)])

    def load(t):
        return -3 * scale * jnp.asarray(mass) * jnp.sin(7 * t) * jnp.exp(-((t - 0.3) ** 2))

    def potential(u):
        drift = jnp.diff(u, prepend=jnp.zeros(1))
        return jnp.sum(stiffness * drift * drift * (0.5 + 5 * drift * drift))

    damping = 1e4 + 1e5 * np.eye(3)
    return study.Problem(force, np.zeros(3), mass=mass, damping=damping, load=load, potential=potential)


def _by_number(record):
    record = record.astype(int)
    ground = study.GroundMotion(jnp.asarray(ACCELERATIONS)[record], jnp.asarray(SPACINGS)[record])
    return study.Problem(lambda u: 30 * jnp.sin(u), u0=0.1, ground=ground)


def _by_samples(record):
    return study.Problem(lambda u: 30 * jnp.sin(u), u0=0.1, ground=study.GroundMotion(record, 0.02))


def _interpolated(scale):
    times = jnp.linspace(0.0, 3.0, 150)
    load = jnp.asarray(ACCELERATIONS[1])
    return study.Problem(lambda u: 30 * u, u0=0.1, load=lambda t: scale * jnp.interp(t, times, load))


def _sliding(scale):
    def force(u, v, slip):
        stretch = jnp.clip(u - slip, -0.05, 0.05)
        return scale * (20 * u + 3 * (u - u[::-1])) + 60 * stretch + 0.5 * v * jnp.abs(v), u - stretch

    return study.Problem(force, np.array([0.3, -0.2]), history=np.zeros(2))


FAMILIES: dict[str, tuple[Any, dict[str, np.ndarray]]] = {
    "record by its number": (_by_number, {"record": np.array([0, 1, 1])}),
    "record by its samples": (_by_samples, {"record": ACCELERATIONS}),
    "load by jnp.interp": (_interpolated, {"scale": np.array([0.5, 1.0, 2.0])}),
    "velocity and history": (_sliding, {"scale": np.array([0.5, 1.0, 2.0])}),
}


def _check(monkeypatch, problem, scheme, tolerance=1e-12, **arguments):
    """Lanes in kernels have the results of the present lanes, whose values are returned."""
    monkeypatch.setattr(kernel, "is_chosen", lambda unknowns: False)
    right = study.run(problem, scheme, **arguments)
    monkeypatch.setattr(kernel, "is_chosen", lambda unknowns: True)
    monkeypatch.setattr(equal_run, "FEW", 0)
    ds = study.run(problem, scheme, **arguments)
    for name, value in right.data_vars.items():
        # An error of the energy is a difference of energies, divided by the energy.
        size = 1.0 if name == "max_energy_error" else np.nanmax(np.abs(value.values), initial=0.0)
        np.testing.assert_allclose(ds[name], value, rtol=0, atol=tolerance * size, err_msg=name)
    return right


@pytest.mark.slow
@pytest.mark.parametrize(
    "scheme",
    [
        *("central_difference", "average_acceleration", "houbolt"),
        *(pytest.param(scheme, marks=pytest.mark.exhaustive) for scheme in ("rk4", "bathe", "generalized_alpha")),
    ],
)
def test_one_mass_in_kernels_is_a_run(monkeypatch, refusals, scheme):
    observe = ["max_energy_error", "newton_iterations", "peak"]
    arguments = {"dt": 0.01, "u0": np.array([0.5, 1.0, 2.0]), "steps": np.array([20, 90, 70]), "observe": observe}
    assert (_check(monkeypatch, "softening", scheme, **arguments).max_energy_error > 0).all()
    assert refusals() == []


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["rk4", "generalized_alpha"])
def test_three_storeys_in_kernels_are_runs(monkeypatch, refusals, scheme):
    """A fault of kernels that appears with several unknowns only."""
    drift = study.Quantity(lambda u: u[2] - u[1], reduce="peak")
    right = _check(
        monkeypatch, _frame, scheme, over={"scale": np.array([0.5, 1.0, 2.0])}, dt=0.01, steps=70, observe=drift
    )
    assert (right.quantity > 1e-3).all() and refusals() == []


@pytest.mark.parametrize(
    "scheme", ["average_acceleration", pytest.param("central_difference", marks=pytest.mark.exhaustive)]
)
@pytest.mark.parametrize("family", FAMILIES)
def test_loads_by_tables_and_histories_in_kernels_are_runs(monkeypatch, refusals, family, scheme):
    """A table or a history that a kernel reads at a wrong place."""
    make, over = FAMILIES[family]
    peak = study.Quantity(lambda u: u, reduce="peak")
    _check(monkeypatch, make, scheme, over=over, dt=0.013, steps=90, observe=peak)
    assert refusals() == []


def test_failures_and_bounds_in_kernels_are_those_of_runs(monkeypatch):
    arguments = {"u0": np.linspace(0.5, 2.0, 5), "dt": [0.001, 0.9, 0.002, 0.5, 0.003], "steps": 100, "bound": 1.9}
    right = _check(monkeypatch, "hardening", "central_difference", observe="max_energy_error", **arguments)
    assert right.status.values.tolist() == [0, UNBOUNDED, 0, UNBOUNDED, UNBOUNDED]
    assert right.failed_at_step.values.tolist()[4] == 0 < right.failed_at_step[1]


@pytest.mark.slow
def test_newton_iterations_that_fail_in_kernels_start_again(monkeypatch, refusals):
    arguments = {"dt": 1.79 * np.array([0.1, 0.6, 0.9]), "steps": 30, "observe": "max_energy_error"}
    right = _check(monkeypatch, "softening_large", "average_acceleration", **arguments)
    assert right.newton_restarts.values.tolist()[0] == 0 < right.newton_restarts.values.max() and refusals() == []


@pytest.mark.slow
def test_records_and_pauses_in_kernels_are_those_of_runs(monkeypatch):
    """A march in kernels that loses a sample where it pauses."""
    monkeypatch.setattr(program, "PAUSE_OF_KERNELS", 17 * 64)
    arguments = {"u0": np.array([0.5, 1.0]), "dt": 0.02, "steps": 60, "every": 12, "observe": ["trajectory", "peak"]}
    _check(monkeypatch, "softening", "average_acceleration", **arguments)


def _operations(u, k):
    """Results of operations that move entries at an index which differs from lane to lane, and of those written out."""
    table = jnp.stack([jnp.arange(80.0), jnp.sin(jnp.arange(80.0)) + u[0]], axis=1)
    long = jnp.concatenate([jnp.flip(table[:, 1]), jnp.pad(u, (40, 40))]).reshape(1, -1)
    missing = jnp.where(u[0] > 0, u[0], jnp.nan)
    return [
        (u[k], u.at[1].set(3.0)[k], table[k], table.T[1, 3 * k], long[0, 60 * k], long[0][20 * k + jnp.arange(3)]),
        (u.at[60 * k].get(mode="fill"), table.at[100 * k, 1].get(mode="fill"), table[1:70:3][:, None][k]),
        (jax.lax.dynamic_update_slice(u, jnp.array([7.0]), (k,)), jax.lax.dynamic_slice(long[0], (900 * k,), (2,))),
        (jnp.maximum(missing, 0.3), jnp.minimum(0.3, missing), jnp.clip(missing, 0.1, 0.2), jnp.isfinite(missing)),
        (jax.lax.select_n(k, u, 2 * u, 3 * u), jax.lax.switch(k, [lambda: u, lambda: 2 * u, lambda: 3 * u])),
        jnp.searchsorted(table[:, 0], 20 * u),
        jnp.stack([long[0, :80], 2 * long[0, 80:160]], axis=1)[k, 0],
        [part[k] for part in jnp.split(table[:, 1], 2)],
        jnp.linspace(0, u[0], 200)[100 * k],
        (u / 3.0, u / 0.0, 1e-320 * u / 1e-320, k // 2),
        (jnp.argmax(u), jnp.argmax(jnp.sign(u)), jnp.argmax(jnp.stack([u, 1 / u, missing * u]), axis=0)),
    ]


def test_an_operation_in_a_kernel_is_that_of_whole_arrays(refusals):
    """A rule for one operation in a kernel that gives a wrong value or type, or an operation without a rule."""
    u, k = np.random.default_rng(0).normal(size=(131, 3)), np.arange(131) % 3  # more than a block
    right = jax.vmap(_operations)(u, k)
    begin = jax.tree.map(jnp.zeros_like, right)

    def step(number, results, others):
        return _operations(*others), number < 5

    result = kernel.advanced(step, begin, (jnp.asarray(u), jnp.asarray(k)), 0, 1, 64, interpret=True)
    assert refusals() == []
    for ours, theirs in zip(jax.tree.leaves(result), jax.tree.leaves(right), strict=True):
        assert ours.dtype == theirs.dtype
        np.testing.assert_allclose(ours, theirs, rtol=1e-13, atol=1e-13)


def test_what_has_no_kernel_marches_step_by_step_and_is_logged(monkeypatch, refusals):
    """An operation that no kernel can have and that ends the run."""
    problem = study.Problem(lambda u: 20 * jnp.sort(u), np.zeros(2))
    _check(monkeypatch, problem, "rk4", u0=np.array([[0.5, 0.2], [0.2, 0.3]]), dt=0.01, steps=5, observe="peak")
    assert refusals() == ["Lanes march step by step on the GPU, because a kernel has no rule for the operation 'sort'."]


def test_many_unknowns_and_controlled_steps_are_logged(monkeypatch, refusals):
    monkeypatch.setattr(kernel.jax, "default_backend", lambda: "cpu")
    study.run("hardening", "rk4", u0=[1.0, 1.1], tolerance=1e-3, duration=0.1, observe="peak")
    assert refusals() == [] and not kernel.is_chosen(1)
    monkeypatch.setattr(kernel.jax, "default_backend", lambda: "gpu")
    assert kernel.is_chosen(8) and not kernel.is_chosen(9)
    study.run("hardening", "rk4", u0=[1.0, 1.1], tolerance=1e-3, duration=0.1, observe="peak")
    reasons = "takes at most 8 unknowns", "takes equal steps only"
    assert refusals() == [f"Lanes march step by step on the GPU, because a kernel {reason}." for reason in reasons]


def test_a_kernel_that_xla_refuses_is_not_compiled_again(monkeypatch, refusals):
    calls = []

    def refused(*arguments):
        calls.append(arguments)
        raise jax.errors.JaxRuntimeError("INTERNAL: out of registers\nmore")

    monkeypatch.setattr(kernel, "advanced", refused)
    arguments = {"u0": np.array([0.5, 0.7]), "dt": 0.01, "steps": 7, "observe": "max_energy_error"}
    for _ in range(2):
        _check(monkeypatch, "hardening", "rk4", **arguments)
    assert len(calls) == 1
    (message,) = refusals()
    assert message.endswith("because a kernel is refused: JaxRuntimeError: INTERNAL: out of registers.")


@pytest.mark.exhaustive
def test_kernels_of_every_scheme_are_runs(monkeypatch, refusals, scheme_name):
    """A formula of a scheme with another value in a kernel; on a GPU, a fault of the compiler."""
    observe = ["max_energy_error", "peak"]
    _check(monkeypatch, "softening", scheme_name, u0=np.array([0.5, 1.0, 2.0]), dt=0.01, steps=30, observe=observe)
    assert refusals() == []


@pytest.mark.exhaustive
def test_kernels_of_several_unknowns_are_runs(monkeypatch, refusals, kind):
    """As above, with a system of equations; parameters of a scheme change numbers only."""
    _check(monkeypatch, _frame, kind, over={"scale": np.array([0.5, 2.0])}, dt=0.01, steps=30, observe="peak")
    assert all("takes long to compile" in message for message in refusals())
    assert bool(refusals()) == (kind in REFUSED)


def _device():
    """A context in which recent versions of JAX lower for a GPU that is not there."""
    if tuple(int(n) for n in jax.__version__.split(".")[:2]) < (0, 11):
        return contextlib.nullcontext()
    device = jax.sharding.AbstractDevice(device_kind="NVIDIA H100 80GB HBM3", num_cores=132, platform="gpu")
    return jax.sharding.use_abstract_mesh(jax.sharding.AbstractMesh((), (), abstract_device=device))


def _lowered(monkeypatch, problem, scheme, observe, lanes=256):
    """Text of the program for CUDA of lanes in kernels."""
    monkeypatch.setattr(kernel, "is_chosen", lambda unknowns: True)
    march = March.of(problem, study.schemes[scheme], [study.observers[observe]], lanes=True, bound=1e3)
    # neither interpreted, as on a CPU, nor compiled
    monkeypatch.setattr(kernel.jax, "default_backend", lambda: "gpu")

    def after(u0, v0, dt, until):
        progress, initial, stored = march.start(u0, v0, dt, 1)
        return march.proceed(progress, stored, initial, dt, until, 1, 0, False)[0]

    starts = jax.ShapeDtypeStruct((lanes, *np.shape(problem.u0)), float)
    with _device():
        traced = jax.jit(after).trace(starts, starts, jax.ShapeDtypeStruct((), float), jax.ShapeDtypeStruct((), int))
        return traced.lower(lowering_platforms=("cuda",)).as_text()


@pytest.mark.slow
@pytest.mark.parametrize("scheme", SCHEMES)
def test_kernels_of_one_mass_are_lowered_for_cuda(monkeypatch, refusals, scheme):
    text = _lowered(monkeypatch, study.problems["softening"], scheme, "max_energy_error")
    assert "triton" in text and refusals() == []


@pytest.mark.parametrize("family", FAMILIES)
def test_kernels_with_tables_are_lowered_for_cuda(monkeypatch, refusals, family):
    make, over = FAMILIES[family]
    first = {name: jnp.asarray(value[0]) for name, value in over.items()}
    assert "triton" in _lowered(monkeypatch, make(**first), "average_acceleration", "peak") and refusals() == []


@pytest.mark.exhaustive
def test_kernels_of_every_scheme_are_lowered_for_cuda(monkeypatch, refusals, scheme_name):
    """An operation of a scheme that works interpreted and that the compiler for CUDA refuses."""
    assert "triton" in _lowered(monkeypatch, study.problems["hardening"], scheme_name, "max_energy_error")
    assert ("triton" in _lowered(monkeypatch, _frame(), scheme_name, "peak")) == (scheme_name not in REFUSED)
    assert all("takes long to compile" in message for message in refusals())
