"""Outcomes of runs of structures."""

from study.analysis.outcomes import Outcome
from study.experiments.structure_stability import structure_stability
from study.mechanics.newton import MAX_ITERATIONS


def test_a_coarse_step_can_tame_chaos():
    one = [{"problem": "duffing_chaotic", "periods": 200}]
    ds = structure_stability(one, ["central_difference", "rk4"], [1], [14, 80]).squeeze()
    assert ds.lyapunov_exponent.sel(scheme="central_difference", steps_per_period=14) < -0.3
    assert (ds.lyapunov_exponent.sel(steps_per_period=80) > 0.3).all()


def test_structures_end_as_their_energies_say():
    one = [{"problem": "pendulum", "periods": 20}]
    ds = structure_stability(one, ["central_difference", "energy_momentum"], [0.5, 1], [4, 320]).squeeze()
    outcome = ds.outcome.values
    # with four steps in the time scale of the pendulum, ωΔt of small oscillations is beyond the stability limit of 2
    assert (outcome[0, :, 0] == Outcome.GROWING).all() and (outcome[:, :, 1] == Outcome.ACCURATE).all()
    # the energy-momentum method keeps the energy at this step size too, but its Newton iteration needs a bracket
    assert (outcome[1, :, 0] == Outcome.ACCURATE).all() and not ds.status.any()
    iterations = ds.max_newton_iterations
    assert (iterations.sel(scheme="central_difference") == 0).all()
    assert iterations.sel(scheme="energy_momentum").values[:, 1].max() < MAX_ITERATIONS < iterations.max()
    assert ds.apart_at_step.max() < 20 * 320 and ds.apart_at_step.min() == -1
