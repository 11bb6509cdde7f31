"""Arguments of problems, the properties that problems detect, and the errors for invalid arguments."""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import expm

import study
from study.algebra.matrices import Banded
from study.mechanics.balance import balance
from tests.mechanics.forces import all_to_all, chain

N = 5


ZERO = np.zeros(N)


def _lopsided(u):
    return u + 0.5 * jnp.concatenate([u[1:], jnp.zeros(1)])


def test_a_diagonal_matrix_is_as_regular_as_its_diagonal():
    mass = np.array([1e8, 1e-8, 1.0])
    assert not study.Problem(jnp.sinh, np.zeros(3), mass=np.diag(mass)).massless
    assert not study.Problem(jnp.sinh, np.zeros(3), mass=mass).massless


@pytest.mark.slow
def test_a_problem_prints_the_terms_that_it_has():
    one = study.Problem(lambda u: u, 1.0, mass=2.0, damping=0.1, title="one")
    assert repr(one) == "one: M ü + C u̇ + p(u) = 0\nu(0) = 1.0, u̇(0) = 0.0"
    two = study.Problem(None, [1.0, 2.0], stiffness=4.0, load=lambda t: jnp.array([0.0, t]), title="two")
    assert repr(two) == "two: ü + K u = f(t)\n2 unknowns"


def test_numbers_of_numpy_are_numbers():
    problem = _problem(tangent=np.int64(1), damping=study.Rayleigh(a=np.int64(1), b=np.float32(0.5)))
    assert problem.tangent == 1


def _problem(force=chain, u0=ZERO, v0=None, **keywords):
    return study.Problem(force, u0, np.zeros_like(u0) if v0 is None else v0, title="tried", **keywords)


@pytest.mark.parametrize(
    "keywords, sentence",
    [
        ({"tangent": "diagonal"},
         "tangent='diagonal' does not fit the force of 'tried': the derivative of the force has entries outside it."),
        ({"force": all_to_all, "tangent": 2},
         "tangent=2 does not fit the force of 'tried': the derivative of the force has entries outside it."),
        ({"force": _lopsided, "tangent": "matrix_free"},
         "tangent='matrix_free' does not fit the force of 'tried': it is not symmetric, as conjugate gradients need."),
        ({"tangent": "triangular"},
         "tangent='triangular' of 'tried': give one of diagonal, tridiagonal, dense, matrix_free, or the half"),
        ({"tangent": N}, "or the half bandwidth as a whole number below 5."),
        ({"tangent": -1}, "or the half bandwidth as a whole number below 5."),
        ({"tangent": True}, "tangent=True of 'tried': give one of diagonal"),
        ({"tangent": 1.0}, "tangent=1.0 of 'tried': give one of diagonal"),
        ({"force": jnp.sinh, "u0": 0.0, "tangent": "diagonal"},
         "tangent='diagonal' of 'tried': the tangent of one unknown is a number; leave it out."),
        ({"mass": np.eye(N) + np.eye(N, k=1)}, 
         "mass must be symmetric; it differs from its transpose by 1: leave it out, and give force, damping and load"),
        ({"tangent": "matrix_free", "damping": np.eye(N) + np.eye(N, k=1)},
         "damping must be symmetric; it differs from its transpose by 1."),
        ({"mass": [1.0, 1.0, -0.5, 1.0, 1.0]}, "mass must not be negative; its smallest value is -0.5."),
        ({"mass": -2.0}, "mass must not be negative; its smallest value is -2."),
        ({"mass": np.diag([1.0, 1.0, -0.5, 1.0, 1.0])}, "mass must not be negative; its smallest value is -0.5."),
        ({"mass": ZERO}, "mass must not be zero everywhere: the problem would have no dynamics."),
        ({"positions": np.zeros((2, 2))},
         "at most three directions and as many numbers as u0, which has 5; their shape is (2, 2)."),
        ({"positions": np.zeros((1, 5))}, "at most three directions"),
        ({"positions": np.zeros(5)}, "positions must have the shape (points, directions)"),
        ({"positions": np.full((5, 1), np.nan)}, "positions must be finite"),
        ({"tangent": [1]}, "tangent=[1] of 'tried': give one of diagonal"),
        ({"mass": True}, "mass must be a real number or an array of real numbers, not True."),
        ({"u0": np.full(N, 1j)}, "u0 must be a real number or an array of real numbers, not array("),
        ({"potential": lambda u: jnp.sum(u**2)}, "the force of 'tried' is not the gradient of its potential: along"),
        ({"force": lambda u: {"mass": 1.0}["stiffness"] * u},
         "force of 'tried' fails for the displacement alone: KeyError: 'stiffness'"),
        ({"force": lambda u: u / jnp.sqrt(jnp.sum(u * u)), "u0": np.ones(N), "damping": study.Rayleigh(a=0.1, b=0.1)},
         "the stiffness of 'tried' at u = 0, on which its Rayleigh damping is based, is not finite."),
        ({"damping": study.Rayleigh(a=0.1, b="b")}, "a and b must be finite numbers that are not negative."),
        ({"damping": study.Rayleigh(a=-0.1, b=0.1)}, "a and b must be finite numbers that are not negative."),
        ({"force": lambda u: u * u[N]},
         "force of 'tried' takes an entry that does not exist: index 5 is out of bounds for axis 0 with size 5."),
        ({"force": lambda u: u.at[N].add(1.0)},
         "force of 'tried' takes an entry that does not exist: out-of-bounds indexing for array of shape (5,)"),
        ({"load": lambda t: [1.0] * (N - 1)}, "load must return the shape (5,), not (4,)."),
        ({"force": lambda u, v, w, t: u}, "force of 'tried' takes 3 arguments, and the problem has no history: give"),
        ({"force": lambda u, t=0.0: u}, "force of 'tried' gives 't' a default, and would never be called with another"),
        ({"load": lambda u: u}, "load of 'tried' takes 'u', and is called as load(t): what depends on the motion goes"),
        ({"positions": "here"}, "positions must be a real number or an array of real numbers, not 'here'."),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(keywords, sentence):
    with pytest.raises(ValueError) as caught:
        _problem(**keywords)
    assert sentence in str(caught.value)


@pytest.mark.parametrize("density", [lambda e: e[:-1], lambda e: jnp.sum(e * e), lambda e: e[None]])
def test_a_strain_energy_has_one_energy_for_each_strain(density):
    energy = study.StrainEnergy(lambda u: jnp.diff(u), density)
    with pytest.raises(ValueError, match=r"a StrainEnergy needs strains of shape \(m,\) and a density of the same"):
        study.Problem(jnp.sinh, ZERO, ZERO, potential=energy)


def test_a_strain_energy_sums_over_its_strains():
    energy = study.StrainEnergy(lambda u: jnp.diff(u), lambda e: e * e / 2)
    assert energy(jnp.array([0.0, 1.0, 3.0])) == 2.5


@pytest.mark.slow
def test_a_force_is_the_gradient_of_the_potential():
    energy = study.StrainEnergy(
        lambda u: jnp.concatenate([u[:1], jnp.diff(u)]), lambda r: r * r / 2 + r * r * r * r / 4
    )
    problem = study.Problem(potential=energy, u0=ZERO, v0=ZERO)
    u = np.linspace(-1, 2, N)
    np.testing.assert_allclose(problem.force(u), chain(u), rtol=1e-14)
    assert problem.tangent == 1


@pytest.mark.slow
def test_constants_and_lists_are_loads():
    single = study.Problem(lambda u: u, u0=0.0, load=lambda t: 5.0)
    two = study.Problem(lambda u: u, u0=np.zeros(2), load=lambda t: [5.0, jnp.cos(t)])
    ends = [study.run(problem, "rk4", dt=0.01, steps=100).u[-1] for problem in (single, two)]
    np.testing.assert_allclose(ends[0], 5 * (1 - np.cos(1.0)), rtol=1e-8)
    np.testing.assert_allclose(ends[1], [5 * (1 - np.cos(1.0)), np.sin(1.0) / 2], rtol=1e-8)


class _Switched(eqx.Module):
    """A load that returns a list; its second component ends at t = 0.5."""

    kinks = (0.5,)

    def __call__(self, t):
        return [1.0, jnp.where(t < 0.5, 1.0, 0.0)]


def test_a_load_as_a_list_keeps_its_kinks():
    assert getattr(study.Problem(lambda u: u, u0=np.zeros(2), load=_Switched()).load, "kinks", None) == (0.5,)


@pytest.mark.parametrize("kinks", [lambda: [1.0], [np.nan], "soon"])
def test_kinks_of_a_load_are_times(kinks):
    def load(t):
        return 0.0 * t

    load.kinks = kinks  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match=r"load\.kinks of 'unnamed problem' must hold times in s, not "):
        study.Problem(lambda u: u, u0=1.0, load=load)


def test_an_array_is_no_load():
    with pytest.raises(TypeError, match="load must be a function, not an array: use jnp.interp for samples."):
        study.Problem(lambda u: u, u0=0.0, load=np.ones(100))


def test_neither_force_nor_potential_is_refused():
    with pytest.raises(TypeError, match="force must be a function, not None."):
        study.Problem(u0=ZERO, v0=ZERO)


@pytest.mark.parametrize(
    "mass, massless",
    [
        (None, False),
        (2.0, False),
        (np.arange(1.0, 6.0), False),
        (np.arange(5.0), True),
        (np.diag([1.0, 1.0, 0.0, 1.0, 1.0]), True),
        # singular, because a uniform acceleration needs no force; round-off makes the smallest eigenvalue non-zero
        (np.eye(5) - np.full((5, 5), 0.2), True),
        (np.eye(5) - np.full((5, 5), 0.19), False),
    ],
)
def test_a_singular_mass_is_noticed(mass, massless):
    assert _problem(mass=mass).massless == massless


@pytest.mark.slow
def test_a_narrow_mass_is_held_as_a_band():
    n = 12
    mass = 4 * np.eye(n) + np.eye(n, k=1) + np.eye(n, k=-1)
    problem = _problem(u0=np.zeros(n), mass=mass)
    assert isinstance(problem.mass, Banded) and problem.mass.half_bandwidth == 1
    np.testing.assert_allclose(problem.momentum(jnp.arange(1.0, n + 1)), mass @ np.arange(1, n + 1))


@pytest.mark.parametrize("scheme", ["rk4", "central_difference", "kr_alpha", "linear_acceleration", "fox_goodwin"])
def test_schemes_with_a_limit_of_stability_need_a_mass_everywhere(scheme):
    with pytest.raises(ValueError) as caught:
        study.run(_problem(mass=[1.0, 1.0, 0.0, 1.0, 1.0]), scheme, dt=0.1, steps=1)
    assert "needs a mass at every unknown, and the mass of 'tried' is singular: take an implicit scheme" in str(
        caught.value
    )


@pytest.mark.slow
@pytest.mark.parametrize("mass", [[1.0, 1.0, 0.0, 1.0, 1.0], np.diag([1.0, 1.0, 0.0, 1.0, 1.0])])
def test_an_implicit_scheme_takes_a_massless_unknown(mass):
    """The forces of the springs at a massless unknown balance each other."""
    problem = _problem(u0=np.array([0.0, 0.3, 0.6, 0.9, 1.2]), mass=mass)
    ds = study.run(problem, "average_acceleration", dt=0.1, steps=10)
    assert ds.status == 0
    np.testing.assert_allclose(chain(ds.u.values[-1])[2], 0.0, atol=1e-12)


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_a_load_that_is_no_number_is_refused_before_the_run(number):
    problem = _problem(load=lambda t: jnp.where(t > 0.5, number, 1.0) * jnp.ones(N))
    with pytest.raises(ValueError, match="the load of 'tried' is not finite at t = 0.5"):
        study.run(problem, "rk4", dt=0.01, steps=100)
    assert study.run(problem, "rk4", dt=0.01, steps=40).status == 0


@pytest.mark.slow
@pytest.mark.parametrize("structure", ["dense", "tridiagonal", "matrix_free"])
@pytest.mark.parametrize("mass", [None, 2.0, np.arange(1.0, 6.0), 4 * np.eye(N) + np.eye(N, k=1) + np.eye(N, k=-1)],
                         ids=["none", "number", "diagonal", "matrix"])  # fmt: skip
def test_rayleigh_damping_is_of_mass_and_stiffness(structure, mass):
    """C = aM + bK with the stiffness at u = 0, whatever the initial displacement."""
    a, b = 0.3, 0.05
    problem = _problem(u0=np.linspace(0, 2, N), mass=mass, damping=study.Rayleigh(a=a, b=b), tangent=structure)
    full_mass = np.eye(N) if mass is None else np.diag(np.broadcast_to(mass, N)) if np.ndim(mass) < 2 else mass
    damping = a * full_mass + b * np.asarray(jax.jacfwd(chain)(jnp.zeros(N)))
    u, v, rhs = np.linspace(0, 1, N), np.linspace(1, 2, N), np.ones(N)
    acceleration, effort = eqx.filter_jit(balance)(problem, *map(jnp.asarray, (rhs, u, v, 0.01, 0.1, ZERO)))
    solution = np.asarray(acceleration)
    assert effort.converged
    residual = (
        full_mass @ solution
        + damping @ (v + 0.1 * solution)
        + np.asarray(chain(jnp.asarray(u + 0.01 * solution)))
        - rhs
    )
    np.testing.assert_allclose(residual, 0.0, atol=1e-8)


def test_rayleigh_damping_of_one_unknown():
    problem = study.Problem(lambda u: 4 * u + u**3, u0=1.0, mass=2.0, damping=study.Rayleigh(a=0.3, b=0.05))
    assert float(problem.damping) == pytest.approx(0.3 * 2 + 0.05 * 4)


def test_without_a_velocity_it_starts_at_rest():
    np.testing.assert_array_equal(study.Problem(lambda u: u, u0=[1.0, 2.0]).v0, np.zeros(2))


@pytest.mark.parametrize(
    "damping", [study.Rayleigh(a=float("nan"), b=1.0), study.Rayleigh(a="a", b=1.0), study.Rayleigh(a=None, b=1)]
)
def test_rayleigh_damping_takes_finite_numbers(damping):
    with pytest.raises(ValueError, match="a and b must be finite numbers"):
        _problem(damping=damping)


@pytest.mark.parametrize(
    "force, sentence",
    [
        (np.sin, "must be written with jax.numpy"),
        (lambda u: u.astype(complex), "force must return float64, not complex128"),
        (lambda u: jnp.dot(jnp.ones((3, 3)), u), "fails for the displacement alone: TypeError: "),
        (lambda u, v, w: u, "takes 3 arguments, and the problem has no history: give force\\(u\\), force\\(u, v\\)"),
        (lambda u, v: v[0], r"force must return the shape \(5,\), not \(\)"),
        (lambda v, u: u, "takes v and u: its first argument is the displacement, and its second the velocity"),
        (lambda u: [u], "force must return the shape"),
    ],
)
def test_a_force_that_cannot_be_used_is_refused(force, sentence):
    with pytest.raises(ValueError, match=sentence):
        study.Problem(force, u0=np.ones(5))


def _branching(u):
    if u > 0:
        return u
    return 2 * u


def _writing(u):
    p = np.zeros(2)
    p[0] = u[1]
    return p


@pytest.mark.parametrize(
    "force, u0, sentence",
    [
        (
            _branching,
            1.0,
            "use jnp.where in place of if, & in place of and, jnp.minimum in place of min, or jnp.maximum in place of "
            "max, in `u > 0`.",
        ),
        (lambda u: max(u, 0.0), 1.0, "use jnp.maximum in place of max, in `max\\(u, 0.0\\)`."),
        (lambda u: max(min(u, 1.0), 0.0), 1.0, "use jnp.minimum in place of min, in `min\\(u, 1.0\\)`."),
        (lambda u: np.sin(u), 1.0, "use .* in place of functions of NumPy and SciPy, in `np.sin\\(u\\)`."),
        (lambda u: math.sin(u), 1.0, "use .* in place of float, int and functions of math, in `math.sin\\(u\\)`."),
        (
            lambda u: [1.0, 2.0][(u > 0).astype(int)] * u,
            1.0,
            "use an array of jnp in place of a list with this index, in .*",
        ),
        (lambda u: u[u > 0].sum() * u, [1.0, 2.0], "use jnp.where in place of this index, in `u\\[u > 0\\]`."),
        (_writing, [1.0, 2.0], "use jnp.array\\(\\[x, y\\]\\) in place of p\\[i\\] = x, in `p\\[0\\]`."),
    ],
)
def test_what_to_write_in_place_of_an_expression_is_said_in_one_sentence(force, u0, sentence):
    with pytest.raises(ValueError, match=rf"^force of 'tried' must be written with jax.numpy: {sentence}$"):
        study.Problem(force, u0=u0, title="tried")


def test_an_unsymmetric_mass_is_part_of_the_other_terms():
    """What the message says, against the matrix exponential."""
    mass, stiffness = np.array([[2.0, 1.0], [0.0, 1.0]]), np.diag([100.0, 150.0])
    with pytest.raises(ValueError, match="by 1: leave it out, and give force, damping and load multiplied by its inv"):
        study.Problem(stiffness=stiffness, mass=mass, u0=[1.0, 0.5])
    inverse_mass = np.linalg.inv(mass)
    problem = study.Problem(lambda u: inverse_mass @ stiffness @ u, u0=[1.0, 0.5])
    end = study.final_state(problem, "rk4", dt=1e-3, steps=1000)
    first_order = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse_mass @ stiffness, np.zeros((2, 2))]])
    np.testing.assert_allclose(end["u"], (expm(first_order) @ [1, 0.5, 0, 0])[:2], atol=1e-8)


def test_an_unsymmetric_stiffness_is_a_force():
    """A rotor with a circulatory force, against the matrix exponential."""
    stiffness = np.array([[100.0, 20.0], [-20.0, 150.0]])
    with pytest.raises(ValueError, match="its transpose by 40: give it as a force, force=lambda u: K @ u."):
        study.Problem(stiffness=stiffness, u0=[1.0, 0.0])
    end = study.final_state(study.Problem(lambda u: stiffness @ u, u0=[1.0, 0.0]), "rk4", dt=1e-3, steps=1000)
    first_order = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness, np.zeros((2, 2))]])
    np.testing.assert_allclose(end["u"], (expm(first_order) @ [1, 0, 0, 0])[:2], atol=1e-8)


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ({"u0": [[1.0]]}, "u0 must be a number or a vector (n,), not an array of shape (1, 1)."),
        ({"u0": [1.0, 2.0], "v0": 0.0}, "v0 must have the shape of u0, (2,), not ()."),
        ({"mass": [1.0, 2.0]}, "mass must be a number, a diagonal or a matrix for u0 of shape (); got (2,)."),
        ({"force": lambda u: u.sum() * np.ones(3)}, "force must return the shape (), not (3,)."),
        ({"potential": lambda u: np.ones(3)}, "potential must return the shape (), not (3,)."),
        ({"load": lambda t: np.ones(3)}, "load must return the shape (), not (3,)."),
        ({"u0": float("nan")}, "u0 must be finite, not nan."),
        ({"force": 3.0}, "force must be a function, not 3.0."),
        ({"force": None}, "force must be a function, not None."),
        ({"u0": "x"}, "u0 must be a real number or an array of real numbers, not 'x'."),
        ({"u0": [], "v0": []}, "u0 must be a number or a vector (n,), not an array of shape (0,)."),
        ({"mass": 0.0}, "mass must not be zero everywhere: the problem would have no dynamics."),
        ({"u0": [1.0, 2.0], "v0": [0.0, 0.0], "mass": [[1.0, 2.0], [2.0, 1.0]]}, "its smallest value is -1."),
    ],
)
def test_problems_that_do_not_fit_are_refused(arguments, sentence):
    with pytest.raises((ValueError, TypeError)) as caught:
        study.Problem(**({"force": lambda u: u, "u0": 1.0} | arguments))
    assert sentence in str(caught.value)


def test_the_stored_energy_is_that_of_the_constant_stiffness_and_of_the_potential():
    stiffness, u = np.array([[3.0, -1.0], [-1.0, 2.0]]), np.array([0.5, -0.4])
    problem = study.Problem(lambda u: u**3, u, potential=lambda u: (u**4).sum() / 4, stiffness=stiffness)
    assert float(problem.stored_energy(u)) == pytest.approx(0.5 * u @ stiffness @ u + (u**4).sum() / 4, rel=1e-15)


@pytest.mark.parametrize("u0", [0.02, [0.3, -0.1]])
def test_a_potential_whose_gradient_is_nan_is_refused(u0):
    def single(u):
        return jnp.sum(jnp.where(u > 0, u**2.5, 0.0))

    def double(u):
        return jnp.sum(jnp.where(u > 0, jnp.where(u > 0, u, 1.0) ** 2.5, 0.0))

    with pytest.raises(ValueError, match="gradient of its potential, is NaN where the potential is finite: .* double"):
        study.Problem(potential=single, u0=u0)
    problem = study.Problem(potential=double, u0=u0)
    np.testing.assert_allclose(problem.force(-jnp.asarray(u0)), 2.5 * np.maximum(-np.asarray(u0), 0) ** 1.5)


def test_a_potential_that_jax_cannot_trace_is_named_and_not_the_force_that_follows_from_it():
    with pytest.raises(ValueError, match="^potential of 'unnamed problem' must be written with jax.numpy"):
        study.Problem(potential=lambda u: np.cosh(u), u0=1.0)


def test_a_force_that_returns_a_text_gets_a_sentence():
    with pytest.raises(ValueError, match=r"^force must return the shape \(\), not str"):
        study.Problem(lambda u: "text", u0=1.0)
