"""The pages of the conformance kit: how to run it, and its verdicts on codes."""

import json
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs.text import described, table

RESULTS = Path(__file__).parent.parent / "conformance" / "verdicts"

#: Texts ready to send to the authors of codes, by the names of the files of verdicts.
REPORTS = RESULTS.parent / "reports"

#: Integrators and codes without a verdict, and the reason.
NOT_JUDGED = """## Not judged

- OpenSees: `openseespy` 3.8.0.0 answers that the integrator `ExplicitBathe` is unknown.
- PETSc later than 3.18: `petsc4py` has no wheel on PyPI, and its source needs a build of PETSc. The verdict is on the
  package of Debian 12.
- ROSS 3: it needs Python 3.12, and its function `newmark` has other arguments.
- Kratos: `ExplicitMultiStageKimScheme` is no scheme of the kit.
- MuJoCo: its integrators `implicit` and `implicitfast` are no schemes of the kit.
- Abaqus and code_aster have no package. `conform --inputs` writes their input files, which have not been run.
- ANSYS, LS-DYNA, SAP2000, ETABS and MOOSE have no package, and the kit writes no input files for them.
"""

#: Verdicts with a column for their number of cases. The remaining verdict is ``skip``.
_SHOWN = ("pass", "differs", "fail")

#: Maximum number of cases that a row names as examples.
SHOWN = 4


def all_codes() -> list[dict[str, Any]]:
    """Verdicts of all codes; the code with the most passes is first."""
    results = [json.loads(file.read_text(encoding="utf-8")) | {"file": file.stem} for file in RESULTS.glob("*.json")]
    return sorted(results, key=lambda code: (-code["counts"]["pass"], code["tool"]))


def _named(code: Mapping[str, Any]) -> str:
    return f"{code['tool']} {code['version']}".strip()


def _overview(codes: Sequence[Mapping[str, Any]]) -> str:
    """A table with a row for every code: by level, the number of passed cases over the number of supported cases."""
    rows = []
    for code in codes:
        ran, passed = Counter[str](), Counter[str]()
        for case in code["cases"]:
            ran[case["name"][0]] += case["verdict"] != "skip"
            passed[case["name"][0]] += case["verdict"] == "pass"
        levels = [f"{passed[level]}/{ran[level]}" if ran[level] else "–" for level in "ABCDEFG"]
        counts = [str(code["counts"][verdict]) for verdict in _SHOWN]
        rows.append([_named(code), code["date"], *levels, *counts])
    return table(["code", "date", *"ABCDEFG", *_SHOWN], rows)


def _name(code: Mapping[str, Any]) -> str:
    """Name of the program of a code; sets of integrators of one program share it, and its report."""
    return code["file"].partition("_")[0]


def _causes(code: Mapping[str, Any], reported: bool) -> str:
    """Table of alternatives, then of likely causes, the most frequent first, and, if ``reported``, the report.

    Empty if no case differs or fails.
    """
    cases = defaultdict(list)
    for case in code["cases"]:
        if case["verdict"] in ("differs", "fail"):
            cases[case["verdict"], case.get("cause") or case["finding"]].append(case["name"])
    rows = [
        [verdict, cause, str(len(names)), ", ".join(names[:SHOWN]) + (" ..." if len(names) > SHOWN else "")]
        for (verdict, cause), names in sorted(cases.items(), key=lambda item: (item[0][0], -len(item[1])))
    ]
    if not rows:
        return ""
    head = ["verdict", "alternative or likely cause", "cases", "examples"]
    text = [f"```{{include}} /included/reports/{_name(code)}.md\n:heading-offset: 2\n```"] if reported else []
    return "\n\n".join([f"## {_named(code)}", table(head, rows, 4), *text])


def conformance_page() -> str:
    """The page in Markdown on how to run the kit."""
    sentence = "A kit of cases that checks whether the time integrator of a code implements the scheme of its name."
    return described(sentence, "```{include} /included/conformance.md\n```\n")


def codes_page() -> str:
    """The page in Markdown of the verdicts on codes."""
    codes = all_codes()
    # the first set of each program that fails a case shows the report
    first = {_name(code): code["file"] for code in reversed(codes) if code["counts"]["fail"]}
    parts = [
        "# Codes judged by the conformance kit",
        "Each cell gives the passed cases over the supported cases of a level of the {doc}`conformance kit "
        "<conformance>`. Unsupported cases are skipped. The name of a code ends with its version. A cause is a change "
        "of the scheme that gives the values of the code. The runners in `conformance/codes/` repeat all "
        "verdicts. Those whose note names another Python or a system package cannot be repeated in the environment of "
        "the study.",
        _overview(codes),
        "\n".join(f"- {_named(code)}: {code['note']}" for code in codes),
        *filter(None, (_causes(code, first.get(_name(code)) == code["file"]) for code in codes)),
        NOT_JUDGED,
    ]
    sentence = "Which time integrators of OpenSees, SfePy, MFEM, PETSc and other codes do what their names say."
    return described(sentence, "\n\n".join(parts) + "\n")
