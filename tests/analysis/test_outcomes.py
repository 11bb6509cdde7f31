"""Outcomes of runs."""

import numpy as np
import pytest

import study
from study.analysis.outcomes import Outcome, outcomes
from study.marching.run import sweep
from study.observer.outcome import OutcomeObserver


@pytest.mark.slow
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
        ("softening", 4.0, "houbolt", 1.0, 400, "damped_to_rest"),
        ("hardening", 1.5, "central_difference", 0.15, 400, "unbounded"),
    ],
)
def test_how_runs_end(problem, u0, scheme, dt, steps, outcome):
    definition = study.problems[problem]
    runs = sweep(
        problem, scheme, dt=dt, steps=steps, u0=[u0], observe=[OutcomeObserver.of(definition), "lyapunov_exponent"]
    )
    ended, began = outcomes(runs)
    assert Outcome(ended[0]).name.lower() == outcome
    assert np.isnan(began[0]) == (outcome == "accurate" or runs.status.item() > 0)
    assert np.isnan(began[0]) or 0 < began[0] <= steps * dt
    beyond = Outcome(outcomes(runs, beyond=True)[0][0]).name.lower()
    assert beyond == ("beyond_the_limit" if outcome == "bounded" else outcome)


def test_an_accurate_run_keeps_the_period_too():
    """The energy-momentum method keeps the energy at every step size, so the period error decides about accuracy."""
    observer = OutcomeObserver.of("softening")
    u0, period = [10.0], 2.0
    observe = [observer, "lyapunov_exponent", "oscillations"]
    runs = study.run("softening", "energy_momentum", dt=0.2, steps=200, u0=u0, observe=observe)
    period = runs.mean_period.values
    assert outcomes(runs)[0] == outcomes(runs, 1.009 * period)[0] == Outcome.ACCURATE
    assert outcomes(runs, 1.011 * period)[0] == Outcome.BOUNDED
    with pytest.raises(ValueError, match="observe 'oscillations'"):
        outcomes(runs.drop_vars("mean_period"), period)


@pytest.mark.slow
def test_a_motion_that_is_damped_out_of_chaos_was_not_chaotic():
    # at first neighbouring runs diverge; later most of the runs come to rest
    definition = study.problems["softening"]
    observe = [OutcomeObserver.of(definition), "lyapunov_exponent"]
    runs = study.run(
        definition, "wilson_theta", dt=np.linspace(0.05, 0.4, 64), steps=4000, u0=[10.0] * 64, observe=observe
    )
    ended, _ = outcomes(runs)
    chaotic = ended == Outcome.CHAOTIC
    assert (runs.lyapunov_exponent.values[chaotic] > 0).all()


@pytest.mark.parametrize("observe", [["max_energy_error"], ["lyapunov_exponent"], [OutcomeObserver.of("double_well")]])
def test_outcomes_need_their_observers(observe):
    runs = study.run("double_well", "average_acceleration", dt=2.5, steps=10, u0=[0.5], observe=observe)
    with pytest.raises(ValueError, match=r"observe study.OutcomeObserver.of\(problem\) and 'lyapunov_exponent'"):
        outcomes(runs)
