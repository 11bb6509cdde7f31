"""Reference values of quantities, and assessments that leave out a quantity or are refused."""

import numpy as np
import pytest

import study
from study.assessment import errors
from study.assessment.reference import Reference
from study.assessment.solution import DenseSolution


def _peak(problem, duration, function):
    reference = Reference(problem, duration)
    exactly = reference.solution(reference.routes[0], reference.grid(duration / 20), 1e-12)
    return errors.target(study.Quantity(function, reduce="peak"), problem, exactly).until(np.array([duration]))[0]


@pytest.mark.slow
def test_a_peak_at_a_kink_of_the_ground_motion_is_not_rounded_off():
    # the ground acceleration rises from 0 to 1 m/s² in one second, and falls again: at its kink ü = −sin(ω)/ω
    omega = 0.1
    ground = study.GroundMotion(np.array([0.0, 1.0, 0.0]), 1.0)
    soft = study.Problem(lambda u: omega**2 * u, 0.0, ground=ground)
    assert _peak(soft, 2.0, lambda a: a) == pytest.approx([np.sin(omega) / omega], rel=1e-9)


@pytest.mark.slow
def test_a_peak_between_the_points_of_the_reference_is_found():
    # the components 0.5 cos t + sin t and 2 sin t have their peaks at different times
    two = study.Problem(lambda u: u, np.array([0.5, 0.0]), v0=np.array([1.0, 2.0]))
    assert _peak(two, 6.0, lambda u: u) == pytest.approx([np.hypot(0.5, 1.0), 2.0], rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("dt", [0.03, 0.35])
def test_errors_along_time_are_those_at_every_step(dt):
    """A step is shorter than an interval of the reference, or crosses up to four of its ends."""
    t = np.linspace(0.0, 12.0, 121)
    exactly = DenseSolution(t, np.cos(t), -np.sin(t), -np.cos(t))
    problem = study.Problem(lambda u: u, 1.0)
    quantities = errors.named({"u": study.Quantity(lambda u: u), "v": study.Quantity(lambda v: v)})
    targets = [errors.target(quantity, problem, exactly) for quantity in quantities.values()]
    lanes = {"dt": np.array([dt, dt]), "steps": np.array([int(11 / dt), int(6 / dt)])}
    ds = study.run(problem, "rk4", **lanes, observe=errors.observers(targets))
    motion = study.run(problem, "rk4", dt=dt, steps=int(11 / dt))
    for target, differences in zip(targets, (motion.u - np.cos(motion.t), motion.v + np.sin(motion.t)), strict=True):
        ends = lanes["steps"] + 1
        largest = [np.abs(differences[:end]).max().item() for end in ends]
        assert errors.error(target, ds, ends * dt) == pytest.approx(largest, rel=1e-5, abs=2e-9)  # of the quintics


@pytest.mark.slow
def test_each_lane_is_compared_with_the_reference_that_begins_where_it_begins():
    """The lanes start from 1, from 2 and from an impulse 3; the first reference is longer than the others."""
    begins, t = [(1.0, 0.0), (2.0, 0.0), (0.0, 3.0)], np.linspace(0.0, 8.0, 81)
    problem, (quantity,) = study.Problem(lambda u: u, 1.0), errors.named({"u": study.Quantity(lambda u: u)}).values()
    references = []
    for (u0, v0), end in zip(begins, (81, 61, 61), strict=True):
        u, v = u0 * np.cos(t[:end]) + v0 * np.sin(t[:end]), v0 * np.cos(t[:end]) - u0 * np.sin(t[:end])
        references.append([errors.target(quantity, problem, DenseSolution(t[:end], u, v, -u))])
    order, dt = [2, 0, 1, 0], np.array([0.4, 0.1, 0.2, 0.3])
    u0, v0 = np.array(begins)[order].T
    observer, steps = errors.ErrorsAlong.of(*references), (5.9 / dt).astype(int)
    ds = study.run(problem, "rk4", dt=dt, steps=steps, u0=u0, v0=v0, observe=observer)
    for lane, number in enumerate(order):
        alone = errors.ErrorsAlong.of(references[number])
        single = study.run(problem, "rk4", dt=dt[lane], steps=steps[lane], u0=u0[lane], v0=v0[lane], observe=alone)
        assert ds[quantity.name].values[lane] == pytest.approx(single[quantity.name].item(), rel=1e-9, abs=1e-15)
        motion = study.run(problem, "rk4", dt=dt[lane], steps=steps[lane], u0=u0[lane], v0=v0[lane])
        exact = u0[lane] * np.cos(motion.t) + v0[lane] * np.sin(motion.t)
        error = (abs(motion.u - exact).max() / max(begins[number])).item()
        assert single[quantity.name].item() == pytest.approx(error, rel=1e-2)


def test_a_balance_without_energy_to_compare_with_is_left_out_with_a_warning():
    # a mass that hangs on a spring, released from rest at u = 0: the initial energy is zero
    hanging = study.Problem(lambda u: u - 1.0, 0.0, potential=lambda u: u**2 / 2 - u, damping=0.02, title="hanging")
    with pytest.warns(RuntimeWarning, match="the balance of energies of 'hanging' is left out: .* add a constant to"):
        ds = study.assess(hanging, "rk4", duration=5.0, allowed_errors=[0.1], maps=False)
    assert ds.quantity.values.tolist() == ["displacement", "velocity", "acceleration"]
    assert ds.starts == "No other start was tried: initial displacement, initial velocity and load are zero."


def test_a_duration_of_more_steps_than_a_search_has_is_refused_at_once():
    with pytest.raises(ValueError, match="duration must be at most .* 4,000,000 steps .* not 1e.12 s"):
        study.assess("pendulum", "rk4", duration=1e12)
    with pytest.raises(ValueError, match="schemes is empty"):
        study.assess("pendulum", {}, duration=5.0)


def test_a_motion_that_ends_in_infinity_is_reported_with_its_time():
    # u̇² = (u⁴ − 1)/2 from rest at u = 1: the displacement is infinite at t = 1.854
    runaway = study.Problem(lambda u: -(u**3), 1.0, potential=lambda u: -(u**4) / 4, title="runaway")
    reason = "force or potential of 'runaway' is no longer finite after t = 1.85.*; try a shorter duration"
    with pytest.raises(ValueError, match=reason):
        study.assess(runaway, "rk4", duration=50.0, maps=False)
