"""The schemes of the study, judged by the conformance kit, which shares no code with them."""

import json
from functools import partial
from pathlib import Path

import jax
import pytest

from conformance import VERSION, runners
from conformance.codes import time_integration_study
from conformance.command import cases
from conformance.judge import judge

VERDICTS = Path(__file__).parents[1] / "conformance" / "verdicts"
ALL = list(cases())


def verdicts(runner, chosen):
    return [judge(case, partial(runner, case)) for case in chosen]


@pytest.mark.slow
def test_the_study_passes():
    """Run all cases of levels A to D and G. Cases of E and F compile a program each; they run for four schemes only.

    On unequal steps the study's α-methods move the carried acceleration to the time that the new step size needs. The
    kit lists this form as an alternative.
    """
    chosen = [case for case in ALL if case["name"][0] in "ABCDG" or case["name"][-3:] in ("AVG", "HHT", "BAT", "RK4")]
    moved = {case["name"] for case in ALL if case["name"][0] == "G" and case["name"][-3:] in ("GEN", "HHT")}
    with jax.numpy_rank_promotion("allow"), jax.numpy_dtype_promotion("standard"):
        outcomes = verdicts(runners.step_runner(time_integration_study.step), chosen)
    assert {outcome.name for outcome in outcomes if outcome.verdict != "pass"} == moved
    assert {outcome.verdict for outcome in outcomes if outcome.name in moved} == {"differs"}
    stored = json.loads((VERDICTS / "study.json").read_text(encoding="utf-8"))
    assert stored["counts"] == {"pass": len(ALL) - len(moved), "differs": len(moved), "fail": 0, "skip": 0}
    assert stored["kit"] == VERSION


@pytest.mark.slow
def test_diffrax_has_average_acceleration_as_the_trapezoidal_rule():
    """The runner of diffrax passes the case of average acceleration on unequal steps."""
    pytest.importorskip("diffrax")
    from conformance.codes import diffrax_code

    (case,) = [case for case in ALL if case["name"] == "G-LIN-AVG"]
    with jax.numpy_rank_promotion("allow"), jax.numpy_dtype_promotion("standard"):
        (verdict,) = verdicts(runners.step_runner(diffrax_code.step), [case])
    assert verdict.verdict == "pass" and verdict.digits > 12
