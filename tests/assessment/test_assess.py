"""The assessment of a problem, end to end."""

import math
import time
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import study
from reference import taylor
from study.assessment import errors, search, small
from study.assessment.certified import certified
from study.assessment.dataset import Assessed
from study.assessment.deadline import OutOfTime
from study.assessment.progress import Progress
from study.assessment.reference import Reference
from study.assessment.report import answer, page
from study.assessment.search import Case
from study.assessment.steps import StepSearch
from study.observer.energy import MaxEnergyError

DURATION = 20.0
QUANTITIES = {
    "peak": study.Quantity(lambda u: u, reduce="peak"),
    "path": study.Quantity(lambda u, v: jnp.stack([u, v])),
    "force": study.Quantity(lambda a: a, reduce="rms"),
}


@pytest.fixture(scope="module")
def driven():
    return study.Problem(
        lambda u: u + u**3,
        potential=lambda u: u**2 / 2 + u**4 / 4,
        u0=0.0,
        damping=0.1,
        load=lambda t: 0.5 * jnp.cos(1.2 * t),
        title="driven",
    )


@pytest.fixture(scope="module")
def assessed(driven):
    return study.assess(
        driven, ["newmark", "rk4"], duration=DURATION, quantities=QUANTITIES, allowed_errors=(0.05, 0.01)
    )


def _by_scipy(t):
    def rate(t, y):
        return [y[1], 0.5 * np.cos(1.2 * t) - 0.1 * y[1] - y[0] - y[0] ** 3]

    return solve_ivp(rate, (0, DURATION), [0.0, 0.0], method="DOP853", t_eval=t, rtol=1e-12, atol=1e-13).y


@pytest.mark.slow
@pytest.mark.parametrize("allowed", [0.05, 0.01])
@pytest.mark.parametrize("scheme", ["average_acceleration", "rk4"])
def test_a_recommended_step_keeps_its_error_against_another_solver(driven, assessed, scheme, allowed):
    """The recommended step keeps the error against SciPy; a step a third larger than the largest one found does not."""
    row = assessed.sel(scheme=scheme, quantity="path", allowed_error=allowed)
    largest = np.abs(_by_scipy(np.linspace(0, DURATION, 4001))).max()

    def error(dt):
        steps = int(DURATION / dt * (1 + 1e-9))
        ds = study.run(driven, scheme, dt=dt, steps=steps)
        return np.abs(np.stack([ds.u, ds.v]) - _by_scipy(np.minimum(ds.t.values, DURATION))).max() / largest

    step = row.recommended_step_size.item()
    assert step == float(f"{step:.1e}") <= row.largest_step_size and row.steps_tried > 300
    assert error(step) == pytest.approx(row.recommended_error.item(), rel=1e-3)
    assert row.largest_error <= allowed and error(4 / 3 * row.largest_step_size.item()) > allowed


@pytest.mark.slow
@pytest.mark.parametrize("reduce", ["peak", "final", "rms"])
def test_a_reduced_quantity_is_compared_up_to_the_end_of_the_run(driven, reduce):
    """A run ends with the last whole step within the duration; the reference is reduced over the same time."""
    quantities = errors.named({"x": study.Quantity(lambda u, v: jnp.stack([u, v]), reduce=reduce)})
    reference = certified(driven, DURATION, quantities, tightest=1e-4, coarsest=1.0, periodic=False)
    newmark = StepSearch(
        study.schemes["newmark"], {1.0: Case(driven, reference.targets, None)}, DURATION, 0.1, 0.01, False
    )
    newmark.run(np.array([0.0123, 0.0237]))
    for dt, steps, error in newmark.runs[["dt", "steps", "x"]].itertuples(index=False):
        assert steps == int(DURATION / dt)
        t = np.linspace(0, steps * dt, 20_001)
        exact, ds = _by_scipy(t), study.run(driven, "newmark", dt=dt, steps=steps)
        values = np.stack([ds.u, ds.v])
        reduced = {
            "peak": lambda y: np.abs(y).max(axis=1),
            "final": lambda y: y[:, -1],
            "rms": lambda y: np.sqrt(np.trapezoid(y**2, axis=1) / (y.shape[1] - 1)),
        }[reduce]
        scale = np.abs(reduced(exact)).max()
        assert error == pytest.approx(np.abs(reduced(values) - reduced(exact)).max() / scale, rel=0.02)


def test_the_reference_is_as_uncertain_as_it_says(driven, assessed):
    reference = Reference(driven, DURATION)
    solution = reference.solution(reference.routes[0], reference.grid(1.0), 1e-8)
    exact = _by_scipy(solution.t)
    assert np.abs(np.stack([solution.u, solution.v]) - exact).max() < 1e-6
    assert (assessed.reference_uncertainty < 1e-4).all()
    assert assessed.attrs["reference"] == "heyoka" and assessed.attrs["witness"] == "CVODE Adams"


@pytest.mark.slow
@pytest.mark.parametrize(
    "problem, duration",
    [
        # the frequency at the start is far below the frequency of the motion
        (study.Problem(lambda u: 1e3 * u**3, 0.0, 10.0, damping=0.01, title="far out"), 5.0),
        # the frequency of small motions is far below the frequency of the load
        (study.Problem(lambda u: u + u**3, 0.0, load=lambda t: 50 * jnp.cos(60 * t), title="driven fast"), 5.0),
    ],
)
def test_errors_between_the_points_of_a_reference_are_part_of_its_uncertainty(problem, duration):
    quantities = errors.named({name: errors.DEFAULT[name] for name in ("displacement", "velocity")})
    reference = certified(problem, duration, quantities, tightest=0.001, coarsest=1.0, periodic=False)
    steps = 200_000
    ds = study.run(problem, "rk4", dt=duration / steps, steps=steps, every=100)
    exact = np.array([ds.u, ds.v])
    values = np.array(reference.solution.at(ds.t.values))
    deviations = np.abs(values - exact).max(axis=1) / np.abs(exact).max(axis=1)
    assert (deviations <= 1.5 * np.array([reference.uncertainty[name] for name in quantities]) + 1e-9).all()
    assert (deviations < 2e-5).all()


def test_recommend_lists_what_was_run(assessed):
    table = study.recommend(assessed, allowed_error=0.01, quantity="force")
    assert set(table.index) == {"average_acceleration", "rk4"} and (table.error <= 0.01).all()
    ends = table.step_size * table.steps
    assert ((ends <= DURATION * (1 + 1e-9)) & (ends > DURATION - table.step_size)).all()
    # ω² = 1 + 3 u² at the largest displacement
    largest = np.abs(_by_scipy(np.linspace(0, DURATION, 4001))[0]).max()
    assert (table.omega_step / table.step_size).to_numpy() == pytest.approx(np.sqrt(1 + 3 * largest**2), rel=1e-3)
    assert table.kind.to_dict() == {"average_acceleration": "implicit", "rk4": "explicit"}
    assert table.force_evaluations_per_time["rk4"] == pytest.approx(4 / table.step_size["rk4"])
    assert table["seconds"][~table.ties_with_fastest].is_monotonic_increasing and table.ties_with_fastest.iloc[0]


def test_what_there_is_no_time_for_is_said(driven, assessed, monkeypatch):
    # the time of the searches ends after the first runs
    monkeypatch.setattr(search, "time", SimpleNamespace(monotonic=lambda: math.inf, perf_counter=time.perf_counter))
    hurried = study.assess(
        driven, "newmark", duration=DURATION, quantities=QUANTITIES, allowed_errors=(0.05, 0.01), seconds=1000.0
    )
    words = np.array(hurried.verdict.flag_meanings.split())[hurried.verdict]
    assert set(words.ravel()) == {"out_of_time"} and hurried.recommended_step_size.isnull().all()
    assert 0 < hurried.sizes["step_size"] < assessed.sizes["step_size"] / 3
    assert "out of time" in answer(hurried, "path", 0.01) and "outcome" not in hurried


def test_a_reference_that_takes_too_long_is_given_up(driven):
    start = time.monotonic()
    with pytest.raises(ValueError, match="the reference of 'driven' was not found in 0.2 s; allow more .*: 1 unknown"):
        study.assess(driven, "rk4", duration=DURATION * 5000, seconds=0.2)
    assert time.monotonic() - start < 20


def test_schemes_for_which_there_is_no_time_are_named():
    progress, schemes = Progress(2), dict[str, Any](one=1, late=2)
    with pytest.warns(RuntimeWarning, match="out of time: late were not assessed"):
        results = small._assess_each(
            schemes, lambda scheme: Assessed(None, {}, None) if scheme == 1 else None, progress, ""
        )
    assert list(results) == ["one"]
    with pytest.raises(OutOfTime, match="no scheme was run"):
        small._assess_each(schemes, lambda scheme: None, Progress(2), "no scheme was run")


def test_an_assessment_is_dated_by_its_time(assessed, monkeypatch):
    created = datetime.fromisoformat(assessed.attrs["date_created"])
    assert timedelta(0) <= datetime.now(UTC) - created < timedelta(hours=1)
    assert assessed.attrs["history"].startswith(assessed.attrs["date_created"])
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    assert study.io.now() == study.io.provenance("", "")["date_created"] == "1970-01-01T00:00:00+00:00"


def test_the_reference_itself_is_part_of_the_answer(driven, assessed):
    """Peak, its time and the root mean square agree with SciPy within the stated uncertainty."""
    t = np.linspace(0, DURATION, 20_001)
    u, v = _by_scipy(t)
    peak, path = (assessed.sel(quantity=name) for name in ("peak", "path"))
    tolerance = 1e-7 + peak.reference_value_uncertainty[0]
    assert abs(peak.reference_value[0] - np.abs(u).max()) < tolerance and peak.reference_value.isnull()[1]
    assert peak.reference_time[0] == pytest.approx(t[np.abs(u).argmax()], abs=0.05)
    assert path.reference_value.values == pytest.approx([np.abs(u).max(), np.abs(v).max()], abs=1e-6)
    force = (np.cos(1.2 * t) * 0.5 - 0.1 * v - u - u**3) ** 2
    rms = assessed.sel(quantity="force")
    assert rms.reference_value[0] == pytest.approx(np.sqrt(np.trapezoid(force, t) / DURATION), rel=1e-5)
    assert rms.reference_time.isnull().all() and rms.relative_to == "relative to the root mean square"
    assert path.relative_to == "relative to the largest value along time of the largest component"
    assert assessed.attrs["model"].splitlines() == [
        "1 unknown, period of small motion 6.28 s, 20 s are 3.18 periods",
        "damping ratios 0.05; a load",
    ]
    assert "Reference of peak: " in study.recommend(assessed, allowed_error=0.01, quantity="peak").to_string()


def test_failures_are_mapped_and_explained(assessed):
    explicit = assessed.sel(scheme="rk4")
    outcome = explicit.outcome.sel(excitation=1.0).values
    assert outcome[0] == study.Outcome.UNBOUNDED and outcome[-1] <= 1
    assert explicit.largest_safe_step_size < explicit.map_step_size[0]
    assert "beyond the limit of stability" in explicit.failure.item()


def test_no_recommended_step_contradicts_the_largest_safe_one(assessed):
    for name in assessed.quantity.values:
        for allowed in assessed.allowed_error.values:
            steps = assessed.recommended_step_size.sel(quantity=name, allowed_error=allowed)
            beyond = bool((steps > assessed.largest_safe_step_size).any())
            assert beyond == ("beyond its largest step without failure" in answer(assessed, name, allowed))


@pytest.mark.slow
def test_a_spring_of_the_study_has_the_errors_of_its_datasets():
    """Over 20 periods, errors equal the distance from the exact motion; the energy error equals MaxEnergyError."""
    problem, steps = study.problems["hardening"], 20 * 32
    exact = float(taylor.period(problem, 0.15))
    duration = 20 * exact
    quantities = errors.named(errors.DEFAULT)
    reference = Reference(problem, duration)
    exactly = reference.solution(reference.routes[0], reference.grid(exact / 4), 1e-12)
    targets = {name: errors.target(q, problem, exactly) for name, q in quantities.items()}
    rk4 = StepSearch(study.schemes["rk4"], {1.0: Case(problem, targets, None)}, duration, 1.0, duration / steps, True)
    rk4.run(np.array([duration / steps]))
    row = rk4.runs.iloc[0]
    ds = study.run(problem, "rk4", dt=duration / steps, steps=steps, observe=["trajectory", MaxEnergyError()])
    period = taylor.trajectory(problem, np.arange(1, 33) * exact / 32).u
    expected = np.concatenate([[1.5], np.tile(period, 20)])
    assert row.displacement == pytest.approx(np.abs(ds.u - expected).max().item() / 1.5, rel=1e-8)
    expected_forces, forces = (np.asarray(problem.force(u)) for u in (expected, ds.u.values))  # the mass cancels
    assert row.acceleration == pytest.approx(
        np.abs(forces - expected_forces).max() / np.abs(expected_forces).max(), rel=1e-8
    )
    assert row.energy == pytest.approx(ds.max_energy_error.item(), rel=1e-12)


@pytest.mark.slow
def test_a_free_oscillator_is_judged_by_period_phase_and_amplitude():
    """It alone assesses the quantities of free motion that an assessment adds by itself, and a potential alone."""
    pendulum = study.Problem(potential=lambda u: 1 - jnp.cos(u), u0=2.0, title="pendulum")
    ds = study.assess(pendulum, "bathe", allowed_errors=(0.01,), maps=False)
    along, oscillating = ["displacement", "velocity", "acceleration", "energy"], ["period", "phase", "amplitude"]
    assert ds.quantity.values.tolist() == along + oscillating
    assert ds.quantity_title.values[-1].startswith("relative loss of amplitude, geometric mean per oscillation")
    steps = dict(zip(ds.quantity.values, ds.recommended_step_size.values.ravel(), strict=True))
    assert steps["displacement"] < steps["phase"] < steps["period"]
    assert ds.attrs["reference"] == "heyoka" and ds.attrs["duration"] == pytest.approx(10 * 8.3498, rel=0.01)


def test_chaos_ends_what_a_reference_can_say(undrawn):
    """It alone sees that the duration is cut to the time over which the references agree, and that the page says so.

    The scheme of order 12 needs few runs.
    """
    problem = study.problems["duffing_chaotic"]
    with pytest.warns(RuntimeWarning, match=r"the references of 'Duffing, chaotic' agree up to t = .* of 200 s"):
        ds = study.assess(problem, "extrapolation12", duration=200.0, allowed_errors=(0.5,), maps=False)
    assert 20 < ds.attrs["duration"] < 150 and ds.attrs["duration_requested"] == 200.0
    assert "Beyond t = " in page(ds)


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ({"duration": None}, "'driven' has no period that gives the length of the runs: give a duration"),
        ({"duration": -1.0}, "duration must be a time in seconds greater than zero, not -1.0"),
        ({"allowed_errors": [2.0]}, "allowed_errors must be fractions between 0 and 1"),
        ({"schemes": []}, "schemes is empty"),
        ({"schemes": "verle"}, "there is no scheme 'verle'"),
        ({"quantities": {}}, "quantities must be a mapping from names to study.Quantity"),
        ({"quantities": {"u": lambda u: u}}, r"quantities\['u'\] must be a study.Quantity"),
        ({"quantities": {"energy": QUANTITIES["peak"]}}, "the name 'energy' is reserved for the balance of energies"),
        ({"quantities": {"x": study.Quantity(lambda u: jnp.log(u))}}, "'x' of 'driven' is not finite at t = 0"),
        ({"quantities": {"x": study.Quantity(lambda u: 0 * u)}}, "'x' of 'driven' is zero at all times"),
        ({"quantities": {"x": study.Quantity(lambda u: u[3])}}, "the quantity 'x' cannot be computed for 'driven'"),
    ],
)
def test_mistakes_get_a_sentence_before_any_run(driven, arguments, sentence):
    with pytest.raises((ValueError, TypeError, KeyError), match=sentence):
        study.assess(driven, **{"duration": 1.0, "schemes": "rk4"} | arguments)


def test_a_problem_without_motion_is_refused():
    with pytest.raises(ValueError, match="'still' does not move"):
        study.assess(study.Problem(lambda u: u, u0=0.0, title="still"), duration=1.0)
