"""Records of ground motion, and structures on moving ground."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

import study
from study.mechanics.ground import GroundLoad


def test_the_record_of_el_centro_has_the_published_peak():
    record = study.GroundMotion.el_centro()
    assert len(record.acceleration) == 1560 and record.acceleration[0] == 0
    assert record.dt == 0.02 and record.duration == pytest.approx(31.18)
    assert np.abs(record.acceleration).max() / 9.80665 == pytest.approx(0.319, abs=0.001)


def test_the_motion_is_linear_between_samples_and_zero_after_the_last():
    record = study.GroundMotion(np.array([0.0, 1.0, -2.0, 0.5]), 0.3)
    t = np.linspace(0, 1.5, 301)
    values = np.array([float(record(jnp.asarray(x))) for x in t])
    expected = np.where(t < 0.9 - 1e-12, np.interp(t, record.kinks, record.acceleration), 0.0)
    np.testing.assert_allclose(values, expected, atol=1e-12)
    np.testing.assert_allclose(record.scaled(2.0).acceleration, [0, 2, -4, 1])


@pytest.mark.slow
def test_velocity_and_displacement_are_the_integrals_of_the_acceleration():
    record = study.GroundMotion(np.array([0.0, 1.0, -2.0, 0.5]), 0.3)
    t = np.linspace(0, 1.5, 60_001)
    a = np.where(t < 0.9, np.interp(t, record.kinks, record.acceleration), 0.0)
    v = cumulative_trapezoid(a, t, initial=0.0)
    u = cumulative_trapezoid(v, t, initial=0.0)
    samples = slice(None, None, 1000)
    np.testing.assert_allclose(jax.vmap(record.velocity)(t[samples]), v[samples], atol=1e-4)
    np.testing.assert_allclose(jax.vmap(record.displacement)(t[samples]), u[samples], atol=1e-4)


def test_a_loose_mass_stays_where_it_is_while_the_ground_moves():
    ground = study.GroundMotion.el_centro()
    problem = study.Problem(lambda u: 0.0 * u, u0=np.zeros(2), ground=ground, influence=[1.0, 0.5], tangent="diagonal")
    ds = study.run(problem, "average_acceleration", dt=0.002, steps=2000, observe=["absolute_motion"])
    assert np.abs(ds.absolute_displacement).max() < 1e-5 and np.abs(ds.absolute_velocity).max() < 1e-10
    with pytest.raises(ValueError, match="absolute_displacement, absolute_velocity of 'hardening"):
        study.run("hardening", "rk4", dt=0.01, steps=2, observe=["absolute_motion"])


@pytest.mark.slow
def test_the_ground_is_a_load_on_every_mass():
    record = study.GroundMotion.el_centro()
    mass = np.array([2.0, 3.0])
    common = {"force": lambda u: 10 * u, "u0": np.zeros(2), "mass": mass}
    moved = study.Problem(**common, ground=record, influence=[1.0, 0.5], load=lambda t: jnp.ones(2))
    loaded = study.Problem(**common, load=lambda t: 1 - record(t) * mass * np.array([1.0, 0.5]))
    arguments = {"scheme": "average_acceleration", "dt": 0.013, "steps": 200}
    np.testing.assert_allclose(study.run(moved, **arguments).u, study.run(loaded, **arguments).u, rtol=1e-12)
    assert isinstance(moved.load, GroundLoad) and moved.load.kinks[1] == pytest.approx(0.02)


@pytest.mark.parametrize(
    "wrong, sentence",
    [
        ({"duration": -1}, "duration must be a number greater than zero, not -1"),
        ({"dt": 0}, "dt must be a number greater than zero, not 0"),
        ({"rise": 0}, "rise must be a number greater than zero, not 0"),
        ({"decay": -1}, "decay must be a number of at least zero, not -1"),
    ],
)
def test_a_stochastic_record_has_times_greater_than_zero(wrong, sentence):
    with pytest.raises(ValueError, match=sentence):
        study.GroundMotion.kanai_tajimi(1, **wrong)


def test_motions_are_scaled_by_numbers_and_padded_in_a_list():
    motion = study.GroundMotion([0.1, 0.2], 0.01)
    with pytest.raises(TypeError, match="the factor of .* must be a number, not '2'"):
        motion.scaled("2")
    for motions in ((), motion):
        with pytest.raises(ValueError, match="padded takes a list of at least one GroundMotion"):
            study.GroundMotion.padded(motions)


@pytest.mark.slow
def test_a_place_that_rounds_to_either_side_of_a_sample_is_looked_up_once():
    """Lanes equal single runs even at samples, where XLA may compute t/Δt twice, with different round-off."""

    def shaken(intensity):
        ground = study.GroundMotion.el_centro().scaled(intensity)
        return study.Problem(lambda u: 100 * u, u0=np.zeros(2), ground=ground, tangent="diagonal")

    lanes = study.run(shaken, "rk4", dt=0.01, steps=400, over={"intensity": [1.0, 1.0]})
    alone = study.run(shaken(1.0), "rk4", dt=0.01, steps=400)
    np.testing.assert_allclose(lanes.u[0], alone.u, atol=1e-14)


def test_a_stochastic_motion_has_the_spectral_density_of_kanai_and_tajimi():
    settings = {"duration": 40.0, "rise": 1e-9, "fall": 40.0}  # no envelope
    motions = [study.GroundMotion.kanai_tajimi(seed, **settings).acceleration[1:] for seed in range(200)]
    dt, number = 0.02, len(motions[0])
    density = dt / (2 * np.pi * number) * np.mean(np.abs(np.fft.rfft(motions)) ** 2, axis=0)
    w, soil = 2 * np.pi * np.fft.rfftfreq(number, dt), 5 * np.pi
    filtered = (2 * 0.6 * soil * w) ** 2
    closed = 0.01 * (soil**4 + filtered) / ((soil**2 - w**2) ** 2 + filtered)
    bands = (density / closed)[1:-1].reshape(-1, 37).mean(axis=1)  # 27 bands
    np.testing.assert_allclose(bands, 1.0, atol=0.06)  # five standard deviations


def test_a_seed_and_an_envelope_make_a_stochastic_motion():
    first, again, second = (study.GroundMotion.kanai_tajimi(seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.acceleration, again.acceleration)
    assert np.abs(first.acceleration - second.acceleration).max() > 1
    steady = study.GroundMotion.kanai_tajimi(1, rise=1e-9, fall=30.0).acceleration[1:]
    t = first.kinks[1:]
    envelope = np.where(t < 2, t**2 / 4, np.where(t < 10, 1, np.exp(-0.4 * (t - 10))))
    np.testing.assert_allclose(first.acceleration[1:], envelope * steady, atol=1e-12)


def test_an_ensemble_runs_over_records_and_not_over_seeds():
    """Each lane equals the run on its own record."""
    motions = [study.GroundMotion.kanai_tajimi(seed, duration=3.0) for seed in (1, 2)]
    records = [motion.acceleration for motion in motions]

    def shaken(record):
        return study.Problem(lambda u: 100 * u, u0=0.0, ground=study.GroundMotion(record, 0.02))

    def seeded(seed):
        return study.Problem(lambda u: 100 * u, u0=0.0, ground=study.GroundMotion.kanai_tajimi(seed))

    run = {"scheme": "rk4", "dt": 0.02, "steps": 150}
    lanes = study.run(shaken, over={"record": records}, **run)
    for lane, record in zip(lanes.u, records, strict=True):
        np.testing.assert_allclose(lane, study.run(shaken(record), **run).u, atol=1e-13)
    with pytest.raises(
        ValueError, match=r"seed must be a whole number .*; for an ensemble over seeds, make the records"
    ):
        study.run(seeded, over={"seed": [1, 2]}, **run)
    with pytest.raises(ValueError, match=r"over\['record'\] has rows of different lengths: pad the shorter ones"):
        study.run(shaken, over={"record": [[1.0, 2.0], [1.0]]}, **run)


@pytest.mark.slow
def test_an_ensemble_runs_over_motions_of_unequal_lengths_and_spacings():
    """Each lane equals the run on its own motion, which ends in zero."""
    samples = np.sin(np.arange(300.0))
    motions = [study.GroundMotion([*samples[:n], 0.0], dt) for n, dt in ((100, 0.02), (300, 0.01), (60, 0.04))]
    accelerations, spacings = study.GroundMotion.padded(motions)

    def shaken(record):
        record = record.astype(int)
        ground = study.GroundMotion(jnp.asarray(accelerations)[record], jnp.asarray(spacings)[record])
        return study.Problem(lambda u: 100 * u, u0=0.0, ground=ground)

    run = {"scheme": "rk4", "dt": 0.01, "steps": 400}
    lanes = study.run(shaken, over={"record": np.arange(3)}, **run)
    for lane, motion in zip(lanes.u, motions, strict=True):
        alone = study.run(study.Problem(lambda u: 100 * u, u0=0.0, ground=motion), **run)
        np.testing.assert_allclose(lane, alone.u, atol=1e-13)


def test_unfit_grounds_get_a_sentence():
    record = study.GroundMotion([0.0, 1.0], 0.1)
    with pytest.raises(FileNotFoundError, match="there is no record 'nowhere'"):
        study.GroundMotion.read("nowhere", unit="g")
    with pytest.raises(ValueError, match="unit must be one of g, m/s2"):
        study.GroundMotion.read("nowhere", unit=["g"])  # type: ignore[arg-type]
    for samples in ([1j, 2j], ["a", "b"], [[1.0], [1.0, 2.0]], [[1.0, 2.0]]):
        with pytest.raises(ValueError, match=r"needs samples of acceleration as real numbers of shape \(samples,\)"):
            study.GroundMotion(samples, 0.1)
    with pytest.raises(ValueError, match="needs a time between samples as a real number, not"):
        study.GroundMotion([1.0, 2.0], [0.1, 0.2])
    with pytest.raises(ValueError, match="at least two samples"):
        study.GroundMotion([1.0], 0.1)
    with pytest.raises(ValueError, match="must be greater than zero, not 0"):
        study.GroundMotion([1.0, 2.0], 0.0)
    with pytest.raises(ValueError, match=r"'ground motion' has masked entries, the first at \[1\]"):
        study.GroundMotion(np.ma.array([0.0, 1e20], mask=[False, True]), 0.1)
    with pytest.raises(ValueError, match=r"influence must have the shape of u0, \(2,\), not \(3,\)"):
        study.Problem(lambda u: u, u0=[0.0, 0.0], ground=record, influence=[1.0, 1.0, 1.0])
    with pytest.raises(ValueError, match="influence needs Problem"):
        study.Problem(lambda u: u, u0=0.0, influence=1.0)
    with pytest.raises(TypeError, match="must be a study.GroundMotion"):
        study.Problem(lambda u: u, u0=0.0, ground=jnp.sin)
