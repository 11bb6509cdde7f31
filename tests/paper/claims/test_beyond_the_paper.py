"""Claims on stability, structures and materials: each check is tested where it holds and where it fails."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import materials, stability, structures
from paper.measures.kinks import KINKED
from tests.paper.claims.made_up import filled


@pytest.mark.parametrize(
    "a_step, apart, holds, ours",
    [(0.051, 75, True, "0.05"), (0.049, 75, False, "0.05"), (0.1, -1, False, "0.10")],
)
def test_a_map_is_chaotic_by_its_exponent_and_its_perturbation(a_step, apart, holds, ours):
    variables = {"lyapunov_exponent": ("step_size", [a_step / 2.5]), "steps_until_apart": ("step_size", [apart])}
    finding = stability.chaos_of_average_acceleration(xr.Dataset(variables, {"step_size": [2.5]}))
    assert (finding.holds, finding.ours) == (holds, ours)


@pytest.mark.parametrize(
    "steps, holds, reason",
    [
        ([20, 20, 20], True, ""),
        ([20, np.nan, 20], True, "only on hardening and double well"),
        ([20, 21, np.nan], False, "only on hardening"),
        ([32, 21, np.nan], False, "only on none"),
    ],
)
def test_a_twentieth_is_reasonable_where_twenty_steps_suffice(steps, holds, reason):
    problems = ["hardening", "softening", "double_well"]
    along = {"problem": problems, "scheme": ["average_acceleration"], "amplitude": [0.1, 1.0]}
    error = filled(0.01, **along, step_size_over_period=[1 / 128, 1 / 32, 1 / 21, 1 / 20, 1 / 10])
    for problem, most in zip(problems, steps, strict=True):
        too_large = error.step_size_over_period > 1 / most if most > 0 else error.step_size_over_period > 0
        error.loc[{"problem": problem, "amplitude": 1.0}] += 0.1 * too_large
    data = xr.Dataset({"max_energy_error": error})
    finding = stability.a_twentieth_at_every_amplitude(data)
    assert (finding.holds, finding.qualification) == (holds, reason)
    assert ("more than 128" in finding.ours) == bool(np.isnan(steps).any())


def _structures(error=0.01, imbalance=0.01):
    """Runs on two structures, all with the given displacement error and the given imbalance of energies."""
    schemes = ["average_acceleration", "central_difference", "newmark_dissipative", "wilson_theta", "houbolt", "rk4"]
    along = {"problem": ["stiff_soft", "fpu_chain"], "scheme": schemes, "steps_per_period": [20]}
    runs = xr.Dataset({"status": filled(0, **along), "sampled_displacement_error": filled(error, **along)})
    return runs.assign(max_energy_imbalance=filled(imbalance, **along))


@pytest.mark.parametrize("error, holds", [(0.099, True), (0.101, False), (np.nan, False)])
def test_a_twentieth_on_structures_is_decided_by_the_displacement(error, holds):
    finding = structures.a_twentieth_on_structures(_structures(error))
    assert finding.holds == holds and ("failed" in finding.ours) == np.isnan(error)


def _kinks(gain=10.0, order=2.0, imbalance=1e-15, equal=1.0):
    error = np.full((3, 3, 2), 1e-2)
    error[:, 1] /= gain
    error[:, 2] *= equal
    return xr.Dataset(
        {
            "sampled_error": (("problem", "scheme", "steps_per_period"), error),
            "force_evaluations_per_step": (
                ("problem", "scheme", "steps_per_period"),
                np.broadcast_to([[1.0], [4.0], [1.0]], (3, 3, 2)),
            ),
            "observed_order": (("problem", "scheme"), np.full((3, 3), order)),
            "max_energy_imbalance": (("problem", "scheme", "steps_per_period"), np.full((3, 3, 2), imbalance)),
        },
        {
            "problem": KINKED,
            "scheme": ["average_acceleration", "rk4", "central_difference"],
            "steps_per_period": [64, 256],
        },
    )


@pytest.mark.parametrize(
    "gain, order, equal, verdict",
    [
        (1.0, 2.0, 1.0, "reproduced"),
        (1.0, 4.0, 1.0, "not reproduced"),
        # at equal step sizes Runge-Kutta errs less than average acceleration; at equal numbers of force evaluations it
        # errs as much as central difference
        (10.0, 2.0, 0.1, "reproduced with a qualification"),
        (10.0, 2.0, 1.0, "not reproduced"),
    ],
)
def test_the_order_does_not_matter_if_neither_order_nor_error_at_equal_forces_does(gain, order, equal, verdict):
    assert materials.order_does_not_matter(_kinks(gain, order, equal=equal)).verdict == verdict


@pytest.mark.parametrize(
    "imbalance, error, holds", [(9e-9, 1.1e-3, False), (1.1e-8, 1.1e-3, True), (9e-9, 0.9e-3, True)]
)
def test_a_balance_that_is_kept_by_a_wrong_motion_is_no_verdict(imbalance, error, holds):
    kinks = _kinks(imbalance=imbalance)
    kinks["sampled_error"][:] = error
    assert materials.balance_is_a_verdict(kinks).holds == holds


@pytest.mark.parametrize("step, holds", [(1 / 19, True), (1 / 21, False), (np.nan, False)])
def test_twenty_steps_are_enough_where_no_oscillator_needs_more(step, holds):
    needed = xr.DataArray(
        [[[[[0.1, step]]]]],
        dims=("condition", "record", "scheme", "period", "reduction"),
        coords={
            "condition": ["any_step"],
            "scheme": ["average_acceleration"],
            "period": [1.0],
            "reduction": [1.0, 4.0],
        },
    )
    assert materials.twenty_steps_for_the_peak(needed.to_dataset(name="largest_step_size")).holds == holds


@pytest.mark.parametrize("between, holds", [([0.5, 0.5], False), ([0.001, 0.5], True), ([0.001, 0.001], True)])
def test_a_finer_step_is_better_where_fewer_runs_are_beyond_the_error(between, holds):
    error = xr.DataArray(
        [[[[[0.001, 0.5]]], [[between]], [[[0.001, 0.001]]]]],
        dims=("scheme", "step_size", "record", "period", "reduction"),
        coords={
            "scheme": ["average_acceleration"],
            "step_size": [0.02, 0.015, 0.01],
            "divides": ("step_size", [1, 0, 1]),
            "period": [1.0],
            "reduction": [1.0, 4.0],
            "spacing": 0.02,
            "allowed_error": 0.01,
        },
    )
    assert materials.finer_is_better_under_a_record(error.to_dataset(name="peak_drift_error")).holds == holds


@pytest.mark.parametrize(
    "closed, holds, reason",
    [
        (["hht_alpha", "bathe"], True, ""),
        (["bathe"], False, "it is closed with bathe only"),
        ([], False, "it is closed with none only"),
        (
            ["central_difference", "hht_alpha", "bathe"],
            False,
            "it is closed with central difference, hht alpha and bathe only",
        ),
    ],
)
def test_tongues_are_closed_where_their_edges_are_missing(closed, holds, reason):
    schemes = [*stability.FAITHFUL, *stability.CLOSING]
    along = {"steps_per_period": [10, 20], "epsilon": [0.1, 0.8], "tongue": [1, 2], "side": ["lower", "upper"]}
    edge = filled(4.0, scheme=schemes, **along)
    edge.loc[{"scheme": closed, "steps_per_period": 10, "epsilon": 0.1, "tongue": 2}] = np.nan
    finding = stability.dissipation_closes_tongues(xr.Dataset({"edge": edge}))
    assert (finding.holds, finding.qualification) == (holds, reason)


@pytest.mark.parametrize(
    "failing, holds, thresholds",
    [
        ({"average_acceleration": [10, 40], "implicit_midpoint": [20]}, True, ["40", "20", "none"]),
        ({"average_acceleration": [10], "implicit_midpoint": [20], "energy_momentum": [10]}, False, ["10", "20", "10"]),
        ({"average_acceleration": [10]}, False, ["10", "none", "none"]),
    ],
)
def test_failures_of_rotating_structures_are_thresholds(failing, holds, thresholds):
    names = ["average_acceleration", "implicit_midpoint", "energy_momentum"]
    along = {"problem": ["elastic_pendulum", "fpu_chain"], "steps_per_period": [10, 20, 40, 80]}
    imbalance = filled(0.0, scheme=names, **along)
    for name, steps in failing.items():
        imbalance.loc[{"scheme": name, "steps_per_period": steps, "problem": "elastic_pendulum"}] = 0.2
    imbalance.loc[{"problem": "fpu_chain"}] = 0.2  # this structure does not rotate
    status = filled(0, scheme=names, **along)
    finding = structures.conserving_on_stiff_structures(
        xr.Dataset({"max_energy_imbalance": imbalance, "status": status}).assign_coords(scheme_title=("scheme", names))
    )
    assert finding.holds == holds
    assert [part.rpartition(": ")[2] for part in finding.ours.split("; ")] == thresholds
