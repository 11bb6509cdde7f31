"""Wrong calls and faulty codes: each gets one sentence that names the cause."""

import os
import sys
import time
from functools import partial

import numpy as np
import pytest

from conformance import runners
from conformance.__main__ import main
from conformance.command import cases
from conformance.judge import CASES, judge

ALL = list(cases())


def _verdicts(runner, chosen):
    return [judge(case, partial(runner, case)) for case in chosen]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "name one code: MODULE:FUNCTION, or --command, or --collect."),
        (["nowhere:step"], "'nowhere:step' must name a module and a function in it, such as my_code:step"),
        (["--collect", "nowhere"], "there is no folder 'nowhere'."),
        (["--collect", str(CASES)], "has no table of a case, such as A-LIN-AVG.csv."),
        (["conformance.examples.newmark:FAMILIES"], "FAMILIES is not a function"),
        (
            ["conformance.examples.newmark:step", "--only", "A", "newmrk"],
            "no case has the tag 'newmrk'; tags are A, B,",
        ),
        (["conformance.examples.newmark:step", "--skip", "Z"], "no case has the tag 'Z'"),
        (
            ["conformance.examples.newmark:step", "--only", "A", "B"],
            "no case has all tags of --only and none of --skip.",
        ),
        (["--command", "awk '{ print }' {case}"], "must contain {case} and {out}"),
        (["--command", "prog {case} '{out}"], "cannot be split into words (No closing quotation)."),
        (["--command", "./nowhere {case} {out}"], "the command './nowhere' cannot be started"),
    ],
)
def test_a_wrong_call_gets_one_sentence(words, sentence, capsys):
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2 and sentence in capsys.readouterr().err


def _wrong(problem, scheme, dt, steps):
    if scheme["family"] == "wilson":
        raise ZeroDivisionError("division by zero")
    if scheme["family"] == "houbolt":
        return [np.full(steps + 1, np.nan)] * 2
    return [np.zeros(steps)] * 2


def test_a_code_that_raises_or_returns_something_else_fails_with_a_sentence():
    outcomes = _verdicts(runners.step_runner(_wrong), [case for case in ALL if case["name"].startswith("A-LIN")])
    causes = {outcome.name: outcome.cause for outcome in outcomes}
    assert causes["A-LIN-WIL"] == "the code raises ZeroDivisionError: division by zero"
    assert causes["A-LIN-HOU"] == "u is not finite from step 0 on"
    assert causes["A-LIN-AVG"] == "u has the shape (2, 1), not (3, 1): a row for t = 0 and for each step"


@pytest.mark.parametrize(
    ("result", "sentence"),
    [
        (None, "the function must return u, v and, if available, a"),
        ({"u": 0, "v": 0}, "the function must return u, v and, if available, a"),
        ([np.zeros((3, 1))] * 4, "the function must return u, v and, if available, a"),
        ([np.zeros((3, 1)), [["a"]] * 3], "v must be an array of numbers, with a row for t = 0 and for each step"),
        ([None, np.zeros((3, 1))], "u must be an array of numbers, with a row for t = 0 and for each step"),
    ],
)
def test_a_function_that_returns_no_motion_fails_with_a_sentence(result, sentence):
    runner = runners.step_runner(lambda problem, scheme, dt, steps: result)
    (verdict,) = _verdicts(runner, [case for case in ALL if case["name"] == "A-LIN-AVG"])
    assert (verdict.verdict, verdict.cause) == ("fail", sentence)


def test_a_function_may_import_its_neighbours_when_it_runs(tmp_path):
    (tmp_path / "neighbour.py").write_text("from conformance.examples.newmark import step", encoding="utf-8")
    text = "def late(*given):\n    from neighbour import step\n    return step(*given)\n"
    (tmp_path / "late_code.py").write_text(text, encoding="utf-8")
    (verdict,) = _verdicts(runners.function_runner(f"{tmp_path / 'late_code.py'}:late"), [ALL[0]])
    assert verdict.verdict == "pass"


_TABLE = "out.csv must have a line of names and rows with as many numbers, separated by commas"


@pytest.mark.parametrize(
    ("script", "verdict", "sentence"),
    [
        ("echo no licence >&2; exit 3", "fail", "the command ends with status 3: no licence"),
        ("exit 77", "skip", ""),
        ("kill -9 $$", "fail", "the command is ended by signal 9"),
        ("echo text", "fail", "the command writes no file {out}"),
        ("echo t,u1 > {out}", "fail", _TABLE),
        ("printf 't;u1\\n0;1\\n' > {out}", "fail", _TABLE),
        ("printf 't,u1\\n0,1,2\\n0,1\\n0,1\\n' > {out}", "fail", _TABLE),
        ("printf 't,v1\\n0,1\\n' > {out}", "fail", "out.csv has no column u1"),
        (
            "printf 't, u1\\n0,1\\n1,1\\n' > {out}",
            "fail",
            "u has the shape (2, 1), not (3, 1): a row for t = 0 and for each step",
        ),
        ("printf 't,u1\\n0,1\\n1,1\\n2,1\\n' > {out}", "fail", "t is 1 after 1 steps, and not 0.05"),
        ("printf 't,u1\\n0,1\\n.05,nan\\n.1,1\\n' > {out}", "fail", "u is not finite from step 1 on"),
    ],
)
def test_a_command_that_fails_is_a_failure_of_the_case(script, verdict, sentence, tmp_path):
    (tmp_path / "run.sh").write_text(script.replace("{out}", '"$2"'), encoding="utf-8")
    runner = runners.command_runner(f"sh {tmp_path / 'run.sh'} {{case}} {{out}}")
    (outcome,) = _verdicts(runner, [case for case in ALL if case["name"] == "A-LIN-AVG"])
    assert (outcome.verdict, outcome.cause) == (verdict, sentence)


def test_a_command_that_hangs_ends_with_the_programs_that_it_started(tmp_path, monkeypatch):
    monkeypatch.setattr(runners, "TIMEOUT", 0.5)
    (tmp_path / "run.sh").write_text(f"(sleep 1.5; touch {tmp_path / 'late'}) & wait", encoding="utf-8")
    (verdict,) = _verdicts(runners.command_runner(f"sh {tmp_path / 'run.sh'} {{case}} {{out}}"), ALL[:1])
    assert (verdict.verdict, verdict.cause) == ("fail", "the command takes longer than 0.5 s")
    time.sleep(1.5)
    assert not (tmp_path / "late").exists()


_FAULTY = """import ctypes, os, sys, time

def step(problem, scheme, dt, steps):
    match scheme["family"]:
        case "newmark":
            ctypes.CDLL(None).pause()  # a hang of compiled code, which no exception ends
        case "houbolt":
            ctypes.string_at(0)
        case "bathe":
            sys.exit(4)
    raise NotImplementedError(os.getpid())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no function pause")
def test_a_function_that_hangs_or_ends_its_process_fails_and_the_next_case_runs(tmp_path, monkeypatch):
    """Only this test finds that compiled code that hangs or crashes ends the kit, or that no new process starts."""
    (tmp_path / "faulty.py").write_text(_FAULTY, encoding="utf-8")
    runner = runners.function_runner(f"{tmp_path / 'faulty.py'}:step")
    monkeypatch.setattr(runners, "CALL_TIMEOUT", 0.5)
    chosen = [case for case in ALL if case["name"] in ("A-LIN-AVG", "A-LIN-BAT", "A-LIN-CDM", "A-LIN-HOU")]
    hung, exited, skipped, crashed = _verdicts(runner, chosen)
    assert (hung.verdict, hung.cause) == ("fail", "the function takes longer than 0.5 s")
    assert (exited.verdict, exited.cause) == ("fail", "the code raises SystemExit: 4")
    assert skipped.verdict == "skip" and int(skipped.cause) != os.getpid()
    assert (crashed.verdict, crashed.cause) == ("fail", "the code is ended by signal 11")


def test_an_energy_without_a_velocity_is_skipped(tmp_path):
    (case,) = [case for case in ALL if case["name"] == "B-BOUND-AVG"]
    rows = "".join(f"{100 * i},1\n" for i in range(101))
    (tmp_path / "B-BOUND-AVG.csv").write_text("t,u1\n" + rows, encoding="utf-8")
    (verdict,) = _verdicts(runners.folder_runner(tmp_path), [case])
    assert (verdict.verdict, verdict.cause) == ("skip", "an energy needs the velocity")
