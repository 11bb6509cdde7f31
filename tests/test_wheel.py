"""The package as `pip install` makes it: its wheel, with the dependencies of the core and without the checkout."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from importlib.metadata import Distribution, distribution
from pathlib import Path

import pytest
import xarray as xr
import yaml
from packaging.requirements import Requirement

import study
from tests import small_results

PROJECT = Path(__file__).parent.parent
METADATA = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
EXTRAS = METADATA["optional-dependencies"]


def _needed(*requirements: str) -> dict[str, Distribution]:
    """The installed distributions of some requirements and of all their dependencies, by name."""
    distributions: dict[str, Distribution] = {}
    waiting = [Requirement(text) for text in requirements]
    while waiting:
        package = waiting.pop()
        if package.name not in distributions and (package.marker is None or package.marker.evaluate({"extra": ""})):
            distributions[package.name] = distribution(package.name)
            waiting += map(Requirement, distributions[package.name].requires or [])
    return distributions


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel, built from a copy, because building leaves files next to the sources."""
    source, target = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        shutil.copy(PROJECT / name, source)
    for name in ("study", "reference", "conformance", "paper"):
        shutil.copytree(PROJECT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", target, source]
    subprocess.run([*command, "--quiet"], check=True)
    (built,) = target.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def python(wheel, tmp_path_factory) -> Path:
    """The Python of a fresh environment with the wheel and the dependencies that it declares, and nothing else."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    command = [sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", "--quiet", wheel]
    subprocess.run(command, check=True)
    packages = Path(sysconfig.get_path("purelib", "venv", {"base": str(folder), "platbase": str(folder)}))
    for package in _needed(*METADATA["dependencies"]).values():
        for name in {file.parts[0] for file in package.files or []} - {"..", "__pycache__"}:
            if not (packages / name).exists():
                (packages / name).symlink_to(Path(str(package.locate_file(name))))
    return python


def _run(command: list, folder: Path) -> str:
    """Output of a command in a folder outside the checkout, with no path to the checkout."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout


def test_the_wheel_holds_study_and_reference_and_neither_the_paper_nor_the_conformance_kit(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    packages = {"study", "reference"}
    assert {name.partition("/")[0] for name in names if ".dist-info/" not in name} == packages
    data = {"study/py.typed", "study/assessment/references.bib"}
    assert data <= set(names)
    for package in packages:
        sources = {path.relative_to(PROJECT).as_posix() for path in (PROJECT / package).rglob("*.py")}
        assert sources == {name for name in names if name.startswith(f"{package}/") and name.endswith(".py")}


def test_the_long_description_has_no_link_to_a_file(wheel):
    """A package index has no files next to the text."""
    archive = zipfile.ZipFile(wheel)
    (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
    text = archive.read(name).decode()
    links = re.findall(r"\]\(([^)]*)\)", text)
    assert links and all(link.startswith("https://") for link in links)
    assert "\nDescription-Content-Type: text/markdown\n" in text and "\nimport study\n" in text


@pytest.mark.slow
def test_the_core_runs_a_scheme_away_from_the_checkout(python, tmp_path):
    """A file of the package that the wheel lacks."""
    run = "study.run('softening', 'rk4', dt=0.05, steps=100, observe=['max_energy_error']).max_energy_error.item()"
    file, error = _run([python, "-c", f"import study; print(study.__file__, {run})"], tmp_path).split()
    assert Path(file).is_relative_to(python.parent.parent)
    assert float(error) == eval(run, {"study": study})


def test_the_tests_of_the_conda_recipe_pass_with_the_wheel(python, tmp_path):
    """Imports, `pip check` and commands of the recipe, where conda is not needed; `make wheel` renders the recipe."""
    tests = yaml.safe_load((PROJECT / "recipe" / "recipe.yaml").read_text())["tests"]
    assert {kind for test in tests for kind in test} == {"python", "script"}
    for test in tests:
        modules = test.get("python", {}).get("imports", [])
        _run([python, "-c", "".join(f"import {module}\n" for module in modules)], tmp_path)
        if test.get("python", {}).get("pip_check"):
            _run([sys.executable, "-m", "pip", "--python", python, "check"], tmp_path)
        for command in test.get("script", []):
            _run(["sh", "-c", f"PATH='{python.parent}':$PATH; {command}"], tmp_path)


@pytest.mark.slow
def test_the_core_recommends_a_scheme_from_a_folder_of_results(python, tmp_path):
    results = small_results.write_to(tmp_path / "elsewhere")
    code = (
        "import study; print(study.recommend('softening', allowed_error=0.01, quantity='displacement', "
        f"folder={str(results)!r}).index[0])"
    )
    assert _run([python, "-c", code], tmp_path).strip() == "cheap"


def test_the_core_writes_a_run_to_a_file(python, tmp_path):
    """The provenance of the run names only packages that are installed with the core."""
    options = ["--dt", "0.05", "--steps", "9", "--output", "run.nc"]
    _run([python, "-m", "study", "run", "softening", "rk4", *options], tmp_path)
    written = xr.load_dataset(tmp_path / "run.nc")
    assert written.sizes["t"] == 10
    assert "xarray" in written.packages and "diffrax" not in written.packages


def test_the_version_is_stated_once_and_cited(wheel):
    assert wheel.name.startswith(f"time_integration_study-{METADATA['version']}-")
    assert yaml.safe_load((PROJECT / "CITATION.cff").read_text())["version"] == METADATA["version"]
    newest = re.search(r"^## (?:\[?)(\d+\.\d+\.\d+)", (PROJECT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert newest is not None and newest[1] == METADATA["version"]


def test_the_environment_for_conda_holds_the_dependencies_of_the_pipeline():
    environment = yaml.safe_load((PROJECT / "config" / "environment.yaml").read_text())
    listed = environment["dependencies"][-1]["pip"]
    wanted = {*METADATA["dependencies"], *EXTRAS["reference"], *EXTRAS["paper"], *EXTRAS["site"], *EXTRAS["pipeline"]}
    assert sorted(listed, key=str.lower) == listed
    assert set(listed) == wanted - {"time-integration-study[reference,paper,site]"}


def test_pinned_packages_name_no_registry_and_satisfy_the_declared_bounds():
    text = (PROJECT / "requirements.txt").read_text()
    assert "://" not in text and "index-url " not in text.replace("--no-emit-index-url ", "")
    pinned: dict[str, list[str]] = {}
    for name, version in re.findall(r"^([\w.-]+)==([^\s;\\]+)", text, re.MULTILINE):
        pinned.setdefault(name, []).append(version)
    declared = [*METADATA["dependencies"], *(line for extra in EXTRAS if extra != "opensees" for line in EXTRAS[extra])]
    for requirement in map(Requirement, declared):
        if requirement.name != METADATA["name"]:
            versions = pinned[requirement.name.lower()]
            assert all(version in requirement.specifier for version in versions), (requirement, versions)


#: Program that runs the cells of a notebook as one would, except the one that installs the package, and what they show.
_CELLS = """
import json, sys, types
from pathlib import Path

display = types.ModuleType("IPython.display")
display.HTML = lambda text: print("page of", len(text))
sys.modules |= {"IPython": types.ModuleType("IPython"), "IPython.display": display}
sys.modules["IPython"].version_info = (9, 0)  # matplotlib asks for it
seen = {}
for cell in json.loads(Path(sys.argv[1]).read_text())["cells"]:
    if cell["cell_type"] == "code":
        exec("".join(cell["source"]).replace("%pip", "# %pip"), seen)
print(seen["package"], seen["study"].__file__)
"""


@pytest.mark.pipeline
def test_the_notebook_runs_with_the_wheel(wheel, tmp_path):
    """The package is that of the wheel; the extras are those of this environment."""
    zipfile.ZipFile(wheel).extractall(tmp_path / "package")
    folder = tmp_path / "notebook"
    folder.mkdir()
    shutil.copy(wheel, folder)
    command = [sys.executable, "-c", _CELLS, PROJECT / "examples" / "which_step.ipynb"]
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "package"), "MPLBACKEND": "agg"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]
    # which of the two is faster is measured, and may change on a busy machine
    assert re.search(r"central_difference +explicit +0\.14 ", done.stdout) and "page of" in done.stdout
    assert f"{wheel.name}[reference,paper] {tmp_path / 'package'}" in done.stdout
