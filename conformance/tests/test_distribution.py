"""The kit as authors of codes install it: a wheel that needs NumPy only, and an action for their CI."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
import xml.etree.ElementTree as ET
import zipfile
from importlib.metadata import distribution
from pathlib import Path

import pytest
import yaml

from conformance import VERSION

KIT = Path(__file__).parents[1]
MY_CODE = """import math
def step(problem, scheme, dt, steps):
    if scheme["family"] != "central_difference" or problem.text["form"] != "linear" or len(problem.u0) > 1:
        raise NotImplementedError("it has central difference alone")
    m, c, k = (x[0][0] for x in (problem.mass, problem.damping, problem.tangent(problem.u0)))
    sizes = [dt] * steps if not hasattr(dt, "__len__") else dt
    t, u, v = 0.0, problem.u0[0], problem.v0[0]
    a = (problem.load(t)[0] - c * v - k * u) / m
    rows = [(u, v, a)]
    for dt in sizes:
        t, u, v = t + dt, u + dt * v + dt * dt / 2 * a, v + dt / 2 * a
        a = (problem.load(t)[0] - c * v - k * u) / (m + dt / 2 * c)
        v += FACTOR * dt / 2 * a
        rows.append((u, v, a))
    return [[[x] for x in column] for column in zip(*rows)]
"""


def _environment(folder: Path, *packages: str) -> Path:
    """A fresh environment with links to installed packages, and nothing else; its Python is returned."""
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    target = Path(sysconfig.get_path("purelib", "venv", {"base": str(folder), "platbase": str(folder)}))
    for package in packages:
        for name in {file.parts[0] for file in distribution(package).files or []} - {"..", "__pycache__"}:
            (target / name).symlink_to(Path(str(distribution(package).locate_file(name))))
    return python


def _variables(python: Path, **more: object) -> dict[str, str]:
    """Variables of this process, with a fresh environment first on the path and without the path of this project."""
    rest = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return {**rest, "PATH": f"{python.parent}{os.pathsep}{rest['PATH']}", **{name: str(x) for name, x in more.items()}}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel that ``make conformance`` builds with the installed build tools."""
    target = tmp_path_factory.mktemp("wheel")
    command = ["make", "--old-file=.venv/ready", "conformance", f"CONFORMANCE={target}"]
    subprocess.run([*command, f"BIN={Path(sys.executable).parent}"], cwd=KIT.parent, check=True, capture_output=True)
    (built,) = target.glob("*.whl")
    return built


def test_the_wheel_has_the_version_of_the_cases_and_holds_the_kit_alone(wheel):
    assert wheel.name == f"time_integration_conformance-{VERSION}-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as opened:
        names = set(opened.namelist())
        (metadata,) = (opened.read(name).decode() for name in names if name.endswith(".dist-info/METADATA"))
    assert re.findall(r"^Requires-Dist: (?!.*extra)(.*)$", metadata, re.MULTILINE) == ["numpy>=1.26"]
    held = {name for name in names if ".dist-info/" not in name}
    sources = [KIT.glob("*.py"), *(KIT.joinpath(folder).glob("*") for folder in ("cases", "codes", "examples"))]
    expected = {file.relative_to(KIT.parent).as_posix() for group in sources for file in group if file.is_file()}
    assert held == expected | {"conformance/schema.json"}


def test_the_installed_command_judges_a_code(wheel, tmp_path):
    """The fresh environment has NumPy, but neither this project nor JAX nor mpmath.

    Only this test finds that the installed kit lacks a file or a package.
    """
    python = _environment(tmp_path / "fresh", "numpy")
    install = [sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps", "--no-index", wheel]
    subprocess.run(install, check=True)
    (tmp_path / "my_code.py").write_text(MY_CODE.replace("FACTOR", "1"), encoding="utf-8")
    words = ["my_code:step", "--only", "central_difference", "linear", "--tool", "Mine", "--output", "out"]
    command = [python.parent / "conform", *words]
    done = subprocess.run(command, cwd=tmp_path, env=_variables(python), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    # the frame and the full mass matrix have several unknowns
    assert done.stdout.startswith("pass 11, differs 0, fail 0, skip 2")
    assert "A-LIN-CDM" in (tmp_path / "out.html").read_text(encoding="utf-8")
    listed = [python, "-c", "import conformance; print(conformance.__file__)"]
    place = subprocess.run(listed, cwd=tmp_path, env=_variables(python), capture_output=True, text=True).stdout
    assert Path(place.strip()).is_relative_to(tmp_path / "fresh")


@pytest.fixture(scope="module")
def action(tmp_path_factory):
    """Function that runs a step of the action, with the kit's folder copied as on GitHub, in a fresh environment."""
    folder, stated = tmp_path_factory.mktemp("action"), yaml.safe_load((KIT / "action.yml").read_text(encoding="utf-8"))
    assert stated["runs"]["using"] == "composite"
    python = _environment(folder / "fresh", "numpy", "pip", "setuptools")
    shutil.copytree(KIT, folder / "kit", ignore=shutil.ignore_patterns("__pycache__", "verdicts"))
    # the installation fetches nothing
    rest = {"PIP_NO_INDEX": 1, "PIP_NO_BUILD_ISOLATION": 0, "PIP_NO_DEPS": 1, "GITHUB_ACTION_PATH": folder / "kit"}
    inputs = {name: definition.get("default") for name, definition in stated["inputs"].items()}

    def run(number, place, **options):
        step, values = stated["runs"]["steps"][number], inputs | options
        written = {name: place / name for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY")}
        taken = {
            name: values[x.removeprefix("${{ inputs.").removesuffix(" }}")] for name, x in step.get("env", {}).items()
        }
        command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
        variables = _variables(python, **rest, **written, **taken)
        return subprocess.run(command, cwd=place, env=variables, capture_output=True, text=True)

    done = run(0, folder)
    assert done.returncode == 0, done.stderr
    return run


@pytest.mark.parametrize(("factor", "passed", "colour"), [("1", "1 of 34", "#282"), ("1.001", "0 of 34", "#c33")])
def test_the_action_judges_a_code_and_makes_a_badge(action, factor, passed, colour, tmp_path):
    """Only this test runs the steps of the action."""
    (tmp_path / "my_code.py").write_text(MY_CODE.replace("FACTOR", factor), encoding="utf-8")
    done = action(1, tmp_path, arguments='"my_code:step" --only A', tool="My 'own' code")
    assert (done.returncode == 0) == (passed[0] == "1"), done.stderr
    outputs = dict(line.split("=", 1) for line in (tmp_path / "GITHUB_OUTPUT").read_text().splitlines())
    assert outputs["passed"] == passed
    badge = ET.parse(tmp_path / outputs["badge"]).getroot()
    assert badge.findtext("{*}title") == f"conformance: {passed}"
    assert colour in (tmp_path / outputs["badge"]).read_text(encoding="utf-8")
    assert f"My 'own' code: {passed} cases passed" in (tmp_path / "GITHUB_STEP_SUMMARY").read_text()
