"""Input files for Abaqus and code_aster state a case; a case that they cannot state has no input file."""

import builtins
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from conformance import chains, runners
from conformance.command import cases
from conformance.judge import judge
from conformance.problem import Problem

BY_NAME = {case["name"]: case for case in cases()}


def _written(write, case) -> str:
    text = write(case)
    assert text is not None
    return text


def _assembled(n, links):
    """Assembled matrix of springs or dashpots (node, node, value); node 0 is fixed."""
    matrix = np.zeros((n + 1, n + 1))
    for i, j, value in links:
        matrix[np.ix_([i, j], [i, j])] += value * np.array([[1, -1], [-1, 1]])
    return matrix[1:, 1:]


def _elements(lines, kind, values_after):
    """Yield the nodes, numbered from 0, and the value of each element of a type in an Abaqus file."""
    for index in (i for i, line in enumerate(lines) if line.startswith(f"*ELEMENT, TYPE={kind},")):
        yield *(int(word) - 1 for word in lines[index + 1].split(",")[1:]), float(lines[index + values_after])


def _force(lines, i, t):
    """Force on unknown i at time t, from its amplitude in an Abaqus file."""
    index = next(place for place, line in enumerate(lines) if line.startswith(f"*AMPLITUDE, NAME=FORCE{i + 1}"))
    if "PERIODIC" in lines[index]:
        (_, w, _, constant), (cosine, sine) = (map(float, lines[index + k].split(",")) for k in (1, 2))
        return constant + cosine * np.cos(w * t) + sine * np.sin(w * t)
    samples = [[float(word) for word in line.split(",")] for line in lines[index + 1 : index + 18]]
    return np.interp(t, *np.array(samples).T)


@pytest.mark.parametrize("name", ["A-LIN-HHT", "F-FRAME-AVG"])
def test_a_file_of_abaqus_states_the_case(name):
    case, problem = BY_NAME[name], Problem(BY_NAME[name]["problem"])
    lines = [line for line in _written(chains.abaqus, case).splitlines() if not line.startswith("**")]
    n, stiffness = len(problem.u0), problem.tangent(problem.u0)
    np.testing.assert_allclose(np.diag([value for _, value in _elements(lines, "MASS", 3)]), problem.mass)
    np.testing.assert_allclose(_assembled(n, _elements(lines, "SPRING2", 4)), stiffness)
    np.testing.assert_allclose(_assembled(n, _elements(lines, "DASHPOT2", 4)), problem.damping)
    for t in (0.0, 0.07):
        forces = [_force(lines, i, t) for i in range(n)]
        np.testing.assert_allclose(forces, problem.load(t) - stiffness @ problem.u0)
    index = lines.index("*INITIAL CONDITIONS, TYPE=VELOCITY")
    assert [float(line.split(",")[2]) for line in lines[index + 1 : index + 1 + n]] == problem.v0.tolist()
    alpha, beta = case["scheme"].get("alpha", "0"), case["scheme"]["beta"]
    index = lines.index(
        f"*DYNAMIC, TIME INTEGRATOR=HHT-TF, ALPHA={alpha}, BETA={beta}, GAMMA={case['scheme']['gamma']}, DIRECT"
    )
    dt, end = map(float, lines[index + 1].split(","))
    assert dt == float(case["run"]["dt"]) and end == pytest.approx(dt * case["run"]["steps"])


class Commands(dict):
    """Namespace for a program of code_aster; its entry ``called`` stores the arguments of the program's commands."""

    def __missing__(self, name):
        if hasattr(builtins, name):
            raise KeyError(name)
        return lambda **words: self.setdefault("called", {}).setdefault(name, SimpleNamespace(**words))

    def __getitem__(self, name):
        return (lambda **words: SimpleNamespace(**words)) if name == "_F" else super().__getitem__(name)


@pytest.mark.parametrize(
    "name, scheme",
    [
        ("A-LIN-HHT", {"SCHEMA": "HHT", "ALPHA": -0.1, "MODI_EQUI": "OUI"}),
        ("F-FRAME-CDM", {"SCHEMA": "DIFF_CENT", "FORMULATION": "ACCELERATION"}),
        ("A-LIN-TCH", {"SCHEMA": "TCHAMWA", "PHI": 1.033}),
    ],
)
def test_commands_of_code_aster_state_the_case(name, scheme):
    case, problem, names = BY_NAME[name], Problem(BY_NAME[name]["problem"]), Commands()
    exec(_written(chains.code_aster, case).partition("u1 = ")[0], names)  # the rest of the program reads the motion
    calls: dict[str, Any] = names["called"]
    parts, n = calls["AFFE_CARA_ELEM"].DISCRET, len(problem.u0)
    np.testing.assert_allclose(np.diag([part.VALE for part in parts if part.CARA == "M_T_D_N"]), problem.mass)
    for kind, matrix in (("K_T_D_L", problem.tangent(problem.u0)), ("A_T_D_L", problem.damping)):
        links = [(*map(int, part.GROUP_MA[1:]), part.VALE[0]) for part in parts if kind == part.CARA]
        np.testing.assert_allclose(_assembled(n, links), matrix)
    mesh = _written(chains.mesh, case).splitlines()
    assert all(" ".join([part.GROUP_MA, *(f"N{digit}" for digit in part.GROUP_MA[1:])]) in mesh for part in parts)
    assert [part.VALE for part in calls["CREA_CHAMP"].AFFE[1:]] == problem.u0.tolist()
    motion = calls["DYNA_NON_LINE"]
    # no relative tolerance, because it refers to the external force, which is zero in a free motion
    assert vars(motion.CONVERGENCE).keys() == {"RESI_GLOB_MAXI", "ITER_GLOB_MAXI"}
    assert 0 < motion.CONVERGENCE.RESI_GLOB_MAXI < 1e-6
    assert scheme.items() <= vars(motion.SCHEMA_TEMPS).items()
    interval = motion.INCREMENT.LIST_INST.INTERVALLE
    assert interval.NOMBRE == case["run"]["steps"]
    assert interval.JUSQU_A == pytest.approx(interval.NOMBRE * float(case["run"]["dt"]))


def test_the_table_of_code_aster_is_the_motion_that_it_reads(tmp_path, monkeypatch):
    case, names = BY_NAME["F-FRAME-AVG"], Commands()
    motion = runners.function_runner("conformance.examples.newmark:step")(case, 1)
    times = float(case["run"]["dt"]) * np.arange(case["run"]["steps"] + 1)
    columns = {"DEPL": "u", "VITE": "v", "ACCE": "a"}

    def function(NOM_CHAM, GROUP_NO, **words):
        values = motion[columns[NOM_CHAM]]
        assert values is not None
        return SimpleNamespace(Valeurs=lambda: [times.tolist(), values[:, int(GROUP_NO[1:]) - 1].tolist()])

    monkeypatch.chdir(tmp_path)
    names["RECU_FONCTION"] = function
    exec(_written(chains.code_aster, case), names)
    assert judge(case, partial(runners.folder_runner(tmp_path), case)).verdict == "pass"


def test_what_cannot_be_stated_has_no_file():
    """A nonlinear spring, coupled masses, and a scheme that the codes lack have no input files."""
    for name in ("A-CUB-AVG", "F-MASS-AVG", "A-LIN-BAT"):
        assert not any(write(BY_NAME[name]) for write in (chains.abaqus, chains.code_aster, chains.mesh))
    # the HHT method of code_aster derives β from α, and accepts no other β
    case = BY_NAME["A-LIN-HHT"]
    other = case | {"scheme": case["scheme"] | {"beta": "0.3"}}
    assert chains.code_aster(other) is None and "BETA=0.3" in _written(chains.abaqus, other)
