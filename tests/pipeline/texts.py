"""The ledger and the LaTeX sources of a finished study."""

import csv
import json
import re
import subprocess
import sys
from pathlib import Path

import study
from paper.claims.ledger import Verdict

PDFLATEX = ["pdflatex", "-interaction=nonstopmode"]


def check_latex(project: Path, folder: Path) -> None:
    """Write and compile the sources: they have the figures, tables and citations of the texts, and all references."""
    subprocess.run([sys.executable, "-m", "paper.latex", project / "results", folder], cwd=project, check=True)
    for name in ("manuscript", "supplement"):
        # until references and the widths of tables are settled
        for command in ([*PDFLATEX, name], ["bibtex", name], *3 * [[*PDFLATEX, name]]):
            subprocess.run(command, cwd=folder, capture_output=True, check=False)
        log = (folder / f"{name}.log").read_text(errors="replace")
        assert "\n! " not in log and "undefined" not in log, log[-3000:]
        text = (project / "paper" / "text" / f"{name}.typ").read_text()
        source = (folder / f"{name}.tex").read_text()
        assert source.count("\\includegraphics") == text.count("#picture(")
        assert source.count("\\caption") == text.count("#picture(") + text.count("#tabular(")
        cited = ",".join(re.findall(r"\\citep{([^}]*)}", source)).replace(" ", "")
        # a sentence that the data do not bear is left out with its citations
        assert set(cited.split(",")) <= set(re.findall(r"@([a-z]+\d{4}[a-z]*)", text))


def check_ledger(results: Path) -> None:
    """Every claim is decided, in words that can be printed."""
    claims = list(csv.DictReader((results / "claims.csv").read_text().splitlines()))
    assert len(claims) >= 35
    assert {c["verdict"] for c in claims} <= {*Verdict}
    for claim in claims:
        assert claim["verdict"] == "reproduced" or claim["reason"], claim["claim"]
        printed = f"{claim['ours']} {claim['reason']}"
        assert not re.search(r"\bnan\b|\binf\b|\d[eE][-+−]?\d|\w_\w", printed), printed
        assert not set(re.findall(r"\w+", printed)) & set(study.schemes), printed
    numbers = json.loads((results / "numbers.json").read_text())
    assert numbers["cells_rounded_twice"] == "97"
