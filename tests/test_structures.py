"""Many degrees of freedom: what no form of the tangent changes, what is conserved, and motions in closed form."""

from functools import cache, partial

import equinox as eqx
import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

import study
from study.marching.march import March, march
from study.problem import chains, oscillators, trusses
from study.problem.springs import CubicSpring

N, DT, STEPS = 5, 0.05, 20


def _elongations(u):
    return jnp.concatenate([u[:1], jnp.diff(u)])


def _hardening(strain):
    return strain * strain / 2 + strain**4 / 4


class _Pull(eqx.Module):
    """A load on the last of n unknowns."""

    n: int = eqx.field(static=True, default=N)

    def __call__(self, t):
        return jnp.zeros(self.n).at[-1].set(0.3 * jnp.cos(2 * t))


def _chain(structure=None, density=_hardening, **keywords):
    """Springs in a row that hang on a wall, stretched."""
    energy = study.StrainEnergy(_elongations, density)
    return study.Problem(
        potential=energy, u0=np.linspace(0.2, 1, N), v0=np.linspace(0.5, -0.5, N), tangent=structure, **keywords
    )


_damped_chain = partial(
    _chain, mass=np.array([1.0, 2.0, 1.0, 1.0, 1.5]), damping=study.Rayleigh(0.1, 0.02), load=_Pull()
)


def _phase(problem, scheme, dt=DT, steps=STEPS, **arguments):
    ds = study.run(problem, scheme, dt=dt, steps=steps, **arguments)
    assert (ds.status == 0).all()
    return np.stack([ds.u.values, ds.v.values])


#: One scheme of each way to ask for tangents and solutions.
WAYS = ["average_acceleration", "hht_alpha", "park", "bathe", "kr_alpha", "chung_lee", "energy_momentum", "gauss4"]


@cache
def _of_dense_tangent(scheme):
    return _phase(_damped_chain("dense"), scheme)


# iterations end at ten digits of a solution
@pytest.mark.parametrize("structure, tolerance", [("tridiagonal", 1e-11), (2, 1e-11), ("matrix_free", 1e-9)])
@pytest.mark.parametrize("scheme", WAYS)
def test_the_form_of_the_tangent_makes_no_difference(scheme, structure, tolerance):
    """With damping and a load."""
    trajectory = _phase(_damped_chain(structure), scheme)
    np.testing.assert_allclose(trajectory, _of_dense_tangent(scheme), rtol=0, atol=tolerance)


def test_uncoupled_oscillators_are_as_many_single_ones(kind):
    spring, u0 = CubicSpring(4.0, 0.5), np.linspace(-1, 2, N)
    common = {"mass": 2.0, "damping": 0.3}
    # one energy a strain: the mean force of a whole potential would couple them
    together = study.Problem(
        potential=study.StrainEnergy(lambda u: u, spring.potential), u0=u0, v0=np.full(N, 0.5), tangent=0,
        load=lambda t: jnp.full(N, jnp.cos(t)), **common,
    )  # fmt: skip
    single = study.Problem(spring.force, 1.0, 0.5, potential=spring.potential, load=jnp.cos, **common)
    of_lanes = np.moveaxis(_phase(single, kind, u0=u0), 1, 2)
    np.testing.assert_allclose(_phase(together, kind), of_lanes, rtol=0, atol=1e-12)


LENGTH = 3.0443
ELASTIC = study.StrainEnergy(lambda u: (jnp.vdot(u, u) - LENGTH**2)[None], lambda e: 1e3 / (8 * LENGTH**3) * e**2)


@pytest.mark.parametrize(
    "scheme",
    ["average_acceleration", "central_difference", "hht_alpha", "bathe", "rk4", "gauss4", "implicit_midpoint",
     "energy_momentum", "average_vector_field"],
)  # fmt: skip
def test_no_direction_is_special(scheme):
    """A turn of the coordinates turns the motion of an elastic pendulum."""
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    u0, v0 = np.array([LENGTH, 0.0]), np.array([0.0, 7.72])
    straight, turned = (
        _phase(study.Problem(potential=ELASTIC, u0=t @ u0, v0=t @ v0, mass=10.0), scheme, dt=0.02, steps=100)
        for t in (np.eye(2), turn)
    )
    np.testing.assert_allclose(turned, straight @ turn.T, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", [name for name, scheme in study.schemes.items() if not scheme.needs_mass])
def test_a_joint_without_mass_leaves_the_springs_in_series(name):
    """6 and 3 are 2."""
    stiffness, (u0, v0) = np.array([6.0, 3.0]), (0.9, 0.6)
    springs = study.StrainEnergy(_elongations, lambda e: stiffness * e * e / 2)
    # the joint starts in balance
    series = study.Problem(potential=springs, u0=[u0 / 3, u0], v0=[v0 / 3, v0], mass=[0.0, 2.0])
    single = study.Problem(lambda u: 2 * u, u0, v0, potential=lambda u: u * u, mass=2.0)
    both = _phase(series, name)
    np.testing.assert_allclose(both[..., 1], _phase(single, name), rtol=0, atol=1e-9)
    # Wilson's balance is beyond the end of the step
    if name != "wilson_theta":
        np.testing.assert_allclose(both[0, :, 0], both[0, :, 1] / 3, rtol=0, atol=1e-9)


def _balance(problem, scheme, dt, steps, **arguments):
    ds = study.run(problem, scheme, dt=dt, steps=steps, observe=["energy_balance"], **arguments)
    assert (ds.status == 0).all()
    return ds


def test_the_trapezoidal_rule_balances_a_linear_structure_to_round_off():
    problem = _damped_chain(density=lambda e: e * e / 2)
    ds = _balance(problem, "average_acceleration", dt=0.2, steps=200)
    assert ds.max_energy_imbalance < 1e-11
    assert ds.dissipated_energy > 0.1 and abs(ds.work_of_load) > 0.01


@pytest.mark.parametrize("scheme", ["average_acceleration", "implicit_midpoint", "energy_momentum", "rk4", "gauss4"])
def test_the_balance_closes_with_the_second_order(scheme):
    problem = _damped_chain("tridiagonal")
    errors = [_balance(problem, scheme, 4 / n, n).max_energy_imbalance.item() for n in (100, 200, 400)]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2, abs=0.1)


def test_what_rests_is_in_balance():
    ds = _balance(study.Problem(potential=lambda u: u @ u, u0=np.zeros(3)), "average_acceleration", DT, STEPS)
    assert ds.max_energy_imbalance == 0


def test_a_blow_up_is_no_loss():
    """Of the energy that was there at the start it is many times as much."""
    stiff = study.Problem(lambda u: 100 * u, 1.0, potential=lambda u: 50 * u * u)
    assert _balance(stiff, "central_difference", 0.25, 20).max_energy_imbalance > 1e4


def test_an_oscillator_dissipates_all_that_it_had():
    problem = study.Problem(lambda u: 9 * u, 0.5, 2.0, potential=lambda u: 4.5 * u * u, mass=2.0, damping=1.2)
    ds = _balance(problem, "average_acceleration", dt=0.02, steps=5000)
    assert ds.dissipated_energy.item() == pytest.approx(4.5 * 0.25 + 4, rel=1e-10)
    assert ds.work_of_load == 0


def test_half_of_the_work_of_a_load_that_stays_is_dissipated():
    """f²/k is the work, half of it the energy of the spring in the end."""
    problem = study.Problem(
        lambda u: 9 * u, 0.0, potential=lambda u: 4.5 * u * u, mass=2.0, damping=1.2, load=lambda t: jnp.asarray(3.0)
    )
    ds = _balance(problem, "average_acceleration", dt=0.02, steps=5000)
    assert ds.work_of_load.item() == pytest.approx(1, rel=1e-10)
    assert ds.dissipated_energy.item() == pytest.approx(0.5, rel=1e-10)


def test_lanes_balance_as_single_runs():
    problem, starts = _damped_chain("tridiagonal"), np.linspace(0.2, 1, N) * np.array([[0.5], [1.0], [1.5]])
    lanes = _balance(problem, "average_acceleration", DT, STEPS, u0=starts)
    assert lanes.dissipated_energy.dims == ("lane",)
    for lane, u0 in enumerate(starts):
        alone = _balance(problem, "average_acceleration", DT, STEPS, u0=u0)
        for name in ("max_energy_imbalance", "dissipated_energy", "work_of_load"):
            assert lanes[name][lane].item() == pytest.approx(alone[name].item(), rel=1e-9)


@pytest.fixture
def small_truss(monkeypatch):
    monkeypatch.setattr(trusses, "TRUSS", (4, 1))


def test_what_a_spinning_truss_conserves(small_truss):
    """Energy-momentum all of it; the midpoint rule the momenta."""
    problem = trusses.spinning_truss()
    ours, midpoint = (
        study.run(problem, name, dt=0.1, steps=100, observe=["max_energy_error", "momentum_errors"])
        for name in ("energy_momentum", "implicit_midpoint")
    )
    for ds in (ours, midpoint):
        assert ds.status == 0
        assert ds.max_linear_momentum_error < 1e-10 and ds.max_angular_momentum_error < 1e-10
    assert ours.max_energy_error < 1e-8 < 1e-3 < midpoint.max_energy_error


def test_momenta_in_space_are_those_in_the_plane():
    """Two masses on a spring, in their plane and turned out of it; Houbolt's method keeps no angular momentum."""
    places, speeds = np.array([[-1.0, 0.0], [1.0, 0.0]]), np.array([[0.3, -1.0], [0.1, 1.0]])
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0][:, :2].T

    def observed(places, speeds, scheme):
        def strains(u):
            first, second = places + u.reshape(places.shape)
            return (jnp.linalg.norm(second - first) - 2)[None]

        energy = study.StrainEnergy(strains, lambda e: 5 * e * e)
        pair = study.Problem(potential=energy, u0=np.zeros(places.size), v0=speeds.ravel(), positions=places)
        return study.run(pair, scheme, dt=0.1, steps=50, observe=["momentum_errors"])

    plane, space = observed(places, speeds, "houbolt"), observed(places @ turn, speeds @ turn, "houbolt")
    for name in ("max_linear_momentum_error", "max_angular_momentum_error"):
        assert space[name].item() == pytest.approx(plane[name].item(), abs=1e-12)
    assert plane.max_linear_momentum_error < 1e-12 and plane.max_angular_momentum_error > 1e-3
    assert observed(places @ turn, speeds @ turn, "energy_momentum").max_angular_momentum_error < 1e-12


def _of_chain(u):
    return jnp.sum(_hardening(_elongations(u)))


@pytest.mark.parametrize("structure", ["tridiagonal", "matrix_free"])
def test_a_mean_force_of_the_whole_potential_couples_all(structure):
    problem = study.Problem(potential=_of_chain, u0=np.linspace(0, 1, N), v0=np.zeros(N), tangent=structure)
    with pytest.raises(ValueError, match=r"makes the tangent of 'unnamed problem' full: give it a StrainEnergy"):
        study.run(problem, "energy_momentum", dt=DT, steps=1)


def test_a_mean_force_of_the_whole_potential_keeps_its_energy():
    problem = study.Problem(potential=_of_chain, u0=np.linspace(0, 1, N), v0=np.zeros(N), tangent="dense")
    ds = study.run(problem, "energy_momentum", dt=0.3, steps=200, observe=["max_energy_error"])
    assert ds.status == 0 and ds.max_energy_error < 1e-9


def test_a_soliton_keeps_its_form():
    """Until its far flank comes to the end: at t = 10 it is in the middle of forty masses."""
    ds = study.run(chains.toda_chain(40), "rk4", dt=0.01, steps=1000, every=1000)
    for found, exact in zip((ds.u, ds.v), chains.toda_soliton(40, 10.0), strict=True):
        np.testing.assert_allclose(found[-1], exact, rtol=0, atol=1e-6)


def test_period_of_the_pendulum_near_its_top():
    problem = oscillators.pendulum()
    speed = float(problem.v0)
    period = float(4 * mpmath.ellipk(mpmath.mpf(speed) ** 2 / 4))
    assert period == pytest.approx(33.7210, abs=5e-5)
    end = study.run(problem, "gauss4", dt=period / 2 / 4000, steps=4000, every=4000).isel(t=-1)
    assert end.u.item() == pytest.approx(0, abs=1e-5)
    assert end.v.item() == pytest.approx(-speed, abs=1e-9)


def test_a_cantilever_comes_to_rest_where_its_forces_balance(small_truss):
    light = trusses.cantilever_truss()
    heavy = study.Problem(
        potential=light.potential, u0=light.u0, v0=light.v0, damping=study.Rayleigh(4.0, 0.01), load=light.load,
        tangent=light.tangent,
    )  # fmt: skip
    end = study.run(heavy, "average_acceleration", dt=0.1, steps=200, every=200).isel(t=-1)
    assert np.abs(end.u).max() > 1e-3
    np.testing.assert_allclose(heavy.force(end.u.values), light.load(0.0), rtol=0, atol=1e-9)
    np.testing.assert_allclose(end.v, 0, atol=1e-10)


def test_a_quantity_of_ones_own_is_recorded():
    first = study.Quantity(partial(chains.oscillatory_energy, 0), "i_1", "energy of the first spring", "J")
    ds = study.run(chains.fpu_chain(), "rk4", dt=0.002, steps=10, observe=["trajectory", first])
    assert ds.i_1.dims == ("t",) and ds.i_1.attrs == {"long_name": "energy of the first spring", "units": "J"}
    assert ds.i_1[0] == pytest.approx(1.0)
    np.testing.assert_allclose(ds.i_1, (ds.v[:, 3] ** 2 + 2500 * ds.u[:, 3] ** 2) / 2, rtol=1e-12)


@pytest.mark.parametrize("name", ["stiff_soft", "stiff_soft_sine", "elastic_pendulum", "fpu_chain", "impact_bar"])
def test_forces_of_named_structures_are_slopes_of_their_energies(name):
    """By differences along a random direction."""
    problem = study.problems[name]
    rng = np.random.default_rng(0)
    u, direction = rng.normal(size=(2, problem.u0.size)) / problem.u0.size
    energy, step = jax.jit(problem.potential), 1e-5
    slope = (energy(u + step * direction) - energy(u - step * direction)) / (2 * step)
    assert float(slope) == pytest.approx(float(problem.force(jnp.asarray(u)) @ direction), rel=1e-7)


def test_memory_grows_with_the_unknowns_and_no_faster():
    """Numbers that the compiled march of a bar keeps for each unknown, its tridiagonal tangent among them."""

    def kept(n):
        definition = March(chains.impact_bar(n), study.schemes["average_acceleration"], (), ())
        arguments = definition, np.zeros(n), np.float64(1 / n), np.asarray(1), np.asarray(1)
        return march.lower(*arguments).compile().compiled.memory_analysis().temp_size_in_bytes / 8 / n

    assert kept(1000) == pytest.approx(kept(100_000), rel=0.05)
    assert kept(100_000) < 25
