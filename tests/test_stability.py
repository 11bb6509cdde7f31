"""Lyapunov exponents of numerical maps, fates of runs, roots of effective equations, and the maps themselves."""

import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given, settings
from hypothesis import strategies as st

import study
from reference.amplitudes import amplitudes
from study.analysis.effective_equation import effective_coefficient, number_of_roots
from study.analysis.linear_theory import LinearTheory, oscillator
from study.analysis.outcomes import OUTCOMES, outcomes
from study.equilibrium.newton import MAX_ITERATIONS
from study.experiments.atlas import atlas
from study.experiments.bifurcation import bifurcation
from study.experiments.numerical_map import numerical_map
from study.experiments.robustness import robustness
from study.experiments.roots import roots
from study.experiments.structure_stability import structure_stability
from study.marching.march import COMPLETED, NEWTON_FAILED, March, march
from study.observer.fate import Fate
from study.problem.loads import excited
from study.problem.springs import CubicSpring
from study.scheme.linearised import Linearised

#: More amplitudes than a tile of an ensemble has lanes.
MANY = {"first": -1.0, "last": 1.0, "count": 150}
EXPONENTS = {"first": -1.0, "last": 1.0, "count": 6}
GRID = {"first": -1.5, "last": 0.0, "count": 7}


@pytest.fixture
def springs(tmp_path, monkeypatch):
    """A folder with the exact periods over two decades of amplitude."""
    monkeypatch.chdir(tmp_path)
    dataset = amplitudes(["hardening", "softening", "double_well"], EXPONENTS)
    study.datasets.write(dataset.assign_attrs(source=study.datasets.SOURCE), "results/reference/amplitudes.nc")
    return dataset


def test_the_derivative_of_a_step_is_that_of_differences(kind):
    scheme, problem, dt = study.schemes[kind], study.problems["hardening"], jnp.asarray(0.012)
    state, _ = scheme.start(problem, jnp.asarray(1.1), jnp.asarray(3.0), dt)
    direction = jax.tree.map(lambda part: 0.3 * jnp.ones_like(part), state)

    def step(state):
        return scheme.step(problem, state, jnp.asarray(0.0), dt)[0]

    def moved(part):
        return jax.tree.leaves(step(jax.tree.map(lambda x, d: x + part * d, state, direction)))

    _, tangent = jax.jvp(step, (state,), (direction,))
    for exact, ahead, behind in zip(jax.tree.leaves(tangent), moved(1e-5), moved(-1e-5), strict=True):
        np.testing.assert_allclose(exact, (ahead - behind) / 2e-5, rtol=1e-6, atol=1e-6)


def test_a_stretched_linear_map_grows_by_its_spectral_radius():
    dt = 1.1 * 2  # ωΔt beyond the limit of central difference
    rho = LinearTheory("central_difference", np.array([dt / (2 * np.pi)])).spectral_radius[0]
    ds = study.run(oscillator(), "central_difference", dt=dt, steps=400, observe=["lyapunov_exponent"])
    assert ds.lyapunov_exponent.item() * dt == pytest.approx(np.log(rho), rel=0.01)
    # |δ| = ρⁿ passes 2³³, a step or two sooner or later
    assert ds.apart_from.item() / dt == pytest.approx(np.log(2.0**33) / np.log(rho), abs=3)


def test_a_regular_map_has_no_exponent_and_neighbours_stay():
    ds = study.run("hardening", "average_acceleration", dt=0.0075, steps=20_000, observe=["lyapunov_exponent"])
    assert abs(ds.lyapunov_exponent.item() * 0.15) < 0.02 and np.isinf(ds.apart_from)


def test_neighbours_part_as_two_runs_do():
    u0, dt, steps = 0.5, 2.5, 400
    ds = study.run("double_well", "average_acceleration", dt=dt, steps=steps, observe=["lyapunov_exponent"])
    pair = study.run("double_well", "average_acceleration", dt=dt, steps=steps, u0=np.array([u0, u0 + 1e-10])).u
    met = int(np.argmax(np.abs(pair[1] - pair[0]).values > 1e-2))
    alone = study.run("double_well", "average_acceleration", dt=dt, steps=met, observe=["lyapunov_exponent"])
    assert ds.lyapunov_exponent.item() * dt > 0.1
    # ln of the growth so far, which the pair shows as long as it is small
    assert alone.lyapunov_exponent.item() * met * dt == pytest.approx(np.log(1e-2 / 1e-10), abs=2.5)


def test_a_neighbour_that_a_step_has_brought_to_the_run_stays_with_it():
    scheme, problem, dt = Linearised(study.schemes["rk4"]), study.problems["hardening"], jnp.asarray(0.01)
    start, _ = scheme.start(problem, jnp.asarray(1.0), jnp.asarray(0.0), dt)
    together = start._replace(distance=jax.tree.map(jnp.zeros_like, start.distance))
    state, _ = scheme.step(problem, together, jnp.asarray(0.0), dt)
    assert all(part == 0 for part in jax.tree.leaves(state.distance))


@pytest.mark.parametrize("n", [1, 4])
def test_equal_unknowns_have_the_exponent_of_one(n):
    problem = study.Problem(lambda u: -2 * u, np.ones(n), np.zeros(n))
    ds = study.run(problem, "rk4", dt=0.01, steps=2000, observe=["lyapunov_exponent"])
    # of √2, with a length of one at the start
    assert ds.lyapunov_exponent.item() == pytest.approx(np.sqrt(2) + np.log(np.sqrt(3) / 2) / 20, rel=1e-4)


def test_a_free_structure_is_not_only_shifted():
    problem = study.Problem(lambda u: jnp.stack([u[1] - u[0], u[0] - u[1]]), [0.0, 0.1], [0.0, 0.0])
    ds = study.run(problem, "rk4", dt=0.01, steps=2000, observe=["lyapunov_exponent"])
    assert ds.lyapunov_exponent.item() == pytest.approx(np.sqrt(2), rel=0.05)


@pytest.mark.parametrize(
    "problem, u0, scheme, dt, steps, outcome",
    [
        ("hardening", 1.5, "average_acceleration", 0.15 / 200, 4000, "accurate"),
        ("hardening", -1.5, "average_acceleration", 0.15 / 10, 400, "bounded"),
        ("hardening", 1.5, "houbolt", 0.15 / 10, 4000, "damped_to_rest"),
        ("double_well", 0.5, "houbolt", 6.0, 100, "in_the_wrong_well"),
        ("double_well", -0.5, "rk4", 0.02, 1000, "accurate"),
        ("double_well", 0.5, "average_acceleration", 2.5, 400, "chaotic"),
        ("softening", 0.05, "central_difference", 0.25, 400, "growing"),
        ("softening", 4.0, "houbolt", 1.0, 400, "newton_not_converged"),
        ("hardening", 1.5, "central_difference", 0.15, 400, "not_finite"),
    ],
)
def test_how_runs_end(problem, u0, scheme, dt, steps, outcome):
    definition = study.problems[problem]
    runs = study.run(problem, scheme, dt=dt, steps=steps, u0=[u0], observe=[Fate.of(definition), "lyapunov_exponent"])
    ended, began = outcomes(runs)
    assert OUTCOMES[ended[0]] == outcome
    assert np.isnan(began[0]) == (outcome == "accurate" or runs.status.item() > 0)
    assert np.isnan(began[0]) or 0 < began[0] <= steps * dt


def test_a_motion_that_is_damped_out_of_chaos_was_not_chaotic():
    # neighbours part at first, then all come to rest
    definition = study.problems["softening"]
    observe = [Fate.of(definition), "lyapunov_exponent"]
    runs = study.run(
        definition, "wilson_theta", dt=np.linspace(0.05, 0.4, 64), steps=4000, u0=[10.0] * 64, observe=observe
    )
    ended, _ = outcomes(runs)
    chaotic = ended == OUTCOMES.index("chaotic")
    assert (runs.lyapunov_exponent.values[chaotic] > 0).all()


@pytest.mark.parametrize(
    "problem, sentence",
    [
        (study.Problem(lambda u: u, 1.0, title="own"), "needs Problem(potential=...)"),
        (study.Problem(lambda u: u, [1.0, 2.0], potential=lambda u: (u * u).sum() / 2, title="own"), "more than one"),
        (study.Problem(lambda u: -u, 1.0, potential=lambda u: -u * u / 2, title="own"), "has no minimum downhill"),
        (study.Problem(lambda u: 1.0 + 0 * u, 1.0, potential=lambda u: u, title="own"), "has no minimum downhill"),
        ("duffing_chaotic", "damping or a load change its energy"),
    ],
)
def test_no_fate_without_a_rest(problem, sentence):
    with pytest.raises(ValueError) as caught:
        Fate.of(problem)
    assert sentence in str(caught.value)


def test_no_fate_of_a_structure():
    with pytest.raises(ValueError, match="has more than one unknown"):
        study.run("fpu_chain", "rk4", dt=0.01, steps=10, observe=[Fate(0.0)])


@pytest.mark.parametrize("observe", [["max_energy_error"], ["lyapunov_exponent"], [Fate.of("double_well")]])
def test_no_outcome_of_what_was_not_observed(observe):
    runs = study.run("double_well", "average_acceleration", dt=2.5, steps=10, u0=[0.5], observe=observe)
    with pytest.raises(ValueError, match=r"have Fate.of\(problem\) and 'lyapunov_exponent' observed"):
        outcomes(runs)


def test_the_energy_momentum_method_converges_at_small_amplitude_too():
    """Where the potential of the softening spring is a difference of numbers that are much larger."""
    u0 = np.array([0.126, 0.141, 0.175, 0.195])
    runs = study.run(
        "softening", "energy_momentum", dt=0.6290 / 256, u0=u0, steps=100_000, observe=["max_energy_error"]
    )
    assert (runs.status == 0).all()


def test_the_rest_lies_downhill_and_a_hill_is_seen():
    well, spring = Fate.of(study.problems["double_well"]), Fate.of(study.problems["softening"])
    assert well.rest == pytest.approx(-0.125, abs=1e-9) and well.barrier == 0.0
    assert spring.rest == pytest.approx(0.0, abs=1e-9) and spring.barrier is None


def test_a_run_from_above_the_hill_is_in_no_wrong_well():
    ds = study.run(
        "double_well", "rk4", dt=0.02, steps=2000, u0=[0.5, 2.0], observe=[Fate.of(study.problems["double_well"])]
    )
    assert np.isinf(ds.crossed_at).all()


def test_after_a_period_a_motion_is_at_rest_where_it_was(springs):
    for name in springs.problem.values:
        one, parts = springs.sel(problem=name), 20_000
        ends = study.run(name, "rk4", dt=one.period.values / parts, u0=one.u0.values, steps=parts, every=parts)
        late = ends.v[:, -1].values / np.asarray(jax.vmap(study.problems[name].force)(one.u0.values))
        assert np.abs(late / one.period.values).max() < 1e-11
        np.testing.assert_allclose(ends.u[:, -1], one.u0.values, rtol=1e-10)


def test_the_highest_frequency_is_that_of_the_tangent_on_the_way(springs):
    one = springs.isel(amplitude=2)
    hard, soft, well = (one.sel(problem=name) for name in springs.problem.values)
    assert hard.highest_frequency.item() == pytest.approx(np.sqrt(100 * (1 + 30 * hard.u0.item() ** 2)))
    assert soft.highest_frequency.item() == pytest.approx(10.0)
    # from u₀ < 1 the far turning point has u² = 2 − u₀²
    assert well.highest_frequency.item() == pytest.approx(np.sqrt(-0.5 + 1.5 * (2 - well.u0.item() ** 2)))


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "gauss4", "rk4"])
def test_a_map_does_not_depend_on_its_tiles_nor_on_the_cores(springs, monkeypatch, scheme):
    many = amplitudes(["softening", "double_well"], MANY)
    study.datasets.write(many.assign_attrs(source=study.datasets.SOURCE), "results/reference/amplitudes.nc")
    portraits = {"points": 3, "samples": 5}
    arguments = {
        "problems": ["softening", "double_well"],
        "dt_over_period": GRID,
        "periods": 20,
        "portraits": portraits,
    }
    whole, _ = atlas(scheme, **arguments, tile=0, tiles=1)
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    tiles = [atlas(scheme, **arguments, tile=tile, tiles=3) for tile in range(3)]
    for tile, (part, _) in enumerate(tiles):
        study.datasets.write(part.assign_attrs(source=study.datasets.SOURCE), f"{tile}.nc")
    gather = [sys.executable, "-m", "study.pipeline.gather", "gathered.nc", "scheme,amplitude", *(f"{k}.nc" for k in range(3))]
    subprocess.run(gather, check=True)
    xr.testing.assert_identical(xr.load_dataset("gathered.nc").drop_attrs(), whole.drop_attrs())


def test_a_tile_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="there is no tile -1 among 3"):
        atlas("rk4", ["hardening"], GRID, 20, {"points": 3, "samples": 5}, tile=-1, tiles=3)


def test_the_samples_of_an_orbit_that_closes_do_not_fall_into_one_place(springs):
    _, samples = atlas("rk4", ["hardening"], GRID, 100, {"points": 7, "samples": 20}, tile=0, tiles=1)
    for every in samples.every.values.tolist():
        assert every >= 2 and all(every % n for n in range(2, every))


def test_a_map_shows_the_linear_limit_at_small_amplitude(springs):
    fine = {"first": -0.7, "last": -0.3, "count": 41}
    one, _ = atlas("central_difference", ["hardening"], fine, 300, {"points": 2, "samples": 2}, tile=0, tiles=6)
    one = one.squeeze()
    lost = one.outcome.values >= OUTCOMES.index("growing")
    first = one.dt_over_period.values[lost.argmax()]
    limit = 2 / (one.highest_frequency * one.period).item()
    # the tangent is as stiff as that at one end of the swing only
    assert limit * 0.9 < first < 1.15 * limit


@given(
    S1=st.floats(-5, 5).filter(lambda x: abs(x) > 0.1),
    S2=st.floats(-2, 2).filter(lambda x: abs(x) > 1e-3),
    c=st.floats(0.01, 10),
    predictor=st.floats(-1, 1),
)
@example(S1=1.0, S2=-0.25, c=1.0, predictor=0.0)
@settings(max_examples=40, deadline=None)
def test_roots_of_a_cubic_effective_equation(S1, S2, c, predictor):
    spring = CubicSpring(S1, S2)
    exact = np.roots([c * S1 * S2, 0, 1 + c * S1, -predictor])
    real = exact[np.abs(exact.imag) < 1e-9].real
    apart = np.diff(np.sort(real))
    # two roots nearer than the search sees, or beyond where it looks, are not asked about
    if len(real) and np.abs(real).max() < 3.9 and (not len(apart) or apart.min() > 0.01):
        found = number_of_roots(study.Problem(spring.force, 1.0, 0.0), np.array([c]), np.array([predictor, 1.0, -1.0]))
        assert found[0, 0] == len(real)


@pytest.mark.parametrize(
    "name", ["average_acceleration", "newmark_dissipative", "hht_alpha", "wilson_theta", "houbolt"]
)
def test_the_coefficient_of_the_effective_equation_is_where_a_step_is_singular(name):
    scheme, dt = study.schemes[name], 0.7
    kappa = effective_coefficient(scheme)

    def size_of_step(stiffness):
        problem = study.Problem(lambda u: stiffness * u, 1.0, 0.3)
        state, _ = study.schemes["average_acceleration"].start(problem, jnp.asarray(1.0), jnp.asarray(0.3), dt)
        if name == "houbolt":
            state, _ = scheme.start(study.Problem(lambda u: 0 * u, 1.0, 0.3), jnp.asarray(1.0), jnp.asarray(0.3), dt)
        return abs(float(scheme.step(problem, state, 0.0, dt)[0].u))

    singular = -1 / (kappa * dt**2)
    assert size_of_step(singular * (1 + 1e-9)) > 1e6 > size_of_step(singular * 1.1)


def test_schemes_of_several_equations_have_no_coefficient():
    with pytest.raises(ValueError, match=r"a step of 'Bathe' is not one effective equation"):
        effective_coefficient(study.schemes["bathe"])


def test_newton_finds_the_root_that_its_start_is_near():
    grid = {"first": -2.0, "last": 2.0, "count": 9}
    ds = roots("double_well", ["houbolt"], {"first": 1, "last": 3, "count": 5}, grid, 2.5, [1e-3], steps=20)
    at_rest = ds.root.sel(scheme="houbolt", predictor=0.0)
    # u + c p(u) = 0 with c = 3.125: 0 and ±√(1 − 2/c)
    assert set(np.round(at_rest.dropna("guess").values, 9)) == {-0.6, 0.0, 0.6}
    assert (ds.number_of_roots.sel(scheme="houbolt", predictor=0.0, dt=[1.0, 3.0]) == [1, 3]).all()


def test_the_steps_that_are_enough_are_enough(springs):
    ds = robustness(["hardening"], ["average_acceleration", "houbolt"], [8, 16, 32, 64, 128], [10, 50])
    needed = ds.steps_needed.sel(problem="hardening", scheme="average_acceleration")
    assert (needed.sel(level=1) > needed.sel(level=10)).all() and needed.notnull().all()
    assert ds.steps_needed.sel(scheme="houbolt", periods=50, level=1).isnull().all()
    one, enough = springs.sel(problem="hardening"), int(needed.sel(level=5, periods=50).item())
    for steps, kept in ((enough, True), (enough // 2, False)):
        runs = study.run(
            "hardening",
            "average_acceleration",
            dt=one.period.values / steps,
            u0=one.u0.values,
            steps=50 * steps,
            observe=["max_energy_error"],
        )
        assert bool((runs.max_energy_error <= 5).all()) == kept


def test_how_many_steps_are_enough_does_not_depend_on_longer_runs(springs):
    """Also where runs fail later."""
    short = robustness(["double_well"], ["average_acceleration"], [3, 4, 5, 20], [20])
    both = robustness(["double_well"], ["average_acceleration"], [3, 4, 5, 20], [20, 200])
    xr.testing.assert_equal(short.steps_needed.isel(periods=0, drop=True), both.steps_needed.isel(periods=0, drop=True))


def test_a_bifurcation_diagram_tells_order_from_chaos():
    ds = bifurcation("double_well", "average_acceleration", {"first": 1.0, "last": 2.6, "count": 5}, 600, 50, 1e-10)
    regular, chaotic = ds.isel(dt=0), ds.isel(dt=-1)
    assert regular.lyapunov_exponent < 0.05 < chaotic.lyapunov_exponent
    assert regular.steps_until_apart == -1 and 0 < chaotic.steps_until_apart < 600
    assert (regular.u > 0).all() and chaotic.u.min() < 0 < chaotic.u.max()


def test_a_bifurcation_diagram_shows_what_was_before_a_failure():
    ds = bifurcation("double_well", "average_acceleration", {"first": 3.0, "last": 4.0, "count": 5}, 2000, 50, 1e-10)
    assert (ds.status == NEWTON_FAILED).all()
    np.testing.assert_array_equal(ds.u.notnull().sum("iterate"), np.minimum(ds.failed_at_step, 50))
    assert (ds.u.max("iterate") > 0).all() and (ds.lyapunov_exponent > 0).all()
    alone = study.run("double_well", "average_acceleration", dt=3.0, steps=int(ds.failed_at_step[0]) - 1)
    np.testing.assert_allclose(ds.u.isel(dt=0, iterate=-1), alone.u[-1], rtol=1e-3)


def test_the_numerical_map_keeps_every_iterate():
    ds = numerical_map(
        "double_well", ["energy_momentum"], [1.0, 2.0], {"first": 0.5, "last": 1.2, "count": 3}, steps=20
    )
    alone = study.run("double_well", "energy_momentum", dt=2.0, u0=[1.2], steps=20)
    np.testing.assert_allclose(ds.u.sel(scheme="energy_momentum", dt=2.0, u0=1.2), alone.u[0], rtol=1e-6)
    assert (ds.status == 0).all()


def test_a_coarse_step_can_tame_chaos():
    one = [{"problem": "duffing_chaotic", "periods": 200}]
    ds = structure_stability(one, ["central_difference", "rk4"], [1], [14, 80]).squeeze()
    assert ds.lyapunov_exponent.sel(scheme="central_difference", steps_per_period=14) < -0.3
    assert (ds.lyapunov_exponent.sel(steps_per_period=80) > 0.3).all()


def test_structures_end_as_their_energies_say():
    one = [{"problem": "pendulum", "periods": 20}]
    ds = structure_stability(one, ["central_difference", "energy_momentum"], [0.5, 1], [4, 320]).squeeze()
    names = np.array(OUTCOMES)[ds.outcome.values]
    # four steps in its time scale are beyond the limit of stability of its small oscillations, 2
    assert (names[0, :, 0] == "growing").all() and (names[:, :, 1] == "accurate").all()
    assert names[1, 0, 0] == "newton_not_converged" and ds.status.sel(scheme="energy_momentum")[0, 0] == 1
    iterations = ds.max_newton_iterations
    assert (iterations.sel(scheme="central_difference") == 0).all()
    assert iterations.sel(scheme="energy_momentum").values[:, 1].max() < MAX_ITERATIONS == iterations.max()
    assert ds.apart_at_step.max() < 20 * 320 and ds.apart_at_step.min() == -1


def test_an_excitation_scales_velocity_and_load():
    pendulum, duffing = (study.problems[name] for name in ("pendulum", "duffing_chaotic"))
    assert excited(pendulum, 0.5).v0 == 0.5 * pendulum.v0 and excited(pendulum, 0.5).load is None
    t = jnp.asarray(0.3)
    assert excited(duffing, 3.0).load(t) == pytest.approx(3 * duffing.load(t))
    assert excited(duffing, 3.0).u0 == duffing.u0


def test_a_failed_lane_is_frozen_whole_with_its_neighbour():
    definition = March(
        study.problems["double_well"], Linearised(study.schemes["average_acceleration"]), (), (), lanes=True
    )
    numbers = np.asarray(1000), np.asarray(1)
    (progress, _), outcome = march(definition, jnp.full(2, 0.5), jnp.asarray([0.1, 3.5]), *numbers)
    assert outcome.status.tolist() == [COMPLETED, NEWTON_FAILED] and outcome.failed_at_step[1] < 1000
    # NaN, on which Newton's iteration ends at once
    assert all(np.isnan(part[1]) and np.isfinite(part[0]) for part in jax.tree.leaves(progress.state.inner))
