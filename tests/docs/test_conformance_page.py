"""The page of the conformance kit shows the verdicts on codes."""

import re

from conformance.command import cases
from docs.conformance_page import REPORTS, codes_page, found

ALL = list(cases())


def _number(version):
    return [int(part) for part in version.split(".")]


def test_stored_verdicts_are_those_of_these_cases_and_on_the_page():
    page = codes_page()
    codes = found()
    others = {"OpenSees", "xara", "Exudyn", "Kratos", "SfePy", "MFEM", "PETSc", "MuJoCo", "ROSS", "diffrax"}
    assert others | {"SciPy, bilinear transform", "This study"} <= {code["tool"] for code in codes}
    for code in codes:
        # verdicts of an older kit lack the cases that were added later
        names = {case["name"] for case in ALL if _number(case["version"]) <= _number(code["kit"])}
        assert {case["name"] for case in code["cases"]} == names and code["version"]
        assert code["counts"] == {verdict: counted_in(code, verdict) for verdict in code["counts"]}
        assert f"| {code['tool']} {code['version']} | {code['date']} |" in page
        # the cause of every failure is known
        assert not [case for case in code["cases"] if "not known" in case.get("cause", "")], code["tool"]
    assert "| fail | α_m is missing in the balance |" in page


def test_a_code_that_fails_has_a_text_for_its_authors():
    """Each text states numbers, the formula and its source; sets of integrators of one code share a text."""
    failing = {code["file"].partition("_")[0] for code in found() if code["counts"]["fail"]}
    assert {file.stem for file in REPORTS.glob("*.md")} == failing
    for file in REPORTS.glob("*.md"):
        text = file.read_text(encoding="utf-8")
        assert re.match(r"# .+\n", text) and "```" in text and "Source:" in text and "| expected |" in text, file


def counted_in(code, verdict):
    return sum(case["verdict"] == verdict for case in code["cases"])
