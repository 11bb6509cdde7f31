"""The assessment of a program: the recommended steps, the reference, and the failures of runs."""

import math
import re
import time
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import study
from study.assessment.failures import failed_runs
from study.assessment.program import _row
from study.assessment.search import VERDICTS
from study.assessment.steps import round_step
from study.program import runs, search, truth
from study.program.attempt import STATUSES, WHOLE, Run
from study.program.curves import Curve
from study.program.refinement import NoTruth
from study.program.runs import Runs
from study.program.search import MOST_CONFIRMING, Search
from tests.program import models

ALONG = ["displacement", "velocity"]


def program(run, folder, schemes=models.SCHEMES, **options):
    return study.Program(run, schemes, models.DURATION, **{"folder": folder, "name": "model", "workers": 1} | options)


@pytest.fixture(scope="module", autouse=True)
def few_confirming():
    """Let cheap programs confirm their steps by as few runs as expensive ones; one test restores the usual number."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "MOST_CONFIRMING", search.FEWEST_CONFIRMING)
        yield


@pytest.fixture(scope="module", params=[0.0, 0.5], ids=["linear", "hardening"])
def spring(request, tmp_path_factory):
    """A spring as a program, the assessment of the program, and the hardening of the spring."""
    run = models.linear if request.param == 0 else models.hardening
    model = program(run, tmp_path_factory.mktemp("runs"))
    return model, study.assess(model), request.param


@pytest.mark.slow
def test_the_truth_is_as_uncertain_as_it_says(spring):
    model, ds, hardening = spring
    reference = Search(model, [0.1, 0.01, 0.001], round_step, math.inf, lambda *words: None).truth

    def rate(t, y):
        return [y[1], -y[0] - hardening * y[0] ** 3]

    t = np.linspace(0, reference.best.motion["velocity"].t[-1], 5001)
    exact = solve_ivp(rate, (0, models.DURATION), [1.0, 0.0], method="DOP853", t_eval=t, rtol=1e-12, atol=1e-13).y
    for name, along in zip(ALONG, exact, strict=True):
        error = np.abs(reference.best.motion[name].at(t) - along).max() / np.abs(along).max()
        assert error <= reference.uncertainty[name] <= 1e-4
        assert reference.uncertainty[name] == ds.reference_uncertainty.sel(quantity=name)
    assert "by order 2" in ds.attrs["reference"] and "by order 2" in ds.attrs["witness"]


@pytest.mark.slow
def test_its_steps_are_those_of_the_same_problem(spring):
    """Recommended steps agree within a factor of 1.25, the resolution of few runs and of rounding to two digits."""
    _, ds, hardening = spring
    problem = study.Problem(lambda u: u + hardening * u**3, u0=1.0, title="spring")
    quantities = {"displacement": study.Quantity(lambda u: u), "velocity": study.Quantity(lambda v: v)}
    expected = study.assess(problem, models.SCHEMES, duration=models.DURATION, quantities=quantities, maps=False)
    ratio = ds.recommended_step_size / expected.recommended_step_size
    assert ((ratio > 1 / 1.25) & (ratio < 1.25)).all()
    assert (ds.recommended_error <= ds.allowed_error).all() and (ds.largest_error <= ds.allowed_error).all()
    assert (ds.steps_tried > 4).all() and ds.kind.values.tolist() == ["implicit", "explicit"]


@pytest.mark.slow
def test_recommend_and_report_take_it(spring, tmp_path):
    """Only this test catches a report or a table that cannot show the assessment of a program."""
    _, ds, _ = spring
    table = study.recommend(ds, allowed_error=0.01, quantity="velocity")
    explicit, implicit = table.step_size[["central_difference", "average_acceleration"]]
    assert explicit == pytest.approx(2**0.5 * implicit, rel=0.25)
    page = study.report(ds, tmp_path / "page.html").read_text()
    assert re.search(r"Central difference, [\d.]+\s\w+(</b>)?</td>", page)
    assert "cubic splines" in page and "random finer" not in page
    study.io.write(ds, tmp_path / "ds.nc")
    assert study.io.read(tmp_path / "ds.nc").reason.dtype.kind in "OU"


def test_error_against_time_is_drawn(spring, tmp_path):
    model, ds, _ = spring
    cost = study.work_precision(model, figure=tmp_path / "work.svg", quantity="velocity")
    assert cost.error.equals(ds.error) and (cost.seconds.notnull() == (ds.status == 0)).all()
    assert (cost.seconds > 0).any() and "error of velocity" in (tmp_path / "work.svg").read_text()
    with pytest.raises(KeyError, match="no quantity 'speed'; known are displacement"):
        study.work_precision(model, figure=tmp_path / "work.svg", quantity="speed")


def _two_units(scheme, dt):
    """Displacement, and a rotation of a ten-thousandth of the velocity."""
    right = models.linear(scheme, dt)
    motion = np.stack([right["displacement"], 1e-4 * np.asarray(right["velocity"])], axis=1)
    return {"t": right["t"], "motion": motion, "last": right["displacement"][-1]}


def test_components_of_different_units_are_remarked(tmp_path):
    with pytest.warns(RuntimeWarning, match="1 of 2 components of 'motion' stay below .* return them separately"):
        ds = study.assess(program(_two_units, tmp_path), allowed_errors=[0.1])
    assert ds.reference_value.sel(quantity="motion").values == pytest.approx([1.0, 1e-4], rel=1e-3)
    assert ds.reference_value.sel(quantity="last")[0] == pytest.approx(np.cos(models.DURATION), abs=1e-3)
    assert ds.relative_to.sel(quantity="last") == "relative to the value itself"
    assert "components of 'motion'" in study.recommend(ds, allowed_error=0.1).to_string()


def test_each_component_of_a_quantity_may_have_its_own_scale():
    """A component with amplitude 1e-4 and a relative error of dt² counts as one of amplitude 1 does."""
    runs = []
    for dt in (0.1, 0.05, 0.025, 0.0125):
        t = np.arange(0, 1 + dt / 2, dt)
        values = np.stack([np.cos(t) * (1 + 0.01 * dt**2), 1e-4 * np.cos(t) * (1 + dt**2)], axis=1)
        runs.append(Run("a", dt, "completed", "", 1.0, 1.0, t, {"u": values}))
    quantity = study.Quantity(lambda u: u, "u", scale="each")
    estimates = truth.estimate(runs, {"u": quantity}), truth.estimate(runs)
    assert estimates[0] is not None and estimates[1] is not None
    assert estimates[0].motion["u"].scale == pytest.approx([1.0, 1e-4])
    for estimate, error in zip(estimates, (0.1**2, 0.01 * 0.1**2), strict=True):
        errors = truth.Truth(estimate, estimate, {"u": 0.0}, {"u": 0.0}).errors(runs[0])
        assert errors["u"] == pytest.approx(error, rel=0.01)


def test_a_second_question_repeats_one_run_of_each_scheme(spring):
    model, ds, hardening = spring
    calls = []

    def counted(scheme, dt):
        calls.append(scheme)
        return models.oscillator(hardening, scheme, dt)

    repeated = study.assess(replace(model, run=counted))
    assert sorted(calls) == models.SCHEMES and repeated.error.equals(ds.error)
    assert set(np.unique(repeated.status)) == {0, STATUSES.index("not_tried")}


def _set_hardening(where, value, tmp_path, monkeypatch):
    (tmp_path / "spring.txt").write_text(str(value))
    monkeypatch.setenv("HARDENING", str(value))
    monkeypatch.setattr(models, "HARDENING", value)
    return {"module": models.from_module, "environment": models.from_environment}.get(
        where, partial(models.from_file, str(tmp_path / "spring.txt"))
    )


@pytest.mark.slow
@pytest.mark.parametrize("where", ["module", "file", "environment"])
def test_kept_runs_of_a_program_that_has_changed_are_discarded(where, tmp_path, monkeypatch):
    """The second assessment equals one of a program with the same hardening and an empty folder."""
    model = program(_set_hardening(where, 0.0, tmp_path, monkeypatch), tmp_path / "runs", name=None)
    study.assess(model, allowed_errors=[0.1])
    # as of its last assessment, the program keeps also runs of another first step
    study.assess(replace(model, coarsest=0.9), allowed_errors=[0.1])
    _set_hardening(where, 0.5, tmp_path, monkeypatch)
    sentence = (
        r"the kept runs of '\w+' are discarded, because the program has changed or gives other results each time: "
        r"its run with 'average_acceleration' at Δt = [\d.]+ s differs by \d+.% from the kept run\."
    )
    with pytest.warns(RuntimeWarning, match=sentence):
        ds = study.assess(model, allowed_errors=[0.1])
    expected = study.assess(program(models.hardening, tmp_path / "expected"), allowed_errors=[0.1])
    assert ds.error.equals(expected.error)
    other = study.assess(replace(model, coarsest=0.9), allowed_errors=[0.1])
    assert other.error.equals(
        study.assess(program(models.hardening, tmp_path / "other", coarsest=0.9), allowed_errors=[0.1]).error
    )


def test_kept_failures_of_a_program_that_has_changed_are_discarded(tmp_path):
    model = program(partial(models.from_file, str(tmp_path / "spring.txt")), tmp_path, coarsest=1.0, finest=0.1)
    with pytest.raises(NoTruth, match="it raised FileNotFoundError"):
        study.assess(model)
    (tmp_path / "spring.txt").write_text("0.0")
    with pytest.warns(RuntimeWarning, match="which ended with 'it raised FileNotFoundError.*, ends with 'completed'"):
        ds = study.assess(model, allowed_errors=[0.5])
    assert (ds.verdict <= 1).all()


def test_a_kept_failure_is_repeated_beside_completed_runs(tmp_path):
    """A full disk fails the fine runs; later they complete, and a failure that gives another reason is kept."""
    full, calls = True, []

    def on_a_full_disk(scheme, dt):
        calls.append(dt)
        if full and dt < 0.5:
            raise OSError(f"no space left after {len(calls)} runs")
        return models.linear(scheme, dt)

    model, jobs = program(on_a_full_disk, tmp_path), [("average_acceleration", dt) for dt in (1.0, 0.25)]
    for _ in range(2):
        with Runs(model) as runs_of:
            assert [run.completed for run in runs_of.run(jobs)] == [True, False]
    assert calls == [1.0, 0.25] * 2
    full = False
    with Runs(model) as runs_of, pytest.warns(RuntimeWarning, match="are discarded, .* ends with 'completed'"):
        assert all(run.completed for run in runs_of.run(jobs))


def test_a_small_change_is_noticed_and_the_scatter_of_a_program_is_not(tmp_path):
    """A program whose runs scatter by 1e-5 keeps its runs, until it changes by more than ten times this scatter."""
    random, calls = np.random.default_rng(0), []

    def scatters(scheme, dt):
        calls.append(dt)
        right = models.linear(scheme, dt)
        return right | {"displacement": right["displacement"] * (factor + 1e-5 * random.random())}

    factor, model = 1.0, program(scatters, tmp_path)
    study.assess(model, allowed_errors=[0.1])
    calls.clear()
    study.assess(model, allowed_errors=[0.1])
    assert len(calls) == len(models.SCHEMES)
    factor = 1.001
    with pytest.warns(RuntimeWarning, match="differs by 0.1.% from the kept run"):
        study.assess(model, allowed_errors=[0.1])


def test_processes_that_would_read_another_variable_make_no_run(tmp_path, monkeypatch):
    monkeypatch.setattr(models, "HARDENING", 0.5)
    model = program(models.from_module, tmp_path, workers=2)
    with pytest.warns(
        RuntimeWarning, match="made one after the other, because other processes would read another value"
    ):
        (run,) = Runs(model).run([("central_difference", 0.1)])
    assert (run.values["displacement"] == models.hardening("central_difference", 0.1)["displacement"]).all()
    assert Runs(program(models.hardening, tmp_path, workers=2))._pool is not None


@pytest.mark.parametrize(
    "how, reason",
    [
        ("raised", "it raised ValueError: no convergence"),
        ("exit_code", "it ended with the exit code 3"),
        ("nothing", "it returned nothing"),
        ("unusable", "'velocity' has 2 values at 17 times 't'"),
        ("not_finite", "'velocity' is not finite at t = 11.25 s"),
        (
            "unequal_times",
            f"its times are 1.25279 s apart, and 1.27022 s after t = 1.25279 s: {WHOLE}",
        ),
        ("too_short", "it ends at t = 8.75 of 20 s"),
    ],
)
def test_a_scheme_that_goes_wrong_is_recorded(how, reason, tmp_path):
    model = program(partial(models.fails, how), tmp_path, [*models.SCHEMES, "wrong"])
    with pytest.warns(RuntimeWarning, match="11 of 11 runs of 'wrong' failed: at Δt = 0.001221 s, "):
        ds = study.assess(model, allowed_errors=[0.01])
    wrong = ds.sel(scheme="wrong")
    assert wrong.status[0] == STATUSES.index(how) and wrong.reason[0] == reason
    assert wrong.verdict[0].item() == 2 and (ds.verdict.sel(scheme=models.SCHEMES) == 0).all()
    assert failed_runs(ds)[0] == ("wrong", "1.25", reason)


def test_a_run_that_ends_its_process_ends_no_other(tmp_path):
    """Only this test catches a crash of one process that takes the runs of others with it."""
    model = program(partial(models.fails, "signal"), tmp_path, [*models.SCHEMES, "wrong"], workers=2)
    ds = study.assess(model, allowed_errors=[0.1])
    assert ds.status.sel(scheme="wrong", step_size=1.25) == STATUSES.index("signal")
    assert (ds.status.sel(scheme=models.SCHEMES, step_size=1.25) == 0).all()
    assert (ds.verdict.sel(quantity="velocity") == 0).all()


@pytest.mark.parametrize(
    "run, schemes, sentence",
    [
        (
            models.ignores_the_step,
            [*models.SCHEMES, "wrong"],
            "'wrong' ignores the step: its runs at 1.25 s and 0.625 s are the same to the last digit",
        ),
        (
            models.Remembers(),
            models.SCHEMES,
            "'central_difference' depends on the order of runs: a repeated run at 1.25 s differs by",
        ),
        (
            models.two_motions,
            models.SCHEMES,
            "agree to .* only, at .* so they solve different problems: no step is recommended for its errors below",
        ),
    ],
)
def test_what_is_wrong_with_all_runs_is_said(run, schemes, sentence, tmp_path):
    """A program that ignores its step or its scheme, and gets an answer."""
    with pytest.warns(RuntimeWarning, match=sentence):
        ds = study.assess(program(run, tmp_path, schemes), allowed_errors=[0.001])
    wrong = ds.verdict.sel(scheme=schemes[-1])
    assert (wrong == 3).all() and ds.recommended_step_size.sel(scheme=schemes[-1]).isnull().all()
    assert (
        ds.attrs["remarks"] and study.recommend(ds, allowed_error=0.001).verdict[schemes[-1]] == "below the reference"
    )


@pytest.mark.parametrize("others", [[], ["central_difference"]])
def test_a_program_that_ignores_its_scheme_is_no_second_witness(others, tmp_path):
    """One scheme under two names that agrees with itself: the reference would be as certain as it is wrong."""

    def run(scheme, dt):
        right = models.linear("central_difference" if scheme == "central_difference" else "average_acceleration", dt)
        return right if scheme != "hht" else right | {"displacement": right["displacement"] * (1 + 1e-15)}

    model, words = (
        program(run, tmp_path, ["newmark", "hht", *others]),
        "'hht' returns the results of 'newmark' to round-off",
    )
    if not others:
        with pytest.raises(NoTruth, match=f"fewer than two different schemes complete .* {words}"):
            study.assess(model, allowed_errors=[0.01])
        return
    with pytest.warns(RuntimeWarning, match=words):
        ds = study.assess(model, allowed_errors=[0.01])
    assert {"central_difference", "newmark"} == {ds.reference.split()[0], ds.witness.split()[0]}


def test_a_program_with_a_finest_step_of_its_own_ignores_the_step(tmp_path):
    """A coarse motion that seems to converge at once, since a spline gives the output at every time."""

    def run(scheme, dt):
        right = models.linear(scheme, max(dt, 0.2))
        return right | {"displacement": right["displacement"] * (1 + 1e-15 * dt)}

    with pytest.raises(
        NoTruth, match=r"'average_acceleration' ignores the step: .* are the same to (round-off|the last)"
    ):
        study.assess(program(run, tmp_path), allowed_errors=[0.001])


def _largest_error(run, scheme, dt):
    """Error of the linear oscillator's displacement at the times of a run, from the closed form cos t."""
    result = run(scheme, dt)
    return np.abs(result["displacement"] - np.cos(result["t"])).max()


def test_output_at_every_hundredth_step_is_refined_until_it_can_be_followed(tmp_path):
    run = partial(models.sampled, 100)
    with pytest.warns(RuntimeWarning, match="has an output after every 100 steps, and errors between .* are not seen"):
        ds = study.assess(program(run, tmp_path), allowed_errors=[0.01])
    assert (ds.verdict == 0).all()
    for scheme in models.SCHEMES:
        row = ds.sel(scheme=scheme, quantity="displacement", allowed_error=0.01)
        error = _largest_error(run, scheme, row.recommended_step_size.item())
        assert error <= 0.01 and row.recommended_error == pytest.approx(error, abs=2e-4)


def test_output_too_coarse_to_follow_a_quantity_is_said(tmp_path):
    sentence = (
        r"the output of '\w+', 17 times 1.25 s apart at steps of 0.00125 s, is too coarse to follow it to 0.1.%, which "
        r"needs times about 0\.\d+ s apart: no step is recommended for its errors below"
    )
    model = program(partial(models.sampled, 1000), tmp_path, coarsest=0.005, finest=0.00125)
    with pytest.warns(RuntimeWarning, match=sentence):
        ds = study.assess(model, allowed_errors=[0.01])
    assert (ds.verdict == VERDICTS.index("below_the_reference")).all() and "different problems" not in ds.attrs[
        "remarks"
    ]


def test_output_at_fixed_times_is_compared_at_these_times(tmp_path):
    run = partial(models.recorded, 2.0)
    sentence = "11 times 2 s apart .* is too coarse to follow it to 0.1.%, .*: its errors hold at these times only"
    with pytest.warns(RuntimeWarning, match=sentence):
        ds = study.assess(program(run, tmp_path, spacing=2.0), allowed_errors=[0.01])
    assert (ds.verdict == 0).all() and (ds.reference_uncertainty < 1e-4).all()
    for scheme in models.SCHEMES:
        row = ds.sel(scheme=scheme, quantity="displacement", allowed_error=0.01)
        error = _largest_error(run, scheme, row.recommended_step_size.item())
        assert error <= 0.01 and row.recommended_error == pytest.approx(error, abs=1e-4)


def test_a_recorder_whose_interval_the_steps_do_not_divide_needs_the_spacing(tmp_path):
    with pytest.warns(RuntimeWarning, match="cannot be compared: write every step, or give the time between outputs"):
        ds = study.assess(program(partial(models.recorded, 0.5), tmp_path), allowed_errors=[0.01])
    assert (ds.verdict == VERDICTS.index("not_even_the_finest_step")).all()
    assert "another motion" not in ds.attrs["remarks"]


@pytest.mark.parametrize(
    "factor, begin, reason",
    [
        (1000.0, 0.0, "it ends at t = 20000, and must end at 20 in the unit s"),
        (1 / 60, 0.0, "it ends at t = 0.333333 of 20 s"),
        (1.0, 1.0, "it begins at t = 1 s, and must begin at 0 or with the first output after 0"),
        (1.0, 2.5, "it begins at t = 2.5 s, and must begin at 0 or with the first output after 0"),
    ],
)
def test_times_of_another_unit_or_clock_are_refused(factor, begin, reason, tmp_path):
    model = program(partial(models.shifted, factor, begin), tmp_path, finest=0.1)
    schemes = "'average_acceleration' and 'central_difference' end at Δt = "
    with pytest.raises(NoTruth, match=rf"{schemes}.* s: {reason}\.$"):
        study.assess(model)


@pytest.mark.parametrize("kept", [slice(1, None), slice(None, -1)], ids=["from the first step", "to the step before"])
def test_output_may_lack_its_first_or_last_time(kept, tmp_path):
    model = program(lambda *job: {name: values[kept] for name, values in models.linear(*job).items()}, tmp_path)
    ds = study.assess(model, allowed_errors=[0.01])
    assert (ds.verdict == 0).all() and (ds.reference_uncertainty < 2e-4).all()


@pytest.mark.parametrize(
    "change, error, sentence",
    [
        ({"run": 3}, TypeError, "run must be a function of the name of a scheme and a step, not 3."),
        ({"schemes": "newmark"}, TypeError, "schemes must be a list of names, such as"),
        ({"schemes": ["newmark"]}, ValueError, "schemes must be at least two different names, not"),
        ({"duration": -1.0}, ValueError, "duration must be a time in s greater than zero, not -1.0."),
        ({"name": 3}, TypeError, "name must be a string, not 3."),
        ({"workers": 0}, ValueError, "workers must be a whole number greater than zero, not 0."),
        ({"coarsest": 15.0}, ValueError, "steps from 15 s down to .* do not fit a duration of 20 s"),
    ],
)
def test_an_unfit_program_is_refused(change, error, sentence, tmp_path):
    with pytest.raises(error, match=sentence):
        replace(program(models.linear, tmp_path), **change)


def test_ctrl_c_answers_what_is_known_and_loses_no_run(tmp_path):
    calls: list[tuple[str, float]] = []

    def interrupted(below, scheme, dt):
        """A program that is interrupted at the first step size below ``below`` that does not come from halving 1.25."""
        if dt < below and math.log2(1.25 / dt) % 1:
            raise KeyboardInterrupt
        calls.append((scheme, dt))
        return models.linear(scheme, dt)

    model = program(partial(interrupted, 0.1), tmp_path)
    with pytest.warns(RuntimeWarning, match="interrupted: no step is recommended where more runs were needed"):
        ds = study.assess(model, allowed_errors=[0.1, 0.001])
    found_verdict, out_of_time = VERDICTS.index("found"), VERDICTS.index("out_of_time")
    assert (ds.verdict.sel(allowed_error=0.1) == found_verdict).all()
    assert (ds.verdict.sel(allowed_error=0.001) == out_of_time).all()
    repeated = study.assess(replace(model, run=partial(interrupted, 0.0)), allowed_errors=[0.1, 0.001])
    assert (repeated.verdict == found_verdict).all()
    # one run of each scheme is always repeated, and one kept run of each by the second assessment
    assert len(calls) == len(set(calls)) + 2 * len(models.SCHEMES)


def test_ctrl_c_before_the_truth_is_known_ends_the_question(tmp_path):
    def interrupted(scheme, dt):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        study.assess(program(interrupted, tmp_path))


def _eight_seconds(run, scheme, dt, duration):
    """A run whose computing time is eight seconds divided by its step size in seconds."""
    return Run(scheme, dt, "completed", "", 1.0, 8.0 / dt, np.empty(0), {"peak": np.array(1.0)})


def test_no_first_run_begins_if_another_first_run_took_too_long(tmp_path, monkeypatch):
    """A kept run that is not repeated in time is not used either."""
    monkeypatch.setattr(runs, "attempt", _eight_seconds)
    model, jobs = program(models.linear, tmp_path, ["a", "b"], workers=1), [("a", 1.0), ("b", 1.0)]
    with Runs(model, seconds=5.0) as runs_of:
        assert [run.scheme for run in runs_of.run(jobs)] == ["a"] and runs_of.late
    with Runs(model) as runs_of:
        assert len(runs_of.run(jobs)) == 2 and not runs_of.late
    with Runs(model, seconds=5.0) as runs_of:
        assert [run.scheme for run in runs_of.run(jobs)] == ["a"] and runs_of.late


def test_no_run_begins_that_would_end_late_on_its_own_worker(tmp_path, monkeypatch):
    monkeypatch.setattr(runs, "attempt", _eight_seconds)
    with Runs(program(models.linear, tmp_path, ["a", "b"], workers=1), seconds=10.0) as runs_of:
        assert len(runs_of.run([("a", 1.0)])) == 1 and not runs_of.late
        assert len(runs_of.run([("a", 0.8)])) == 0 and runs_of.late


def _scattered(scheme, dt):
    """A number whose error scatters from one step size to the next, as with forces that have kinks."""
    return {"drift": 1 + (1 if scheme == "a" else -1) * dt**2 * (1 + 0.9 * np.sin(1e3 * dt))}


def test_a_cheap_program_confirms_its_steps_by_many(tmp_path, monkeypatch):
    model = program(_scattered, tmp_path, ["a", "b"])
    dear = study.assess(model, allowed_errors=[0.1])
    monkeypatch.setattr(search, "MOST_CONFIRMING", MOST_CONFIRMING)
    monkeypatch.setattr(search, "CHEAP", 1e3)  # cheap on a busy machine too
    ds = study.assess(model, allowed_errors=[0.1])
    for step in ds.recommended_step_size.values.ravel():
        fresh = step * 2.0 ** -np.random.default_rng(7).random(200)
        exceed = np.array([_scattered("a", dt)["drift"] for dt in fresh]) - 1 - 0.1
        assert (exceed > 0).sum() <= 6 and exceed.max() <= 0.01
    assert (dear.steps_tried < 30).all() and (ds.steps_tried > MOST_CONFIRMING).all()


def test_a_program_that_never_runs_has_no_truth(tmp_path):
    model = program(partial(models.fails, "nothing"), tmp_path, ["wrong", "average_acceleration"])
    with pytest.raises(NoTruth, match=r"no reference for 'model', as fewer .* 'wrong' ends at Δt = 1.25 s: it"):
        study.assess(replace(model, finest=1.0))
    with pytest.raises(NoTruth, match=r"'wrong' ends at Δt = 0.1562 s: it returned nothing.$"):
        study.assess(model)
    still = program(lambda scheme, dt: models.linear(scheme, dt) | {"idle": 0.0}, tmp_path / "still")
    with pytest.raises(NoTruth, match="the quantity 'idle' of 'model' is zero at all times"):
        study.assess(still)
    alone = program(lambda scheme, dt: {"idle": 0.0}, tmp_path / "alone")
    with pytest.raises(NoTruth, match="the quantity 'idle' of 'model' is zero at all times"):
        study.assess(alone)
    with pytest.raises(KeyError, match="'model' has no scheme 'newmark'; known are wrong, average_acceleration."):
        study.assess(model, ["newmark", "wrong"])


def test_runs_are_known_by_the_source(tmp_path):
    def identity(run):
        return replace(program(run, tmp_path), name=None).identity()

    assert identity(models.linear) == identity(partial(models.oscillator, 0.0)) != identity(models.hardening)
    namespace: dict = {}
    exec("def bare(scheme, dt): ...", namespace)
    with pytest.raises(
        ValueError, match="cannot be distinguished from runs of other programs.*give the program a name"
    ):
        identity(namespace["bare"])


def test_a_curve_at_its_steps_needs_no_spline():
    """Values at the steps are exact and need no spline; values between the steps come from a spline."""
    t = np.linspace(0, 1, 11)
    curve = Curve(t, np.stack([np.sin(t), np.cos(t)], axis=1))
    assert (curve.at(t[::2] + 1e-9) == curve.values[::2]).all() and "_spline" not in vars(curve)
    assert curve.at(t[:-1] + 0.05) == pytest.approx(
        np.stack([np.sin(t[:-1] + 0.05), np.cos(t[:-1] + 0.05)], 1), abs=1e-5
    )


def _on_another_branch(scheme, dt):
    """A number that converges to 1 with the schemes a and b, and to 1.5 with stray. Runs of b take the most time."""
    time.sleep(0.01 if scheme == "b" else 0.0)
    return {"drift": {"a": 1 + dt**2, "b": 1 - dt**2 / 2, "stray": 1.5 + dt**2}[scheme]}


def test_a_scheme_that_goes_to_another_motion_says_so(tmp_path):
    with pytest.warns(RuntimeWarning, match="to another motion: halving its steps to .* leaves an error of 50"):
        ds = study.assess(program(_on_another_branch, tmp_path, ["a", "b", "stray"]), allowed_errors=[0.1])
    assert [VERDICTS[code] for code in ds.verdict.values.ravel()] == ["found", "found", "not_even_the_finest_step"]


def test_one_slow_run_does_not_decide_the_time_of_a_step():
    """Would catch a time measured once: other work on the machine slows single runs of a program."""
    sizes = np.geomspace(0.1, 0.05, 9).tolist()
    runs = [Run("rk4", dt, "completed", "", (50 if dt == 0.1 else 1) / dt, 0.0, np.array([]), {}) for dt in sizes]
    searched = SimpleNamespace(
        refinement=SimpleNamespace(runs_of=lambda scheme: runs),
        certain=lambda *case: True,
        unfinished=lambda *case: False,
        needed=lambda *case: SimpleNamespace(largest=0.1, recommended=0.1, tried=9, largest_error=0.01),
        errors={("rk4", 0.1): {"displacement": 0.01}},
    )
    row = _row(searched, "rk4", ("displacement", 0.01))
    assert row["seconds"] == pytest.approx(10) and row["seconds_spread"] == pytest.approx(0)
