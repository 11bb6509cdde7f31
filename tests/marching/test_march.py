"""The compiled march of a single run: its observations, its pauses and its failures."""

import signal
import subprocess
import sys
import time

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr

import study
from study.marching import program
from study.marching.march import March
from study.marching.result import UNBOUNDED
from study.problem import chains


@pytest.mark.slow
def test_reductions_agree_with_the_trajectory(state_kind):
    problem = study.problems["hardening"]
    ds = study.run(
        "hardening",
        state_kind,
        dt=0.15 / 20,
        steps=300,
        observe=["trajectory", "energy_error", "max_energy_error", "energy_drift"],
    )
    energy = 0.5 * ds.v**2 + 50 * ds.u**2 + 250 * ds.u**4
    error = (energy - energy[0]) / energy[0]
    np.testing.assert_allclose(ds.energy_error, error, atol=1e-12)
    assert ds.max_energy_error.item() == pytest.approx(np.abs(error).max().item(), rel=1e-10)
    assert ds.energy_drift.item() == pytest.approx(error[-1].item(), abs=1e-12)
    assert ds.u[0] == problem.u0 and ds.status == 0 and ds.failed_at_step == -1


@pytest.mark.slow
def test_storing_every_tenth_step_takes_them_out_of_the_whole(state_kind):
    whole, tenth = (study.run("softening", state_kind, dt=0.05, steps=200, every=k) for k in (1, 10))
    np.testing.assert_allclose(tenth.u, whole.u[::10], atol=1e-11)
    np.testing.assert_array_equal(tenth.t, whole.t[::10])


def test_newton_iterations_are_counted():
    ds = study.run("hardening", "average_acceleration", dt=0.15 / 20, steps=100, observe=["newton_iterations"])
    assert 100 < ds.newton_iterations.item() < 600
    assert 2 <= ds.max_newton_iterations.item() <= 10


@pytest.mark.slow
@pytest.mark.parametrize("u0", [4.0, [4.0, 5.0]])
def test_a_number_of_samples_fits_runs_of_every_length(u0):
    arguments = {"problem": "softening", "scheme": "rk4", "dt": 0.05, "u0": u0}
    whole = study.run(**arguments, steps=50).u
    for steps in (7, 30, 50):
        some = study.run(**arguments, steps=steps, every=3, samples=10).u
        ended = np.arange(11) * 3 > steps
        np.testing.assert_array_equal(some.t, whole.t[:31:3])
        np.testing.assert_allclose(some.isel(t=~ended), whole[..., :31:3].isel(t=~ended), rtol=1e-12)
        assert some.isel(t=ended).isnull().all()
    with pytest.raises(ValueError, match="samples must be a whole number of at least 1, not 0"):
        study.run(**arguments, steps=7, samples=0)


@pytest.mark.slow
@pytest.mark.parametrize("every", [1, 10, 1000])
def test_a_pause_changes_nothing(monkeypatch, every):
    """A march that pauses, even between two samples, gives the same results."""
    arguments = {"dt": 0.002, "steps": 3000, "every": every, "observe": ["trajectory", "max_energy_error"]}
    at_once = study.run("softening", "houbolt", **arguments)
    monkeypatch.setattr(program, "PAUSE", 257)
    xr.testing.assert_allclose(study.run("softening", "houbolt", **arguments), at_once, rtol=1e-10, atol=1e-12)


def test_a_failure_ends_a_run_at_its_pause(monkeypatch):
    monkeypatch.setattr(program, "PAUSE", 8)
    ds = study.run("double_well", "central_difference", dt=2.5, steps=10**12, observe=["max_energy_error"])
    assert ds.status == UNBOUNDED and ds.failed_at_step < 100


@pytest.mark.parametrize("u0", ["1.5", "[1.0] * 2000"], ids=["alone", "ensemble"])
def test_a_long_run_can_be_interrupted(tmp_path, u0):
    """Ctrl-C ends a run of 10¹² steps, and files that were written before it are kept."""
    code = (
        # interrupts are enabled, because a shell disables them in tests that it runs in the background
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "import study; study.io.write(study.run('hardening', 'rk4', dt=1e-4, steps=10), 'kept.nc'); "
        "print('ready', flush=True); "
        f"study.run('hardening', 'rk4', dt=1e-4, u0={u0}, steps=10**12, observe=['max_energy_error'])"
    )
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None and process.stdout.readline() == b"ready\n"
            time.sleep(2)
            process.send_signal(signal.SIGINT)
            _, error = process.communicate(timeout=60)
        finally:
            process.kill()  # otherwise the run would go on for hours after the test
    assert process.returncode != 0 and b"KeyboardInterrupt" in error
    assert xr.load_dataset(tmp_path / "kept.nc").status == 0


@pytest.mark.parametrize("bound, meaning", [(None, "unbounded"), (100.0, "unbounded"), (np.inf, "not_finite")])
def test_blow_up_is_recorded_with_its_step(bound, meaning):
    ds = study.run("double_well", "central_difference", dt=2.5, steps=1000, bound=bound)
    step = ds.failed_at_step.item()
    assert ds.status.attrs["flag_meanings"].split()[ds.status.item()] == meaning
    assert np.isfinite(ds.u[:step]).all() and np.isnan(ds.u[step:]).all()
    if bound == 100.0:
        assert abs(ds.u[step - 1]) <= bound < abs(2 * ds.u[step - 1] - ds.u[step - 2] - 2.5**2 * _cubic(ds.u[step - 1]))


def _shaken(frequency: float) -> study.Problem:
    return study.Problem(lambda u: frequency**2 * u, u0=0.0, ground=study.GroundMotion.el_centro())


@pytest.mark.slow
@pytest.mark.parametrize(
    "problem, scheme, dt, steps",
    [
        (study.Problem(lambda u: u, u0=1.0), "central_difference", 2.5, 100),
        (study.Problem(lambda u: -u, u0=1.0), "rk4", 0.1, 2000),
        (_shaken(140.0), "rk4", 0.0205, 1500),
    ],
    ids=["beyond the limit", "negative stiffness", "under a record"],
)
def test_growth_without_bound_is_no_result(problem, scheme, dt, steps):
    ds = study.run(problem, scheme, dt=dt, steps=steps, on_failure="ignore")
    assert ds.status == UNBOUNDED and 0 < ds.failed_at_step < steps
    lanes = study.run(problem, scheme, dt=[dt, dt / 100], steps=steps, observe="oscillations", on_failure="ignore")
    assert lanes.status[0] == UNBOUNDED and lanes.failed_at_step[0] == ds.failed_at_step


@pytest.mark.slow
@pytest.mark.parametrize(
    "problem, scheme, reach",
    [
        (study.Problem(lambda u: u**3 - u, u0=1e-6), "average_acceleration", 1.41),
        (study.Problem(lambda u: 0.0 * u, u0=0.0, load=lambda t: 9.81), "central_difference", 40_000.0),
        (study.Problem(lambda u: u, u0=0.0, load=jnp.sin), "average_acceleration", 40.0),
    ],
    ids=["from the top of a hill", "free fall", "resonance"],
)
def test_large_motion_is_a_result(problem, scheme, reach):
    ds = study.run(problem, scheme, dt=0.1, steps=1000)
    assert ds.status == 0 and abs(ds.u).max() > reach


def test_the_bound_of_a_family_is_that_of_its_largest_lane():
    def started(size):
        return study.Problem(lambda u: u, u0=size)

    ds = study.run(started, "rk4", over={"size": [1e-12, 10.0]}, dt=0.1, steps=100)
    assert not ds.status.any()


def _cubic(u):
    """The restoring force of the double well."""
    return (u**3 - u) / 2


def test_a_step_without_a_solution_is_recorded():
    """The first step solves u = ũ + u² with ũ = 2, which has no real root."""
    problem = study.Problem(lambda u: -u * u, u0=1.0)
    ds = study.run(problem, "average_acceleration", dt=2.0, steps=10, on_failure="ignore")
    assert ds.status.attrs["flag_meanings"].split()[ds.status.item()] == "no_solution_found"
    assert ds.failed_at_step == 1 and np.isnan(ds.u[1:]).all()


def test_step_size_and_count_share_one_compilation(caplog):
    problem = study.Problem(lambda u: u, u0=1.0, potential=lambda u: u**2 / 2)  # no other test compiles this problem
    with jax.log_compiles():
        for dt, steps in ((0.01, 10), (0.02, 20), (0.03, 30)):
            study.run(problem, "houbolt", dt=dt, steps=steps, observe=["max_energy_error"])
    assert sum("XLA compilation of jit(_whole)" in message for message in caplog.messages) == 1


@pytest.mark.slow
def test_short_and_long_runs_of_many_unknowns_share_one_program(caplog):
    """A long run has to pause, which the program of a run in one call cannot."""
    chain = study.Problem(lambda u: 4.0 * u, u0=np.ones(200))
    with jax.log_compiles():
        for steps in (10, 10_000):
            study.run(chain, "central_difference", dt=0.01, steps=steps, observe=["effort"])
    programs = ("jit(_whole)", "jit(_stretch)")
    compiled = [name for message in caplog.messages for name in programs if f"XLA compilation of {name}" in message]
    assert compiled == ["jit(_stretch)"]


def test_labels_and_samples_share_one_compilation(caplog):
    """Other parameters need another compiled program; other titles, sources or numbers of samples do not."""

    def times_compiled(*variants):
        caplog.clear()
        with jax.log_compiles():
            for problem, scheme, steps in variants:
                study.run(problem, scheme, dt=0.01, steps=steps)
        return sum("XLA compilation of jit(_whole)" in message for message in caplog.messages)

    def force(u):
        return 3 * u

    problems = [study.Problem(force, u0=1.0, title=title) for title in ("one", "other")]
    schemes = [study.Newmark(beta=0.3, gamma=0.6, title=title, source=title) for title in ("one", "other")]
    assert times_compiled(*((p, s, n) for p in problems for s in schemes for n in (10, 500))) == 1
    assert times_compiled((problems[0], study.Newmark(beta=0.31, gamma=0.6), 10)) == 1
    records = [study.GroundMotion(np.full(9, a), 0.1, title=str(a), source=str(a)) for a in (1.0, 2.0)]
    assert times_compiled(*((study.Problem(force, u0=1.0, ground=record), schemes[0], 10) for record in records)) == 1


def test_a_word_in_a_force_is_no_label():
    """A field ``source`` of a user's force may decide its values, so the field must not be removed like a label."""

    class Spring(eqx.Module):
        source: str = eqx.field(static=True)

        def __call__(self, u):
            return u if self.source == "soft" else 100 * u

    soft, stiff = (
        study.run(study.Problem(Spring(kind), u0=1.0), "rk4", dt=0.01, steps=50).u[-1] for kind in ("soft", "stiff")
    )
    assert soft > 0.8 and stiff < 0.5


def _compiled(definition, u0, dt):
    """The compiled program of a march; the number of steps is an argument."""

    @eqx.filter_jit
    def march(definition, u0, dt, until):
        progress, initial, stored = definition.start(u0, jnp.zeros_like(u0), dt, 1)
        progress, _ = definition.proceed(progress, stored, initial, dt, until, 1, 0, each_step=False)
        return definition.result(progress)

    arguments = definition, u0, np.asarray(dt), np.asarray(1)
    return march.lower(*arguments).compile().compiled  # type: ignore[attr-defined]  # missing in equinox' stubs


def test_what_a_problem_lacks_is_not_in_the_loop():
    """Without load, damping and mass, the compiled loop evaluates no function of time and solves no linear system."""
    problem, scheme = study.problems["hardening"], study.schemes["central_difference"]

    def text_of(problem):
        return _compiled(March(problem, scheme, (), ()), problem.u0, 0.01).as_text()

    text = text_of(problem)
    assert "cosine" not in text and "custom-call" not in text and "divide" not in text
    loaded = study.Problem(problem.force, u0=1.5, load=lambda t: jax.numpy.cos(t), mass=2.0)
    text = text_of(loaded)
    assert "cosine" in text and "divide" in text


def test_time_does_not_drift_over_many_steps():
    """The load of the last step is f(n Δt) to round-off, because time is the product n Δt and not a sum."""
    steps = 10**6
    problem = study.Problem(lambda u: 0.0 * u, u0=0.0, load=lambda t: t)
    ds = study.run(problem, "central_difference", dt=0.1, steps=steps, every=steps)
    end = 0.1 * steps
    # ü = t: the trapezoidal rule for the velocity is exact for a linear function
    assert ds.v[-1].item() == pytest.approx(end**2 / 2, rel=1e-12)


@pytest.mark.slow
def test_memory_grows_with_the_unknowns_and_no_faster():
    """The compiled march needs the same memory per unknown for bars of 1,000 and of 100,000 unknowns."""

    def kept(n):
        definition = March(chains.impact_bar(n), study.schemes["average_acceleration"], (), ())
        return _compiled(definition, np.zeros(n), 1 / n).memory_analysis().temp_size_in_bytes / 8 / n

    assert kept(1000) == pytest.approx(kept(100_000), rel=0.05)
    assert kept(100_000) < 25
