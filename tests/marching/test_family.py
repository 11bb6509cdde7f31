"""Ensembles whose lanes differ in the arguments of a problem."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.sparse
from jax.experimental.sparse import BCOO

import study

PEAK = study.Quantity(lambda u: u, name="largest", reduce="peak")
END = study.Quantity(lambda u: u, name="end_u", reduce="final")


def _spring(stiffness, start=1.0):
    return study.Problem(lambda u: stiffness * u + u**3, u0=start, damping=0.1, title="spring")


@pytest.mark.slow
def test_every_lane_is_its_own_run():
    over = {"stiffness": np.linspace(1.0, 9.0, 70), "start": np.linspace(0.5, 2.0, 70)}
    ds = study.run(_spring, "average_acceleration", dt=0.05, steps=100, over=over, observe=["trajectory", PEAK])
    assert ds.u.dims == ("lane", "t") and ds.u.shape == (70, 101)
    np.testing.assert_array_equal(ds.stiffness, over["stiffness"])
    for lane in (0, 33, 69):
        problem = _spring(over["stiffness"][lane], over["start"][lane])
        alone = study.run(problem, "average_acceleration", dt=0.05, steps=100, observe=["trajectory", PEAK])
        np.testing.assert_allclose(ds.u[lane], alone.u, atol=1e-13)
        assert float(ds.largest[lane]) == pytest.approx(float(alone.largest), abs=1e-13)


@pytest.mark.slow
def test_a_record_and_a_yield_force_vary():
    ground = study.GroundMotion.el_centro()

    def frame(intensity, strength):
        storeys = study.materials.elements(
            study.materials.elastoplastic(stiffness=np.array([400.0, 300.0]), yield_force=strength),
            lambda u: jnp.diff(u, prepend=0.0),
            2,
        )
        return study.Problem(storeys, u0=np.zeros(2), damping=0.4, ground=ground.scaled(intensity), tangent="dense")

    over = {"intensity": [0.5, 1.0], "strength": [[3.0, 2.0], [1.5, 1.0]]}
    ds = study.run(frame, "rk4", dt=0.01, steps=400, over=over, observe=[PEAK], every=4)
    assert ds.largest.shape == (2, 2) and ds.strength.dims == ("lane", "strength_1")
    alone = study.run(frame(1.0, np.array([1.5, 1.0])), "rk4", dt=0.01, steps=400, observe=[PEAK], every=4)
    np.testing.assert_allclose(ds.largest[1], alone.largest, atol=1e-12)


def test_lanes_may_have_their_own_step():
    ds = study.run(_spring, "rk4", dt=[0.05, 0.025], steps=20, over={"stiffness": [1.0, 1.0]})
    alone = study.run(_spring(1.0), "rk4", dt=0.025, steps=20)
    np.testing.assert_allclose(ds.u[1], alone.u, atol=1e-13)


@pytest.mark.slow
def test_lanes_may_have_their_own_number_of_steps():
    steps = [40, 100, 7]
    springs = {"stiffness": np.array([1.0, 4.0, 9.0])}
    with pytest.raises(ValueError, match="is recorded along time, which needs one number of steps for all lanes"):
        study.run(_spring, "rk4", over=springs, steps=steps, dt=0.05, observe=["trajectory"])
    with pytest.raises(ValueError, match=r"need arrays of one length, not steps 2, over\['stiffness'\] 3"):
        study.run(_spring, "rk4", over=springs, steps=[40, 100], dt=0.05, observe=[PEAK])
    last = study.Quantity(lambda u: u, name="last", reduce="final")
    ds = study.run(_spring, "rk4", over=springs, steps=steps, dt=0.05, observe=[last])
    for lane, count in enumerate(steps):
        alone = study.run(_spring(springs["stiffness"][lane]), "rk4", steps=count, dt=0.05, observe=[last])
        assert float(ds["last"][lane]) == pytest.approx(float(alone["last"]), abs=1e-13)


def test_a_lane_that_fails_is_reported_and_the_others_go_on():
    with pytest.warns(study.RunFailedWarning, match="1 of 2 runs failed, the first of them, lane 1"):
        ds = study.run(_spring, "central_difference", dt=0.5, steps=400, over={"stiffness": [1.0, 1e4]})
    assert ds.status.values.tolist()[0] == 0 and np.isfinite(ds.u[0]).all()


def test_rayleigh_damping_and_starts_of_several_unknowns_vary():
    def pair(a, start):
        damping = study.Rayleigh(a=a, b=0.01)
        return study.Problem(lambda u: 4 * u + u**3, u0=start * np.array([1.0, -0.5]), damping=damping)

    ds = study.run(pair, "average_acceleration", dt=0.05, steps=50, over={"a": [0.1, 0.3], "start": [1.0, 2.0]})
    alone = study.run(pair(0.3, 2.0), "average_acceleration", dt=0.05, steps=50)
    np.testing.assert_allclose(ds.u[1], alone.u, atol=1e-13)


def test_numbers_that_one_lane_alone_gets_wrong_are_refused():
    def yielding(strength):
        return study.Problem(study.materials.elastoplastic(stiffness=40.0, yield_force=strength), u0=0.0, v0=1.0)

    def heavy(mass):
        return study.Problem(lambda u: u, u0=np.ones(2), mass=mass * jnp.asarray([0.0, 1.0]))

    with pytest.raises(ValueError, match="yield_force must be a number greater than 0, not -1"):
        study.run(yielding, "rk4", dt=0.1, steps=5, over={"strength": [4.0, -1.0, 3.0]})
    with pytest.raises(ValueError, match="lane 0 of over has an unknown without mass"):
        study.run(heavy, "average_acceleration", dt=0.1, steps=5, over={"mass": [1.0, 2.0]})


@pytest.mark.parametrize(
    "make, change, error, sentence",
    [
        ("hardening", {}, TypeError, "over= needs a function that makes a problem in place of 'hardening'"),
        (_spring, {"over": {"k": [1.0]}}, ValueError, "over has 'k', which the function that makes the problem does"),
        (_spring, {"over": {"stiffness": 1.0}}, ValueError, r"over\['stiffness'\] must be an array of finite numbers"),
        (_spring, {"over": {"stiffness": [1.0, np.nan]}}, ValueError, "must be an array of finite numbers"),
        (_spring, {"over": {"stiffness": [1.0], "start": [1.0, 2.0]}}, ValueError, "over needs arrays of one length"),
        (_spring, {"over": {}}, ValueError, "over needs arrays of one length, at least one, not nothing"),
        (_spring, {"u0": 1.0}, ValueError, "u0 and v0 come from the function that makes the problem"),
        (_spring, {"dt": [0.1, 0.2]}, ValueError, r"need arrays of one length, not dt 2, over\['stiffness'\] 1"),
        (lambda t: _spring(t), {"over": {"t": [1.0]}}, ValueError, "over has 't', a name that the result has already"),
        (lambda stiffness: stiffness, {}, TypeError, "must return a study.Problem, not"),
    ],
)
def test_bad_families_are_refused(make, change, error, sentence):
    arguments = {"dt": 0.1, "steps": 10, "over": {"stiffness": [1.0]}} | change
    with pytest.raises(error, match=sentence):
        study.run(make, "rk4", **arguments)


def _mesh(side):
    """The stiffness of a membrane of side × side nodes."""
    row = scipy.sparse.diags_array([2 * np.ones(side), -np.ones(side - 1), -np.ones(side - 1)], offsets=[0, 1, -1])
    identity = scipy.sparse.eye_array(side)
    return scipy.sparse.csc_array(scipy.sparse.kron(row, identity) + scipy.sparse.kron(identity, row))


@pytest.mark.parametrize(
    "stiffness",
    [
        pytest.param(_mesh(6), id="mesh", marks=pytest.mark.exhaustive),
        pytest.param(_mesh(12)[:12, :12], id="row"),
        pytest.param(scipy.sparse.eye_array(36), id="diagonal"),
    ],
)
def test_sparse_matrices_of_jax_depend_on_the_lane_and_are_differentiated(stiffness):
    """A sparse matrix whose values are those of the first lane in all lanes, or constant in a derivative."""
    n = stiffness.shape[0]
    u0, cubic = np.linspace(0.5, 1.0, n), lambda u: u**3
    jax_stiffness = BCOO.from_scipy_sparse(stiffness)

    def make(scale, matrix=jax_stiffness):
        return study.Problem(cubic, u0=u0, stiffness=scale * matrix, damping=0.1 * matrix, mass=2.0 * matrix)

    options = {"scheme": "average_acceleration", "dt": 0.05, "steps": 20}
    lanes = study.run(make, over={"scale": [1.0, 3.0]}, **options)
    alone = study.run(make(3.0, stiffness), **options)
    np.testing.assert_allclose(lanes.u.isel(lane=1).squeeze(), alone.u.squeeze(), rtol=1e-12)

    @jax.jit
    def last(scale):
        return study.final_state(make(scale), **options)["u"][0]

    h = 1e-5
    slope = (last(2.0 + h) - last(2.0 - h)) / (2 * h)
    assert jax.grad(last)(2.0) == pytest.approx(float(slope), rel=1e-7)


def test_the_peak_of_the_absolute_acceleration_is_a_quantity_of_a_family():
    def shaken(scale):
        ground = study.GroundMotion.el_centro().scaled(scale)
        return study.Problem(lambda u: 100 * u, u0=np.zeros(2), ground=ground, tangent="diagonal")

    absolute = study.Quantity(lambda a, ground: a + ground, name="floor", reduce="peak")
    options = {"scheme": "average_acceleration", "dt": 0.01, "steps": 500}
    lanes = study.run(shaken, over={"scale": [1.0, 2.0]}, observe=[absolute], **options)
    alone = study.run(shaken(2.0), observe=["absolute_acceleration"], **options)
    np.testing.assert_allclose(lanes.floor[1], np.abs(alone.absolute_acceleration).max("t"), rtol=1e-12)
    with pytest.raises(ValueError, match="'floor' needs Problem"):
        study.run("hardening", observe=[absolute], **options)


@pytest.mark.parametrize(
    "make, over, sentence",
    [
        (lambda s: study.Problem(None, np.ones(64), stiffness=s * _mesh(8)), {"s": [1.0, 2.0]}, "sparse.BCOO"),
        (lambda s: study.Problem(lambda u: u if s > 0 else -u, 1.0), {"s": [1.0, 2.0]}, "must be written with jax.num"),
        (lambda s, k: study.Problem(lambda u: s * k * u, 1.0), {"s": [1.0]}, "over lacks 'k', an argument"),
        (lambda s: study.Problem(lambda u: s * u, 1.0), ["s"], "over must be a mapping of names to arrays"),
        (study.problems["hardening"], {"s": [1.0]}, "needs a function that makes a problem in place of the problem"),
    ],
)
def test_a_family_that_cannot_be_made_says_why(make, over, sentence):
    with pytest.raises((TypeError, ValueError), match=sentence):
        study.run(make, "rk4", over=over, dt=0.01, steps=5)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [{"dt": 0.01, "steps": 10}, {"tolerance": 1e-3, "duration": 0.1}])
def test_a_repeated_family_is_compiled_once_as_long_as_its_function_reads_the_same(steps, compiled):
    def make(k):
        return study.Problem(lambda u: factor * k * u, u0=1.0)

    factor, over, arguments = 1.0, {"k": np.array([1.0, 4.0])}, {"observe": END} | steps
    ends = [study.run(make, "rk4", over=over, **arguments) for _ in range(2)]
    before = len(compiled)
    ends.append(study.run(make, "rk4", over=over, **arguments))
    assert len(compiled) == before
    factor = 4.0
    ends.append(study.run(make, "rk4", over=over, **arguments))
    for end, k in zip(ends, (1.0, 1.0, 1.0, 4.0), strict=True):
        np.testing.assert_allclose(end.end_u, np.cos(np.sqrt(k * over["k"]) * 0.1), atol=1e-4)
