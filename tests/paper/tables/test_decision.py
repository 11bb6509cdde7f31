"""The cells of the table of decisions, from made-up datasets."""

import re
from functools import cache

import numpy as np
import pytest
import xarray as xr

from paper.picks import ERRORS, NO_BREAK, picks_of
from paper.tables.decision import QUANTITIES, tabulate
from study.io import flags

KINDS = len(QUANTITIES)
#: Number of rows of a spring: explicit and implicit schemes for each quantity.
ROWS = 2 * KINDS
TITLES = ("scheme", ["Cheap", "Dear", "Fails"])


def _assessed(forces: float, energy: float) -> xr.Dataset:
    """A spring of period one; at the largest allowed error the cheap scheme takes 8 steps, and the dear one 16.

    A step of the dear scheme takes one force evaluation, and a step of the cheap scheme takes ``forces``. The dear
    scheme has the smaller error, and takes less time. For the energy, ``energy`` multiplies all numbers of steps.
    """
    steps = np.broadcast_to(np.array([[8.0, 16, np.nan], [16, 32, 64], [np.nan] * 3])[:, None], (3, KINDS, 3)).copy()
    steps[:, QUANTITIES.index("energy")] *= energy
    dims = ("scheme", "quantity", "allowed_error")
    unused = dict.fromkeys(["recommended_error", "steps_tried", "worst_error"], (dims, steps))
    per_step, tried = np.array([forces, 1.0, 1.0])[:, None, None], np.unique(1 / steps[np.isfinite(steps)])
    made = np.broadcast_to(np.array([0.2, 0.1, np.nan])[:, None, None], (3, KINDS, len(tried)))
    verdict = np.where(np.isnan(steps), 2, steps == 8).astype(int)
    meanings = ("found", "already_the_coarsest_step", "not_even_the_finest_step")
    return xr.Dataset(
        {
            "recommended_dt": (dims, 1 / steps),
            "largest_dt": (dims, 1 / steps),
            "time": (dims, 1 / steps),
            "time_spread": (dims, steps),
            "force_evaluations": (dims, 100 * steps * per_step),
            "error": (("scheme", "quantity", "dt"), made),
            "verdict": (dims, verdict, flags("how the search ended", meanings, int)),
            "highest_frequency": 2.0,
            **unused,
        },
        coords={
            "scheme": ["cheap", "dear", "fails"],
            "scheme_title": TITLES,
            "kind": ("scheme", ["explicit", "explicit", "implicit"]),
            "quantity": list(QUANTITIES),
            "allowed_error": list(ERRORS),
            "dt": tried,
        },
        attrs={"duration": 100.0, "periods": 100, "problem": "softening spring"},
    )


def _robustness(*needed: float) -> xr.Dataset:
    return xr.Dataset(
        {
            "steps_needed": (("problem", "scheme", "level", "periods"), np.reshape(needed, (1, 2, 1, 1))),
            "most_steps": 128,
        },
        coords={
            "problem": ["softening"],
            "scheme": ["cheap", "dear"],
            "scheme_title": ("scheme", ["Cheap", "Dear"]),
            "level": [0.1],
            "periods": [100],
        },
    )


def _runs(
    name: str, problem: str, imbalance: float = 0.01, velocity: float = 0.0, acceleration: float = 0.0
) -> xr.Dataset:
    """Errors at two step sizes; a step takes five force evaluations by the dear scheme, and two by the cheap one."""
    dims = ("problem", "scheme", "steps_per_period")
    error = np.array([[[0.2, 0.005], [0.05, 1e-4], [np.nan, np.nan]]])
    return xr.Dataset(
        {
            name: (dims, error),
            "force_evaluations_per_step": (dims, np.array([[[2.0] * 2, [5.0] * 2, [5.0] * 2]])),
            "observed_order": (dims[:2], [[2.0, 1.2, np.nan]]),
            "max_energy_imbalance": (dims, np.full(error.shape, imbalance)),
            "velocity_error": (dims, np.full(error.shape, velocity)),
            "acceleration_error": (dims, acceleration * np.array([[[1.0, 2.0]] * 3])),
            "status": (dims, np.where(np.isnan(error), 1, 0)),
            "unknowns": ("problem", [3]),
            "period": ("problem", [2.0]),
            "highest_frequency": ("problem", [5.0]),
        },
        coords={
            "problem": [problem],
            "problem_title": ("problem", ["swinging thing"]),
            "scheme": ["cheap", "dear", "fails"],
            "scheme_title": TITLES,
            "explicit": ("scheme", [0, 0, 0]),
            "order": ("scheme", [2, 4, 4]),
            "steps_per_period": [20, 80],
        },
    )


def _spectrum() -> xr.Dataset:
    """Errors of the peak drift by scheme and step size; at the coarsest step the dear scheme is right by accident.

    The third scheme is implicit.
    """
    error = np.array([[0.5, 0.02, 0.8, 0.009], [0.001, 0.2, 0.8, 0.008], [1e-9, 1e-9, 1e-9, 1e-9]])
    dims = ("scheme", "step_size", "record", "period", "reduction")
    of_runs = error[:, :, None, None, None] * [1, 0.1]
    return xr.Dataset(
        {
            "error": (dims, of_runs),
            "force_evaluations_per_step": (dims, np.array([1.0, 3.0, 3.0])[:, None, None, None, None] + 0 * of_runs),
            "spacing": 0.02,
            "allowed_error": 0.01,
        },
        coords={
            "scheme": ["cheap", "dear", "fails"],
            "scheme_title": TITLES,
            "explicit": ("scheme", [1, 1, 0]),
            "step_size": [0.04, 0.02, 0.015, 0.01],
            "commensurate": ("step_size", [1, 1, 0, 1]),
            "record": ["quake"],
            "period": [2.0],
            "reduction": [1, 2],
        },
    )


def _limits() -> xr.Dataset:
    """Stability limits of the linear theory; only the cheap scheme has a finite one."""
    limits = (("scheme", "damping_ratio"), [[2.0], [np.inf], [np.inf]])
    return xr.Dataset({"stability_limit": limits}, {"scheme": ["cheap", "dear", "fails"], "damping_ratio": [0.0]})


@pytest.fixture(scope="module")
def rows():
    @cache
    def of(forces=1.0, needed=(32.0, 64.0), energy=1.0, imbalance=0.01, velocity=0.0, acceleration=0.0):
        table = tabulate(
            springs=[_assessed(forces, energy), _assessed(forces, energy)],
            robustness=_robustness(*needed),
            kinks=_runs("error", "yielding"),
            spectral=_limits(),
            spectrum=_spectrum(),
            structures=_runs("displacement_error", "pendulum", imbalance, velocity, acceleration),
        ).replace(NO_BREAK, " ", regex=True)
        return table.to_dict("records")[ROWS:]

    return of


def _steps(row):
    """The cells of a row without the parts in brackets."""
    return [re.sub(r" \(.*\)", "", row[column]) for column in ("10 %", "1 %", "0.1 %")]


def test_a_cell_of_a_spring_names_the_fewest_forces_whatever_the_time(rows):
    first, implicit, velocity, *others = rows()
    assert (first["Problem"], first["Scheme"]) == ("Softening spring", "explicit") and velocity["Problem"] == ""
    assert first["10 %"] == "Cheap: ≤ 8 (8 forces, ωΔt 0.25 < 2)"
    assert first["0.1 %"] == "Dear: 64 (64 forces, ωΔt 0.031)"
    assert _steps(first) == ["Cheap: ≤ 8", "Cheap: 16", "Dear: 64"]
    assert implicit["Scheme"] == "implicit" and {implicit[column] for column in ("10 %", "1 %", "0.1 %")} == {"–"}
    assert [row["Right in"] for row in (first, velocity, *others[1 : ROWS - 3 : 2])] == list(QUANTITIES)
    # 17.6 and 16 force evaluations tie, so the scheme with the smaller error is named; 18.4 and 16 do not tie
    assert rows(forces=2.2)[0]["10 %"] == "Dear: 16 (16 forces, ωΔt 0.12); …"
    assert _steps(rows(forces=2.3)[0])[0] == "Dear: 16"


def test_the_energy_must_be_right_too(rows):
    first, *_ = rows(energy=2.0)
    # 16 steps keep the energy to ten percent; they are named although 8 steps keep the displacement
    assert _steps(first) == ["Cheap: 16", "Cheap: 16", "Dear: 64"]


def test_the_steps_at_other_amplitudes_are_stated(rows):
    def stated(*needed):
        return rows(needed=needed)[0]["Beware of"]

    assert _steps(rows()[0])[0] == "Cheap: ≤ 8"
    assert stated(32.0, 64.0) == "at all amplitudes: 32"
    assert stated(8.0, 64.0) == ""
    assert stated(np.nan, 64.0) == "at all amplitudes: more than 128"


def test_elsewhere_the_fewest_forces_decide(rows):
    explicit, structure, _, energy, _, kinked, record, implicit = rows()[ROWS:]
    assert explicit["Problem"] == "Swinging thing" and explicit["10 %"] == "–"
    # 20 steps of five force evaluations, compared with 80 steps of two
    assert structure["Scheme"] == "implicit" and structure["10 %"] == "Dear: ≤ 20 (100 forces, ωΔt 0.5)"
    assert structure["1 %"] == "Cheap: 80 † (160 forces, ωΔt 0.12 < 2)" and _steps(structure)[2] == "Dear: 80 †"
    assert structure["Beware of"] == "lost by Fails"
    assert energy["Beware of"] == ""
    # the energy balance errs by 1 % in all runs; at 20 steps the cheap scheme's displacement is wrong
    assert _steps(energy) == ["Dear: ≤ 20", "Dear: ≤ 20", "–"]
    assert kinked["Beware of"] == "only first order: Dear"
    assert rows(imbalance=0.11)[ROWS + 1]["10 %"] == "–"
    # the dear scheme keeps the error at a coarse step by accident, and not at a finer step
    assert _steps(record) == ["Cheap: 20 ms", "Cheap: 10 ms", "–"]
    assert record["10 %"] == "Cheap: 20 ms (50 forces/s, ωΔt 0.063 < 2)"
    assert implicit["0.1 %"] == "Fails: 40 ms (75 forces/s, ωΔt 0.13)"
    # all runs of the cheap scheme with steps of 15 ms exceed the error, but only half at the record's spacing
    assert (record["Beware of"], implicit["Beware of"]) == ("other steps", "")


def test_of_schemes_that_tie_a_step_that_a_finer_one_confirms_comes_first():
    runs = _runs("error", "swinging thing").isel(problem=0)
    # 20 steps of eight force evaluations, and 80 steps of two with a smaller error
    runs["force_evaluations_per_step"].loc["dear"] = 8.0
    picks = picks_of(runs, runs.error, 0.1, dict.fromkeys(runs.scheme.values, np.inf))
    assert [(pick.title, pick.step, pick.forces) for pick in picks] == [
        ("Dear", "≤\u00a020", "160 forces"),
        ("Cheap", "80 †", "160 forces"),
    ]


def test_a_scheme_whose_velocity_or_acceleration_is_wrong_is_not_recommended(rows):
    assert _steps(rows(velocity=0.74)[ROWS + 1])[0] == "Dear: ≤ 20"
    assert rows(velocity=0.76)[ROWS + 1]["10 %"] == "–"
    # the finer step has twice the acceleration error; if this exceeds the bound, the coarse step is not named either
    assert _steps(rows(acceleration=0.62)[ROWS + 1])[0] == "Dear: ≤ 20"
    assert rows(acceleration=0.63)[ROWS + 1]["10 %"] == "–"
    assert rows(acceleration=0.63)[ROWS + 1]["Beware of"] == "lost by Fails; velocity or acceleration sets the step"


def test_an_acceleration_that_is_wrong_at_the_steps_named_is_a_warning(rows):
    # the cell of 10 % names the coarse step, and the cell of 1 % the fine one
    assert rows(acceleration=0.4)[ROWS + 1]["Beware of"] == "lost by Fails; acceleration wrong by 40 to 80 %"
    assert rows(acceleration=0.05)[ROWS + 1]["Beware of"] == "lost by Fails"
