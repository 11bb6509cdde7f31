"""Records of ground motion, and structures on moving ground."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

import study
from study.mechanics.ground import GroundLoad

HEADER = "a quake\nsome station\nacceleration in units of g\nNPTS= {}, DT= .02000 SEC\n"


def written(path, samples, count=None):
    rows = "\n".join(" ".join(f"{x:9.5f}" for x in samples[i : i + 8]) for i in range(0, len(samples), 8))
    path.write_text(HEADER.format(len(samples) if count is None else count) + rows + "\n")
    return path


def test_the_record_of_el_centro_has_the_published_peak():
    record = study.GroundMotion.el_centro()
    assert len(record.acceleration) == 1560 and record.acceleration[0] == 0
    assert record.dt == 0.02 and record.duration == pytest.approx(31.18)
    assert np.abs(record.acceleration).max() / 9.80665 == pytest.approx(0.319, abs=0.001)


def test_a_file_of_peer_is_read_in_metres(tmp_path):
    samples = np.array([0.1, -0.2, 0.3, 0.05, -0.4, 0.25, 0.1, 0.0, 0.2])
    record = study.GroundMotion.read(written(tmp_path / "quake.at2", samples), unit="g")
    np.testing.assert_allclose(record.acceleration, np.concatenate([[0], 9.80665 * samples]))
    assert record.title == "quake"


def test_two_columns_are_read_from_any_first_time(tmp_path):
    path = tmp_path / "columns.txt"
    path.write_text("# t a\n0.04, 1.0\n0.05, -2.0\n0.06, 0.5\n")
    record = study.GroundMotion.read(path, unit="cm/s2")
    np.testing.assert_allclose(record.acceleration, [0, 0, 0, 0, 0.01, -0.02, 0.005])
    assert record.dt == pytest.approx(0.01)


def test_the_motion_is_linear_between_samples_and_zero_after_the_last():
    record = study.GroundMotion(np.array([0.0, 1.0, -2.0, 0.5]), 0.3)
    t = np.linspace(0, 1.5, 301)
    got = np.array([float(record(jnp.asarray(x))) for x in t])
    wanted = np.where(t < 0.9 - 1e-12, np.interp(t, record.kinks, record.acceleration), 0.0)
    np.testing.assert_allclose(got, wanted, atol=1e-12)
    np.testing.assert_allclose(record.scaled(2.0).acceleration, [0, 2, -4, 1])


def test_velocity_and_displacement_are_the_integrals_of_the_acceleration():
    record = study.GroundMotion(np.array([0.0, 1.0, -2.0, 0.5]), 0.3)
    t = np.linspace(0, 1.5, 60_001)
    a = np.where(t < 0.9, np.interp(t, record.kinks, record.acceleration), 0.0)
    v = cumulative_trapezoid(a, t, initial=0.0)
    u = cumulative_trapezoid(v, t, initial=0.0)
    some = slice(None, None, 1000)
    np.testing.assert_allclose(jax.vmap(record.velocity)(t[some]), v[some], atol=1e-4)
    np.testing.assert_allclose(jax.vmap(record.displacement)(t[some]), u[some], atol=1e-4)


def test_a_loose_mass_stays_where_it_is_while_the_ground_moves():
    ground = study.GroundMotion.el_centro()
    problem = study.Problem(lambda u: 0.0 * u, u0=np.zeros(2), ground=ground, influence=[1.0, 0.5], tangent="diagonal")
    ds = study.run(problem, "average_acceleration", dt=0.002, steps=2000, observe=["absolute_motion"])
    assert np.abs(ds.absolute_displacement).max() < 1e-5 and np.abs(ds.absolute_velocity).max() < 1e-10
    with pytest.raises(ValueError, match="absolute_displacement, absolute_velocity of 'hardening"):
        study.run("hardening", "rk4", dt=0.01, steps=2, observe=["absolute_motion"])


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
    "stated, unit",
    [("G,", "g"), ("CM/S**2", "cm/s2"), ("cm/s^2", "cm/s2"), ("cm/sec/sec", "cm/s2"), ("Gal", "cm/s2"), ("ells", "g")],
)
def test_units_of_headers_are_known_by_any_spelling(tmp_path, stated, unit):
    path = written(tmp_path / "quake.at2", np.array([0.1, -0.2, 0.3]))
    path.write_text(path.read_text().replace("units of g", f"UNITS OF {stated}"))
    assert len(study.GroundMotion.read(path, unit=unit).acceleration) == 4


def test_an_old_header_and_the_mark_of_a_byte_order_are_read(tmp_path):
    path = tmp_path / "old.at2"
    path.write_text("\ufeffa\nb\nunits of g\n  4  .0050  NPTS, DT\n0.1 0.2 0.3 0.4\n", encoding="utf-8")
    record = study.GroundMotion.read(path, unit="g")
    assert record.dt == 0.005 and len(record.acceleration) == 5


@pytest.mark.parametrize(
    "text, unit, sentence",
    [
        (HEADER.format(3) + "0.1 0.2\n", "g", "announces 3 samples, and the file holds 2"),
        (HEADER.format(2) + "0.1 nan\n", "g", "sample 2 of '.*' is not finite"),
        (HEADER.format(2) + "0.1 x\n", "g", "holds something other than numbers"),
        (HEADER.format(2) + "0.1 0.2\n", "cm/s2", "states the unit g, not 'cm/s2'"),
        (HEADER.format(2).replace("of g", "OF G,") + "0.1 0.2\n", "m/s2", "states the unit G,, not 'm/s2'"),
        (HEADER.format(2).replace("of g", "of CM/SEC/SEC") + "0.1 0.2\n", "g", "states the unit CM/SEC/SEC, not 'g'"),
        (
            HEADER.format(2).replace("acceleration", "VELOCITY") + "0.1 0.2\n",
            "g",
            "announces velocity, and a record",
        ),
        (HEADER.format(0), "g", "announces no samples"),
        (HEADER.format(2).replace("DT= .02000", "DT= .") + "0.1 0.2\n", "g", "is neither an AT2 file"),
        ("0 300\n1 -1\n", "g", "the peak of '.*' would be 300 g in the unit 'g'"),
        ("0 1\n1 2\n3 4\n4 5\n", "g", "must be a constant time apart, and are not after t = 1"),
        ("1 2 3\n4 5 6\n", "g", "is neither an AT2 file"),
        ("0 1\n1 2\n", "furlong", "unit must be one of g, m/s2"),
    ],
)
def test_records_that_cannot_be_right_get_a_sentence(tmp_path, text, unit, sentence):
    path = tmp_path / "record"
    path.write_text(text)
    with pytest.raises(ValueError, match=sentence):
        study.GroundMotion.read(path, unit=unit)


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
    with pytest.raises(ValueError, match=r"influence must have the shape of u0, \(2,\), not \(3,\)"):
        study.Problem(lambda u: u, u0=[0.0, 0.0], ground=record, influence=[1.0, 1.0, 1.0])
    with pytest.raises(ValueError, match="influence needs Problem"):
        study.Problem(lambda u: u, u0=0.0, influence=1.0)
    with pytest.raises(TypeError, match="must be a study.GroundMotion"):
        study.Problem(lambda u: u, u0=0.0, ground=jnp.sin)


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
    one, again, other = (study.GroundMotion.kanai_tajimi(seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.acceleration, again.acceleration)
    assert np.abs(one.acceleration - other.acceleration).max() > 1
    steady = study.GroundMotion.kanai_tajimi(1, rise=1e-9, fall=30.0).acceleration[1:]
    t = one.kinks[1:]
    envelope = np.where(t < 2, t**2 / 4, np.where(t < 10, 1, np.exp(-0.4 * (t - 10))))
    np.testing.assert_allclose(one.acceleration[1:], envelope * steady, atol=1e-12)
