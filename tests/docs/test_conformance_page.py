"""The page of the conformance kit shows the verdicts on codes."""

import re

from conformance.command import cases
from docs.conformance_page import REPORTS, all_codes, codes_page

ALL = list(cases())


def _number(version):
    return [int(part) for part in version.split(".")]


def test_stored_verdicts_are_those_of_these_cases_and_on_the_page():
    page = codes_page()
    codes = all_codes()
    others = {"OpenSees", "xara", "Exudyn", "Kratos", "Kratos, explicit", "SfePy", "MFEM", "PETSc", "MuJoCo", "ROSS"}
    others |= {"Akantu", "fedoo", "diffrax", "SciPy, bilinear transform"}
    assert others | {"This study"} <= {code["tool"] for code in codes}
    for code in codes:
        # verdicts of an older kit lack the cases that were added later
        names = {case["name"] for case in ALL if _number(case["version"]) <= _number(code["kit"])}
        assert {case["name"] for case in code["cases"]} == names and code["version"]
        assert code["counts"] == {verdict: counted_in(code, verdict) for verdict in code["counts"]}
        assert f"| {code['tool']} {code['version']} | {code['date']} |" in page
        assert f"- {code['tool']} {code['version']}: {code['note']}" in page
        assert code["tool"] not in others or re.search(r"`(pip|apt) install \S+", code["note"]), code["tool"]
        # the cause of every failure is known
        assert not [case for case in code["cases"] if "not known" in case.get("cause", "")], code["tool"]
    assert "| fail | α_m is missing in the balance |" in page


def test_a_code_that_fails_has_a_text_for_its_authors():
    """Each text has an input, numbers, a formula and its source; sets of integrators of one code share a text."""
    page = codes_page()
    failing = {code["file"].partition("_")[0] for code in all_codes() if code["counts"]["fail"]}
    assert {file.stem for file in REPORTS.glob("*.md")} == failing
    for file in REPORTS.glob("*.md"):
        text = file.read_text(encoding="utf-8")
        assert re.match(r"# .+\n", text) and "Source:" in text and "| expected |" in text, file
        (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
        # the input is whole: it imports what it names, and prints a number
        assert code.startswith("import ") and "print(" in code and compile(code, file.name, "exec"), file
        assert page.count(f"/included/reports/{file.name}\n") == 1, file


def counted_in(code, verdict):
    return sum(case["verdict"] == verdict for case in code["cases"])
