"""The conformance kit: its cases, its runners, and the mistakes that it finds."""

import json
import re
import shutil
import subprocess
from collections import Counter, defaultdict
from functools import partial
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Any

import jsonschema
import numpy as np
import pytest
from mpmath import mp

from conformance import VERSION, generate, runners
from conformance.__main__ import main
from conformance.causes import Known
from conformance.command import cases
from conformance.contents import ORDERS, PROBLEMS, SCHEMES
from conformance.examples import newmark
from conformance.judge import judge, judged
from conformance.tests import mutations

KIT = Path(__file__).parents[1]
ALL = list(cases())
#: Fast cases for the programs with mistakes; together the cases reach every line of the example programs.
QUICK = [case for case in ALL if case["name"].startswith(("A-", "D-HARM", "E-YIELD", "F-MASS", "G-"))]


def verdicts(runner, chosen=ALL):
    return judged(chosen, runner)


def _number(version):
    return [int(part) for part in version.split(".")]


def counted(outcomes):
    return Counter(verdict.verdict for verdict in outcomes)


@pytest.mark.parametrize("file", sorted((KIT / "codes").glob("*.py")), ids=lambda file: file.stem)
def test_a_runner_is_short(file):
    """The study's own runner, which models all problems in JAX, may be longer."""
    assert len(file.read_text(encoding="utf-8").splitlines()) <= (160 if file.stem == "time_integration_study" else 80)


def test_every_case_follows_the_schema_and_is_small():
    validator = jsonschema.Draft202012Validator(json.loads((KIT / "schema.json").read_text()))
    files = sorted(generate.CASES.glob("*.json"))
    assert len(files) >= 250 and sum(file.stat().st_size for file in files) <= 1_000_000
    for file in files:
        assert file.stat().st_size <= 20_000
        validator.validate(json.loads(file.read_text(encoding="utf-8")))
    assert max((case["version"] for case in ALL), key=_number) == VERSION
    assert all(("sizes" in case["run"]) == ("unequal_steps" in case["tags"]) for case in ALL)
    records = [case["problem"]["ground"]["acceleration"] for case in ALL if "ground" in case["problem"]]
    assert records and {record[-1] for record in records} == {"0"}, "codes differ in the load at a last sample"
    assert {case["name"][0] for case in ALL} == set("ABCDEFG")


def test_a_case_never_changes():
    """The SHA-256 of all cases of a version is fixed, unless one of these cases is removed."""
    digests: defaultdict[str, Any] = defaultdict(sha256)
    for file in sorted(generate.CASES.glob("*.json")):
        text = file.read_bytes()
        digests[json.loads(text)["version"]].update(text)
    assert {version: digest.hexdigest() for version, digest in digests.items()} == {
        "2026.1": "6d010550ea0f8ebd4d6b003ceeb7d33299634be0927f9af091eb51e1b878cb10",
        "2026.2": "5fd46c83021deaf7b836237acf0f0258edea9139a1e829c712c7f15c96908b16",
    }


@pytest.mark.parametrize(
    "place",
    ["A-LIN-HHT", "B-30-WIL", "C-SOFT-HOU", "D-BASE-NBA", "E-YIELD-BAT", "F-MASS-AVG", "B-BOUND-KRA", "G-CUB-HHT"],
)
def test_a_case_is_what_the_generator_makes(place):
    """Only this test finds that the formulas, which also explain a wrong order, no longer give the cases."""
    problem, _, code = place.rpartition("-")
    (entry,) = [entry for entry in PROBLEMS if entry.name == problem]
    with mp.workdps(generate.DIGITS):
        text = generate.written(generate.case(entry, code, *SCHEMES[code]))
    assert (generate.CASES / f"{place}.json").read_text(encoding="utf-8") == text


def test_the_stored_end_of_a_case_of_order_is_exact():
    """The stored value agrees with SciPy's DOP853, which is independent of the Taylor series of the generator."""
    from scipy.integrate import solve_ivp

    from conformance.problem import Problem

    (entry,) = ORDERS
    (case,) = [case for case in ALL if case["name"] == "D-ORDER-RK4"]
    equation = Problem(entry.problem)

    def slope(t, y):
        return [y[1], ((equation.load(t) - equation.damping @ y[1:] - equation.force(y[:1])) / equation.mass[0, 0])[0]]

    end = solve_ivp(slope, (0, 2), [*equation.u0, *equation.v0], method="DOP853", rtol=1e-13, atol=1e-14).y[0, -1]
    assert float(case["expect"][0]["value"]) == pytest.approx(end, abs=1e-11)


def test_the_example_in_numpy_passes_what_it_does():
    """Only this test judges a right program by all of the cases that it supports."""
    outcomes = verdicts(runners.step_runner(newmark.step))
    assert counted(outcomes)["pass"] == sum(case["scheme"]["family"] in newmark.FAMILIES for case in ALL)
    assert set(counted(outcomes)) == {"pass", "skip"}


def _mutated(text, change):
    old, new, cause = change
    assert text.count(old) >= 1, old
    return text.replace(old, new), cause


def _caught(runner, chosen, cause):
    """Whether a case fails or differs, and reports the expected cause; the first such case ends the run."""
    known: Known = set()
    outcomes = (judge(case, partial(runner, case), known) for case in chosen)
    return any(
        outcome.verdict in ("fail", "differs") and cause in f"{outcome.cause} ({outcome.where})" for outcome in outcomes
    )


@pytest.mark.parametrize("change", mutations.PYTHON, ids=lambda change: change[2])
def test_a_mistake_in_the_numpy_program_is_caught_and_named(change):
    """Only this test finds that one of the known mistakes is missed or has another name."""
    module: Any = ModuleType("mutated")
    source, cause = _mutated((KIT / "examples" / "newmark.py").read_text(encoding="utf-8"), change)
    exec(source, module.__dict__)
    assert _caught(runners.step_runner(module.step), QUICK, cause)


def test_an_acceleration_that_is_moved_to_the_new_step_is_an_alternative():
    module: Any = ModuleType("mutated")
    exec((KIT / "examples" / "newmark.py").read_text(encoding="utf-8").replace(*mutations.MOVED), module.__dict__)
    unequal = [case for case in ALL if "unequal_steps" in case["tags"]]
    outcomes = verdicts(runners.step_runner(module.step), unequal)
    for outcome in outcomes:
        moved = outcome.name.endswith(("HHT", "GEN"))
        assert (
            outcome.verdict == ("differs" if moved else "pass") and ("moved to the new step" in outcome.cause) == moved
        )
    assert counted(outcomes)["differs"] == 4


def test_unequal_steps_have_the_changes_that_their_cases_hold_no_values_of():
    text = (KIT / "examples" / "newmark.py").read_text(encoding="utf-8")
    unequal = [case for case in ALL if case["name"] in ("G-HARM-AVG", "G-CUB-GEN")]
    for old, new, verdict, cause in (
        ("problem.load(t + part * tau)", "problem.load(t + tau / 2)", "fail", "load is that of the middle"),
        ("problem.force(at)", "part * problem.force(x) + alpha_f * problem.force(u)", "differs", "two internal forces"),
    ):
        module: Any = ModuleType("mutated")
        exec(text.replace(old, new), module.__dict__)
        changed = [
            outcome for outcome in verdicts(runners.step_runner(module.step), unequal) if outcome.verdict != "pass"
        ]
        assert changed and all(outcome.verdict == verdict and cause in outcome.cause for outcome in changed), changed


def test_a_wrong_order_and_a_growing_energy_name_their_cause():
    """Cases of the kinds order and bound state no values; the first steps of the scheme show the cause."""
    module: Any = ModuleType("mutated")
    text = (KIT / "examples" / "newmark.py").read_text(encoding="utf-8")
    exec(text.replace('numbers.get("alpha_m", 0.0)', "0.0"), module.__dict__)
    chosen = [case for case in ALL if case["name"] in ("D-ORDER-GEN", "C-BOUND-GEN")]
    energy, order = verdicts(runners.step_runner(module.step), chosen)
    assert re.fullmatch(r"the energy grows to \S+ times .*: α_m is missing in the balance", energy.sentence)
    assert re.fullmatch(r"the order is \S+, not 2", order.finding) and order.cause == "α_m is missing in the balance"
    assert order.where == "u differs from step 1 on, v differs from step 1 on"


needs_c = pytest.mark.skipif(shutil.which("cc") is None, reason="no compiler of C")


def _compiled(source, folder):
    program = folder / "newmark"
    file = folder / "newmark.c"
    file.write_text(source, encoding="utf-8")
    subprocess.run(["cc", "-O1", "-o", program, file, "-lm"], check=True)
    return runners.command_runner(f"{program} {{case}} {{out}}")


@needs_c
def test_the_example_in_c_passes_what_it_does_and_its_mistakes_are_caught(tmp_path):
    """Only this test finds that a right program that writes tables fails, or that a mistake in one is missed."""
    text = (KIT / "examples" / "newmark.c").read_text(encoding="utf-8")
    first = counted(verdicts(_compiled(text, tmp_path)))
    assert first["pass"] >= 60 and set(first) == {"pass", "skip"}
    few = [case for case in QUICK if case["scheme"]["family"] == "newmark"]
    for change in mutations.C:
        source, cause = _mutated(text, change)
        assert _caught(_compiled(source, tmp_path), few, cause), change


@pytest.mark.skipif(shutil.which("node") is None, reason="no Node")
def test_the_reader_in_javascript_judges_a_case(tmp_path):
    """Only this test runs the reader in JavaScript as an author would."""

    def read(file):
        return subprocess.run(["node", KIT / "examples" / "reader.js", file], capture_output=True, text=True)

    good = read(generate.CASES / "D-HARM-AVG.json")
    assert good.returncode == 0 and good.stdout == "D-HARM-AVG: pass\n"
    text = (generate.CASES / "D-HARM-AVG.json").read_text(encoding="utf-8").replace('"beta": "0.25"', '"beta": "0.251"')
    (tmp_path / "case.json").write_text(text, encoding="utf-8")
    bad = read(tmp_path / "case.json")
    assert bad.returncode == 1 and bad.stdout == "D-HARM-AVG: fail, u, v, a differ\n"
    for name in ("A-LIN-CDM", "A-CUB-AVG", "D-BASE-AVG", "D-ORDER-AVG", "F-FRAME-AVG"):
        skipped = read(generate.CASES / f"{name}.json")
        assert skipped.returncode == 77 and skipped.stdout == f"{name}: skip\n"


def test_opensees_has_newmarks_method_and_starts_houbolts_by_average_acceleration():
    pytest.importorskip("openseespy.opensees", exc_type=ImportError)
    runner = runners.function_runner("conformance.codes.opensees:step")
    chosen = [case for case in QUICK if case["name"].endswith(("AVG", "DIS", "HHT", "WIL", "HOU"))]
    outcomes = Counter((outcome.name[-3:], outcome.verdict) for outcome in verdicts(runner, chosen))
    assert {code for code, verdict in outcomes if verdict == "pass"} >= {"AVG", "DIS", "HHT", "WIL"}
    assert {code for code, verdict in outcomes if verdict in ("differs", "fail")} == {"HOU"}


def test_the_third_set_of_opensees_moves_from_rest_as_the_schemes_do_and_not_from_a_motion():
    pytest.importorskip("openseespy.opensees", exc_type=ImportError)
    runner = runners.function_runner("conformance.codes.opensees:more")
    for code in ("CDM", "HHT", "GEN"):
        for place, verdict in (("D-BASE", "pass"), ("A-LIN", "fail")):
            (case,) = [case for case in ALL if case["name"] == f"{place}-{code}"]
            motion = {"u": runner(case, 1)["u"], "v": None, "a": None}
            assert judge(case, lambda part, motion=motion: motion).verdict == verdict


def test_tables_of_a_folder_are_judged(tmp_path, capsys):
    case = next(case for case in ALL if case["name"] == "A-LIN-AVG")
    motion = runners.step_runner(newmark.step)(case, 1)
    rows = np.hstack([0.05 * np.arange(3.0)[:, None], *(np.array(motion[name]) for name in "uv")])
    np.savetxt(tmp_path / "A-LIN-AVG.csv", rows, delimiter=",", header="t,u1,v1", comments="", fmt="%.17g")
    main(["--collect", str(tmp_path)])
    assert capsys.readouterr().out == f"pass 1, differs 0, fail 0, skip {len(ALL) - 1}\n"
    np.savetxt(tmp_path / "A-LIN-DIS.csv", rows[:, :2], delimiter=",", header="t,u1", comments="", fmt="%.17g")
    with pytest.raises(SystemExit) as ended:
        main(["--collect", str(tmp_path), "--only", "A", "newmark"])
    assert ended.value.code == 1
    assert "it is average acceleration" in capsys.readouterr().out


def test_input_files_of_opensees_are_written_for_what_it_has(tmp_path):
    main(["--inputs", str(tmp_path)])
    files = {file.stem for file in tmp_path.glob("*.tcl")}
    assert len(files) > 80 and "A-CUB-HHT" in files and "E-YIELD-AVG" not in files and "A-LIN-RK4" not in files
    text = (tmp_path / "A-CUB-HHT.tcl").read_text(encoding="utf-8")
    assert "integrator HHT 0.9" in text and "setNodeAccel 2 1 -167.0 -commit" in text
