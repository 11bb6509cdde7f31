"""A run as a pure function: its memory, its refusals, and its derivatives, compared with multiprecision differences."""

import warnings
from functools import partial

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from scipy import sparse

import study


def _average_acceleration(stiffness, cubic, steps=40, dt="0.05"):
    """Last displacement of ü + k u + c u³ = 0 from u₀ = 1 at rest, by average acceleration in multiple precision."""
    u, v, dt = mpmath.mpf(1), mpmath.mpf(0), mpmath.mpf(dt)
    a = -stiffness * u - cubic * u**3
    for _ in range(steps):
        predicted, half = u + dt * v + dt**2 / 4 * a, v + dt / 2 * a
        for _ in range(8):
            at = predicted + dt**2 / 4 * a
            a -= (a + stiffness * at + cubic * at**3) / (1 + dt**2 / 4 * (stiffness + 3 * cubic * at**2))
        u, v = predicted + dt**2 / 4 * a, half + dt / 2 * a
    return u


def _end(parameters):
    spring = study.Problem(lambda u: parameters[0] * u + parameters[1] * u**3, u0=1.0)
    return study.final_state(spring, "average_acceleration", dt=0.05, steps=40)["u"]


@pytest.mark.slow
def test_derivatives_are_exact_to_round_off():
    """A derivative through Newton iterations that stops before the iteration has converged."""
    at = jnp.asarray([4.0, 2.0])
    with mpmath.workdps(40):
        k, c = mpmath.mpf(4), mpmath.mpf(2)
        expected = [
            float(mpmath.diff(lambda k: _average_acceleration(k, c), k)),
            float(mpmath.diff(lambda c: _average_acceleration(k, c), c)),
        ]
    assert jax.grad(_end)(at) == pytest.approx(expected, rel=1e-12)
    assert jax.jacfwd(_end)(at) == pytest.approx(expected, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rk4", "rho_bathe", "houbolt", "gauss4"])
def test_it_is_the_run(name):
    ds = study.run("softening", name, dt=0.01, steps=500, observe=["trajectory", "energy_drift"])
    state = study.final_state("softening", name, dt=0.01, steps=500, observe=["energy_drift"])
    assert float(state["u"]) == pytest.approx(float(ds.u[-1]), abs=1e-11)
    assert float(state["energy_drift"]) == pytest.approx(float(ds.energy_drift), abs=1e-11)
    assert int(state["failed_at_step"]) == -1


@pytest.mark.slow
def test_hysteresis_and_its_dissipation_are_differentiated():
    def dissipated(yield_force):
        spring = study.materials.elastoplastic(stiffness=40.0, yield_force=yield_force, hardening=0.1)
        problem = study.Problem(spring, u0=0.0, v0=3.0, potential=spring.potential)
        return study.final_state(problem, "average_acceleration", dt=0.01, steps=150, observe=["energy_balance"])[
            "dissipated_energy"
        ]

    slope = float(dissipated(5.0 + 1e-6) - dissipated(5.0 - 1e-6)) / 2e-6
    assert float(jax.grad(dissipated)(5.0)) == pytest.approx(slope, rel=1e-6)
    assert float(jax.jvp(dissipated, (5.0,), (1.0,))[1]) == pytest.approx(slope, rel=1e-6)


@pytest.mark.slow
def test_backward_derivatives_keep_few_states():
    """For a hundred times as many steps, the compiled derivative needs less than 15 times the memory."""

    def needed(steps):
        def end(u0):
            return jnp.sum(study.final_state("fpu_chain", "average_acceleration", dt=0.01, steps=steps, u0=u0)["u"])

        start = jnp.asarray(study.problems["fpu_chain"].u0)
        memory = jax.jit(jax.grad(end)).lower(start).compile().memory_analysis()
        assert memory is not None
        return memory.temp_size_in_bytes

    assert needed(10_000) < 15 * needed(100)


@pytest.mark.slow
def test_lanes_by_vmap():
    ends = jax.vmap(_end)(jnp.asarray([[4.0, 2.0], [1.0, 0.0]]))
    assert ends == pytest.approx([float(_end([4.0, 2.0])), float(_end([1.0, 0.0]))], abs=1e-14)


def test_a_failure_is_reported():
    state = study.final_state("hardening", "central_difference", dt=1.0, steps=100)
    assert int(state["failed_at_step"]) > 0


@pytest.mark.parametrize(
    "change, sentence",
    [
        ({"observe": ["trajectory"]}, "'u' is recorded along time, and final_state returns one value per run: observe"),
        ({"observe": ["momentum_errors"]}, "needs Problem\\(positions=...\\)"),
        ({"steps": 0}, "steps must be a whole number of at least 1"),
        ({"dt": -0.01}, "dt must be one number, finite and greater than zero, not -0.01"),
        ({"dt": [0.1, 0.2]}, "dt must be one number"),
        ({"dt": "a"}, "dt must be a real number"),
        ({"u0": "a"}, "u0 must be a real number"),
        ({"u0": np.nan}, "u0 must be finite, not nan"),
        ({"u0": [1.0, 2.0]}, r"u0 must have the shape \(\) of the problem, not \(2,\)"),
    ],
)
def test_what_it_cannot_do_is_refused(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        study.final_state("hardening", "rk4", **{"dt": 0.01, "steps": 10} | change)


@pytest.mark.slow
def test_a_potential_does_not_hinder_derivatives():
    def end(stiffness):
        spring = study.Problem(lambda u: stiffness * u, u0=1.0, potential=lambda u: stiffness * u**2 / 2)
        return study.final_state(spring, "average_acceleration", dt=0.01, steps=100, observe=["energy_drift"])["u"]

    assert float(jax.grad(end)(4.0)) == pytest.approx(float(end(4.0 + 1e-6) - end(4.0 - 1e-6)) / 2e-6, rel=1e-7)


@pytest.mark.slow
def test_second_derivatives():
    """A rule of differentiation that can itself be differentiated in one direction only."""

    def motion(damping):
        problem = study.Problem(lambda u: 4 * u + u**3, u0=1.0, damping=damping)
        return study.final_state(problem, "rho_bathe", dt=0.02, steps=50)["u"]

    slope = jax.grad(motion)
    bend = (float(slope(0.5 + 1e-5)) - float(slope(0.5 - 1e-5))) / 2e-5
    for second in (jax.jacfwd(jax.jacfwd(motion)), jax.grad(jax.jacfwd(motion)), jax.hessian(motion), jax.grad(slope)):
        assert float(second(0.5)) == pytest.approx(bend, rel=1e-7)


def _pounding(window):
    """Six masses on springs, of which the first and the last meet at a gap; beyond ``window`` the contact has gone."""

    def motion(gap):
        def force(u):
            depth = u[0] - u[5] - gap
            contact = jnp.where((depth > 0) & (depth < window), 1e3 * depth, 0.0)
            return (4 * u).at[0].add(contact).at[5].add(-contact)

        problem = study.Problem(force, np.zeros(6), v0=np.array([5.0, 0, 0, 0, 0, -3.0]), title="towers")
        return study.final_state(problem, "average_acceleration", dt=0.005, steps=40)["u"][0]

    return motion


@pytest.mark.slow
def test_a_contact_that_closes_later_is_in_the_derivative():
    """The form of the tangent is found where the gap is open; the iteration alone converges without the contact."""
    motion = _pounding(np.inf)
    expected = float(motion(0.5 + 1e-6) - motion(0.5 - 1e-6)) / 2e-6
    assert float(jax.jacfwd(motion)(0.5)) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("transform", [pytest.param(jax.grad, marks=pytest.mark.slow), jax.jacfwd])
def test_a_derivative_without_all_entries_of_the_tangent_is_nan(transform):
    """The contact acts in a window of depths only, which no displacement hits at which the form is found."""
    motion = _pounding(2.0)
    with pytest.warns(RuntimeWarning, match=r"the force couples unknowns that .*tangent='dense'"):
        assert np.isnan(transform(motion)(0.5))


@pytest.mark.slow
@pytest.mark.parametrize("form", ["tridiagonal", 2, "matrix_free", "sparse"])
def test_every_form_of_the_tangent_has_derivatives_in_both_modes(form):
    def motion(stiffness):
        declared = sparse.eye_array(6, format="csc") if form == "sparse" else form
        problem = study.Problem(lambda u: stiffness * u + u**3, np.linspace(0.5, 1.0, 6), tangent=declared)
        return study.final_state(problem, "average_acceleration", dt=0.05, steps=10)["u"].sum()

    expected = float(motion(2.0 + 1e-5) - motion(2.0 - 1e-5)) / 2e-5
    assert float(jax.grad(motion)(2.0)) == pytest.approx(expected, rel=1e-8)
    assert float(jax.jacfwd(motion)(2.0)) == pytest.approx(expected, rel=1e-8)


def _end_of_impact(contact, stiffness):
    """Displacement of a mass that has met a contact: 3 of its 40 steps touch it."""
    problem = study.Problem(lambda u: stiffness * contact(u), u0=-0.037, v0=1.0, title="contact")
    return study.final_state(problem, "average_acceleration", dt=1e-3, steps=40)["u"]


def _single_where(u):
    return jnp.where(u > 0, u**1.5, 0.0)


def _double_where(u):
    return jnp.where(u > 0, jnp.where(u > 0, u, 1.0) ** 1.5, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("transform", [jax.grad, lambda f: jax.jit(jax.grad(f))])
def test_a_branch_that_spoils_derivatives_in_reverse_mode_is_warned_about(transform):
    with pytest.warns(RuntimeWarning, match="a derivative of the final state of 'contact' is NaN.* double where"):
        slope = transform(partial(_end_of_impact, _single_where))(1e4).block_until_ready()
        jax.effects_barrier()
    assert np.isnan(slope)


@pytest.mark.slow
def test_a_double_where_gives_the_derivative_in_reverse_mode():
    end = partial(_end_of_impact, _double_where)
    difference = (end(1e4 + 1.0) - end(1e4 - 1.0)) / 2
    assert jax.grad(end)(1e4) == pytest.approx(float(difference), rel=1e-6)


def test_a_load_whose_exponent_is_traced_is_warned_about():
    def end(exponent):
        load = lambda t: jnp.where(t > 0.02, (t - 0.02) ** exponent, 0.0)  # noqa: E731
        problem = study.Problem(stiffness=1.0, u0=0.0, load=load, title="late")
        return study.final_state(problem, "rk4", dt=1e-2, steps=5)["u"]

    with pytest.warns(RuntimeWarning, match="a derivative of the final state of 'late' is NaN"):
        assert np.isnan(jax.grad(end)(1.5))


def _end_of(force, u0, k, load=None):
    problem = study.Problem(lambda u: k * u + force(u), u0=u0, load=load, title="curved")
    return study.final_state(problem, "rk4", dt=1e-2, steps=20)["u"]


def _clipped(u):
    return jnp.arccos(jnp.clip(u, -1, 1))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("transform", "force", "u0"),
    [
        (jax.grad, _clipped, 1.5),
        (jax.jacfwd, _clipped, 1.5),
        (lambda f: lambda k: jax.vmap(jax.grad(f))(jnp.array([k, 2 * k])), _clipped, 1.5),
        (jax.jacfwd, lambda u: jnp.sqrt(u**2), 0.0),
        (jax.jacfwd, lambda u: u * jnp.linalg.norm(u), np.zeros(2)),
    ],
)
def test_a_derivative_that_is_nan_is_warned_about_in_every_mode(transform, force, u0):
    with pytest.warns(RuntimeWarning, match="a derivative of the final state of 'curved' is NaN"):
        slope = transform(lambda k: jnp.sum(_end_of(force, u0, k)))(3.0)
        jax.effects_barrier()
    assert np.isnan(slope).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "load"),
    [
        (lambda u: jnp.where(u > 0, u * jnp.log(jnp.abs(u)), u), None),
        (lambda u: jnp.where(u == 0, 0.0, jnp.sin(u) / u * u), None),
        (lambda u: u, lambda t: jnp.sqrt(t) * jnp.where(t > 0.1, (t - 0.1) ** 0.5, 0.0)),
    ],
)
def test_a_derivative_that_is_finite_is_not_warned_about(force, load):
    end = partial(_end_of, force, 0.5, load=load)
    difference = (end(3.0 + 1e-4) - end(3.0 - 1e-4)) / 2e-4
    with warnings.catch_warnings(action="error"):
        assert jax.grad(end)(3.0) == pytest.approx(float(difference), rel=1e-6)
        assert jax.jacfwd(end)(3.0) == pytest.approx(float(difference), rel=1e-6)
        jax.effects_barrier()


def test_a_start_may_be_a_list_with_traced_numbers():
    pair = study.Problem(lambda u: 4 * u, [1.0, 2.0])
    end = jax.jit(lambda x: study.final_state(pair, "central_difference", dt=0.1, steps=3, u0=[x, 2.0])["u"])
    expected = study.final_state(pair, "central_difference", dt=0.1, steps=3)["u"]
    np.testing.assert_allclose(end(1.0), expected, rtol=1e-14)


def test_the_step_size_may_be_traced():
    spring = study.Problem(lambda u: 10 * u, u0=-0.1, v0=1.0, load=jnp.cos)

    def end(dt):
        return study.final_state(spring, "rk4", dt=dt, steps=5)["u"]

    assert jax.jit(end)(0.01) == pytest.approx(float(end(0.01)), rel=1e-12)
