"""Runs of sparse models give the results of full matrices, with the unknowns in the user's order."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import sparse

import study
from study.algebra.factorisation import factorisations
from study.mechanics.frequencies import frequencies
from study.mechanics.sparse_tangent import SparseTangent

N = 24
RNG = np.random.default_rng(4)
#: Random numbering of the unknowns of a chain; its springs connect neighbours and second neighbours.
ORDER = RNG.permutation(N)
STIFFNESS = sparse.csc_array(
    sparse.diags_array([-0.5, -2.0, 6.0, -2.0, -0.5], offsets=[-2, -1, 0, 1, 2], shape=(N, N))
)[ORDER][:, ORDER]
MASS = sparse.csc_array(sparse.diags_array([0.2, 1.0, 0.2], offsets=[-1, 0, 1], shape=(N, N)))[ORDER][:, ORDER]
START = RNG.normal(size=N)
STIFF = [3, 7, 20]


def _force(u):
    return jnp.zeros_like(u).at[jnp.array(STIFF)].set(4.0 * u[jnp.array(STIFF)] ** 3)


def _potential(u):
    return jnp.sum(u[jnp.array(STIFF)] ** 4)


def _model(full=False, **terms):
    terms = {"force": _force, "u0": START, "potential": _potential, "stiffness": STIFFNESS, "mass": MASS} | terms
    return study.Problem(**{k: v.toarray() if full and sparse.issparse(v) else v for k, v in terms.items()})


def _motion(problem, scheme, **options):
    return study.run(problem, scheme, **{"dt": 0.05, "steps": 40, "observe": ["trajectory"]} | options)


@pytest.fixture(scope="module")
def models():
    """The model with sparse and with full matrices."""
    return _model(title="sparse"), _model(full=True, title="full")


def test_every_kind_of_state_gives_the_numbers_of_full_matrices(models, state_kind):
    sparse_model, full_model = models
    assert isinstance(sparse_model.tangent, SparseTangent) and full_model.tangent == 0
    if reason := study.schemes[state_kind].refusal(sparse_model):
        assert state_kind in {"energy_momentum", "average_vector_field", "gauss4"}, reason
        with pytest.raises(ValueError, match=r"'sparse'"):
            _motion(sparse_model, state_kind)
        return
    sparse_run, full_run = _motion(sparse_model, state_kind), _motion(full_model, state_kind)
    assert sparse_run.status == full_run.status
    np.testing.assert_allclose(sparse_run.u, full_run.u, atol=1e-11)


@pytest.fixture(scope="module")
def inside():
    """The model whose stiffness is part of its force."""
    full = STIFFNESS.toarray()
    return _model(
        force=lambda u: _force(u) + full @ u,
        potential=lambda u: _potential(u) + u @ full @ u / 2,
        stiffness=None,
        mass=MASS.toarray(),
    )


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "rk4"])
def test_a_stiffness_next_to_the_force_is_the_force_with_it(models, inside, scheme):
    options = {"observe": ["trajectory", "max_energy_error"]}
    separate, combined = (_motion(model, scheme, **options) for model in (models[0], inside))
    np.testing.assert_allclose(separate.u, combined.u, atol=1e-11)
    np.testing.assert_allclose(separate.max_energy_error, combined.max_energy_error, rtol=1e-7)


@pytest.mark.slow
def test_one_unknown_and_diagonals_may_have_a_stiffness():
    soft = study.Problem(lambda u: -0.1 * u**3, 1.0, stiffness=2.0)
    equivalent = study.Problem(lambda u: 2.0 * u - 0.1 * u**3, 1.0)
    np.testing.assert_allclose(_motion(soft, "gauss4").u, _motion(equivalent, "gauss4").u, rtol=1e-12)
    diagonal = study.Problem(u0=START, stiffness=sparse.diags_array(np.arange(1.0, N + 1)))
    assert diagonal.tangent == 0 and np.ndim(diagonal.stiffness) == 1
    chain = study.Problem(u0=START, stiffness=sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(N, N)))
    assert chain.tangent == 1
    full = study.Problem(u0=START, stiffness=np.asarray(chain.stiffness.bands[1]) * np.eye(N), title="full")
    assert _motion(full, "gauss4").status == _motion(chain, "gauss4").status == 0


@pytest.fixture(scope="module")
def linear():
    return _model(force=None, potential=None)


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "factors"), [("average_acceleration", 1), ("bathe", 2), ("wilson_theta", 1)])
def test_a_linear_structure_factorises_once(linear, scheme, factors):
    """A run factorises the mass and the matrix of each sub-step once; each sub-step has one linear solution."""
    factorisations.cache_clear()
    jax.clear_caches()
    ds = _motion(linear, scheme, dt=0.0517, steps=200, observe=["newton_iterations"])
    assert factorisations(linear.tangent.pattern).count == factors + 1
    assert ds.newton_iterations == 200 * factors


@pytest.mark.slow
def test_a_linear_structure_keeps_its_energy_and_its_modes(linear):
    assert _motion(linear, "average_acceleration", steps=2000, observe=["max_energy_error"]).max_energy_error < 1e-11
    squares = np.linalg.eigvals(np.linalg.solve(MASS.toarray(), STIFFNESS.toarray())).real
    np.testing.assert_allclose(frequencies(linear), np.sqrt(np.sort(squares)), rtol=1e-10)


#: Damping that is proportional to the stiffness, and gyroscopic forces.
WHIRL = sparse.csc_array(0.1 * STIFFNESS + sparse.diags_array([-0.3, 0.3], offsets=[-1, 1], shape=(N, N)))


@pytest.mark.parametrize("damping", [study.Rayleigh(a=0.1, b=0.02), WHIRL], ids=["Rayleigh", "gyroscopic"])
def test_damping_loads_and_ground_are_those_of_full_matrices(damping):
    terms = {
        "damping": damping,
        "ground": study.GroundMotion(np.sin(np.arange(100.0)), 0.02),
        "load": lambda t: jnp.sin(t) * jnp.ones(N),
    }
    sparse_run, full_run = (_motion(_model(full, **terms), "average_acceleration") for full in (False, True))
    np.testing.assert_allclose(sparse_run.u, full_run.u, atol=1e-11)


@pytest.mark.slow
def test_a_force_of_the_velocity_is_that_of_full_matrices():
    terms = {"force": lambda u, v: _force(u) + jnp.zeros_like(v).at[5].set(2.0 * v[5] - v[6]), "potential": None}
    sparse_problem, full_problem = _model(**terms), _model(True, **terms)
    assert not sparse_problem.tangent.pattern.symmetric
    np.testing.assert_allclose(_motion(sparse_problem, "bathe").u, _motion(full_problem, "bathe").u, atol=1e-11)


def test_unknowns_may_have_no_mass():
    has = np.ones(N)
    has[4] = 0.0
    singular_mass = sparse.csc_array(sparse.diags_array(has) @ MASS @ sparse.diags_array(has))
    sparse_problem, full_problem = (
        _model(full, mass=singular_mass, u0=np.zeros(N), v0=has * START) for full in (False, True)
    )
    assert sparse_problem.massless
    np.testing.assert_allclose(_motion(sparse_problem, "bathe").u, _motion(full_problem, "bathe").u, atol=1e-11)


def test_the_form_of_the_force_may_be_declared():
    detected = _model()
    assert detected.tangent.colours == 1
    assert _model(tangent="diagonal").tangent.pattern == detected.tangent.pattern
    contact = _model(
        tangent=sparse.csc_array(([1.0, 1.0], ([0, 9], [9, 0])), (N, N)),
        force=lambda u: jnp.zeros_like(u),
        potential=None,
    )
    assert contact.tangent.colours == 1
    with pytest.raises(ValueError, match="the declared tangent of 'tied' does not fit its force: the derivative"):
        _model(force=lambda u: u - jnp.roll(u, 3), tangent="diagonal", potential=None, title="tied")
    with pytest.raises(ValueError, match="tangent='dense' of 'tied', whose stiffness, mass or damping is sparse: give"):
        _model(tangent="dense", title="tied")


def test_ensembles_and_derivatives_of_sparse_models(models):
    """A coloured tangent that is wrong in a lane or in a derivative only."""
    model, full_model = models
    lanes = _motion(model, "average_acceleration", u0=np.stack([START, 0.5 * START]))
    np.testing.assert_allclose(
        lanes.u.isel(lane=1), _motion(model, "average_acceleration", u0=0.5 * START).u, atol=1e-12
    )

    def last(factor, problem):
        return jnp.sum(study.final_state(problem, "average_acceleration", dt=0.05, steps=5, u0=factor * START)["u"])

    slopes = [jax.jacfwd(last)(1.0, problem) for problem in (model, full_model)]
    np.testing.assert_allclose(jax.jacrev(last)(1.0, model), slopes[1], rtol=1e-10)
    np.testing.assert_allclose(slopes[0], slopes[1], rtol=1e-10)


@pytest.mark.parametrize(
    ("terms", "sentence"),
    [
        ({"stiffness": STIFFNESS * np.nan}, r"stiffness must be finite, and its entry \(\d+, \d+\) is nan"),
        (
            {"stiffness": sparse.triu(STIFFNESS)},
            "stiffness must be symmetric; it differs from its transpose by 2: give it as a force, force=lambda u: jax",
        ),
        ({"mass": sparse.csc_array(MASS * 1j)}, "mass must be a sparse matrix of real numbers, not of complex128"),
        (
            {"stiffness": STIFFNESS[:5, :5]},
            r"stiffness must have the shape \(24, 24\) for u0 of shape \(24,\); got \(5, 5\)",
        ),
        ({"mass": MASS - sparse.eye_array(N)}, "mass must be positive definite among the unknowns that have mass"),
        ({"tangent": STIFFNESS[:5, :5]}, r"tangent of 'unnamed problem' must be a matrix of shape \(24, 24\)"),
        ({"stiffness": None, "force": None, "potential": None}, "force must be a function"),
    ],
)
def test_bad_matrices_are_refused(terms, sentence):
    with pytest.raises((ValueError, TypeError), match=sentence):
        _model(**terms)
