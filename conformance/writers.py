"""Input files of the cases for codes that read no JSON: OpenSees here, other codes in ``chains``.

The files for OpenSees define linear and cubic oscillators without ground motion. Each file writes its motion to
``NAME.csv`` in the folder in which OpenSees runs. A case without an input file gets no table and is skipped.
"""

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from conformance.chains import abaqus, code_aster, mesh


def _scalars(case: Mapping[str, Any]) -> dict[str, float] | None:
    """Numbers of a linear or cubic oscillator with one unknown and no ground motion; None for any other problem."""
    problem = case["problem"]
    if len(problem["u0"]) > 1 or problem["form"] not in ("linear", "cubic") or "ground" in problem:
        return None
    parameters = problem["parameters"]
    k = float(parameters["stiffness"][0][0]) if problem["form"] == "linear" else float(parameters["S1"])
    numbers = {"k": k, "k3": k * float(parameters.get("S2", 0)), "dt": float(case["run"]["dt"])}
    numbers |= {name: float(problem[key][0][0]) for name, key in (("m", "mass"), ("c", "damping"))}
    numbers |= {name: float(problem[name][0]) for name in ("u0", "v0")}
    load = problem.get("load", {"amplitude": ["0"], "frequency": "1", "phase": "0"})
    numbers |= {"amplitude": float(load["amplitude"][0]), "w": float(load["frequency"]), "phase": float(load["phase"])}
    start = numbers["amplitude"] * math.cos(numbers["phase"]) - numbers["c"] * numbers["v0"]
    u0 = numbers["u0"]
    return numbers | {"a0": (start - k * u0 - numbers["k3"] * u0**3) / numbers["m"]}


def _integrator(scheme: Mapping[str, str]) -> str | None:
    """Integrator command of OpenSees for a scheme; None for an unsupported scheme."""
    family = scheme["family"]
    numbers = {name: value for name, value in scheme.items() if name not in ("family", "start")}
    if family == "newmark":
        return f"Newmark {numbers['gamma']} {numbers['beta']}"
    if family == "hht":
        return f"HHT {1 + float(numbers['alpha']):.17g} {numbers['gamma']} {numbers['beta']}"
    known = {"central_difference": "NewmarkExplicit 0.5", "houbolt": "Houbolt"}
    return f"WilsonTheta {numbers['theta']}" if family == "wilson" else known.get(family)


def opensees(case: Mapping[str, Any]) -> str | None:
    """Tcl commands of a case for OpenSees; None for an unsupported problem or scheme."""
    data, integrator = _scalars(case), _integrator(case["scheme"])
    if data is None or integrator is None:
        return None
    return f"""# {case["name"]}: {case["title"]}
model basic -ndm 1 -ndf 1
node 1 0; node 2 0; fix 1 1; mass 2 {data["m"]!r}
uniaxialMaterial ElasticPowerFunc 1 -coeff {data["k"]!r} {data["k3"]!r} -exp 1.0 3.0
uniaxialMaterial Elastic 2 0.0 {data["c"]!r}
element zeroLength 1 1 2 -mat 1 -dir 1
element zeroLength 2 1 2 -mat 2 -dir 1
timeSeries Trig 1 0.0 1e9 {2 * math.pi / data["w"]!r} -shift {math.pi / 2 - data["phase"]!r}
pattern Plain 1 1 {{ load 2 {data["amplitude"]!r} }}
constraints Plain; numberer Plain; system FullGeneral; test NormDispIncr 1e-12 50
algorithm {"Linear" if "Explicit" in integrator else "Newton"}
integrator {integrator}
analysis Transient
setNodeDisp 2 1 {data["u0"]!r} -commit; setNodeVel 2 1 {data["v0"]!r} -commit; setNodeAccel 2 1 {data["a0"]!r} -commit
set out [open {case["name"]}.csv w]
puts $out "t,u1,v1,a1"
for {{set i 0}} {{$i <= {case["run"]["steps"]}}} {{incr i}} {{
  if {{$i > 0}} {{analyze 1 {data["dt"]!r}}}
  puts $out "[expr $i * {data["dt"]!r}],[nodeDisp 2 1],[nodeVel 2 1],[nodeAccel 2 1]"
}}
close $out
"""


#: Functions that make the texts of files, by suffix: input of OpenSees and of Abaqus, commands and mesh of code_aster.
WRITERS = {".tcl": opensees, ".inp": abaqus, ".comm": code_aster, ".mail": mesh}


def write(chosen: Iterable[Mapping[str, Any]], folder: Path) -> int:
    """Write all input files of the cases, and return the number of files. Cases with unequal steps have no files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = [
        (case["name"] + ending, writer(case))
        for case in chosen
        if "dt" in case["run"]
        for ending, writer in WRITERS.items()
    ]
    texts = {name: text for name, text in files if text is not None}
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return len(texts)
