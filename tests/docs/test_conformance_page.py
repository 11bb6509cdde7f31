"""The page of the conformance kit shows the verdicts on codes."""

from conformance.command import cases
from docs.conformance_page import conformance_page, found

ALL = list(cases())


def _number(version):
    return [int(part) for part in version.split(".")]


def test_stored_verdicts_are_those_of_these_cases_and_on_the_page():
    page = conformance_page()
    codes = found()
    assert {"OpenSees", "Exudyn", "SciPy, bilinear transform", "This study", "diffrax"} <= {
        code["tool"] for code in codes
    }
    for code in codes:
        # verdicts of an older kit lack the cases that were added later
        names = {case["name"] for case in ALL if _number(case["version"]) <= _number(code["kit"])}
        assert {case["name"] for case in code["cases"]} == names and code["version"]
        assert code["counts"] == {verdict: counted_in(code, verdict) for verdict in code["counts"]}
        assert f"| {code['tool']} {code['version']}" in page
    assert "| fail | α_m is missing in the balance |" in page


def counted_in(code, verdict):
    return sum(case["verdict"] == verdict for case in code["cases"])
