"""``import study``: its names, its help, its version, and its effects on the process."""

import inspect
import os
import pydoc
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import ClassVar

import jax.numpy as jnp
import numpy as np
import pytest
import yaml

import study
from study import building, io

PROJECT = Path(__file__).parent.parent


def test_the_help_is_short_and_starts_with_run():
    text = pydoc.plain(pydoc.render_doc(study))
    assert len(text.splitlines()) <= 150
    assert text.split("DESCRIPTION")[1].lstrip().startswith("``run``")


def test_the_help_names_all_that_is_public():
    public = {n for n in dir(study) if not n.startswith("_") and not inspect.ismodule(getattr(study, n))}
    named = set(re.findall(r"``(\w+)``", study.__doc__))
    assert named - public == {"study", "building", "materials", "dt", "u0", "v0", "steps", "over", "save"} | {
        "tolerance",
        "duration",
    }
    assert public <= named


def test_your_own_scheme_needs_no_other_import():
    """The implicit Euler method is defined, run and analysed by linear theory with names of ``study`` only."""

    class ImplicitEuler(study.Scheme):
        title: str = "Implicit Euler"
        family: ClassVar[str] = "own"
        source: ClassVar[str] = "Euler (1768)"
        doi: ClassVar[str] = ""
        order: ClassVar[int] = 1
        explicit: ClassVar[bool] = False

        def start(self, problem, u0, v0, dt):
            return building.Motion(u0, v0, building.acceleration(problem, 0.0, u0, v0)), building.Effort()

        def step(self, problem, state, t, dt):
            u, v = state.u + dt * state.v, state.v
            a, effort = building.balance(problem, building.load(problem, t + dt), u, v, dt**2, dt, guess=state.a)
            return building.Motion(u + dt**2 * a, v + dt * a, a), effort

    ds = study.run("hardening", ImplicitEuler(), dt=1e-4, steps=1000, observe=["energy_drift", "newton_iterations"])
    assert ds.status == 0 and ds.energy_drift < 0 and ds.newton_iterations > 1000
    assert study.LinearTheory(ImplicitEuler(), np.linspace(0.001, 0.002, 5)).order() == pytest.approx(1, abs=0.05)


def test_an_observer_of_ones_own_needs_no_other_import():
    class Lowest(study.Reduction):
        variables: ClassVar[dict] = {"lowest": {"long_name": "smallest displacement", "units": "1"}}

        def start(self, problem, state):
            return state.u

        def update(self, carried, problem, state, t, effort):
            return jnp.minimum(carried, state.u)

        def result(self, carried, problem, state):
            return {"lowest": carried}

    ds = study.run("hardening", "rk4", dt=0.15 / 100, steps=100, observe=[Lowest(), "trajectory"])
    assert ds.lowest == ds.u.min()


def test_the_version_is_that_of_the_project(monkeypatch):
    written = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]["version"]
    assert study.__version__ == written
    assert study.run("hardening", "rk4", dt=0.01, steps=1).version == written
    monkeypatch.setattr(io, "_PACKAGES", ("numpy", "no-such-package"))
    provenance = io.provenance("a title", "a test")
    assert provenance["version"] == written
    citation = yaml.safe_load((PROJECT / "CITATION.cff").read_text())
    assert [provenance["creator_name"]] == [author["name"] for author in citation["authors"]]
    assert provenance["license"] == citation["license"]
    assert re.fullmatch(r"numpy [\d.]+", provenance["packages"])


def _in_a_process(code: str, **environment: str) -> str:
    inherited = {name: v for name, v in os.environ.items() if not name.startswith(("XLA_FLAGS", "STUDY_", "JAX_"))}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env=inherited | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout + done.stderr


@pytest.mark.parametrize(
    "imports, environment, left",
    [
        ("jax, study", {}, "True True True"),
        ("study, jax", {}, "True True True"),
        ("jax, study", {"STUDY_SETTINGS": "precision"}, "True False False"),
        ("study, jax", {"STUDY_SETTINGS": "compiler, cache"}, "False True True"),
        ("study.scheme.newmark, jax", {"STUDY_SETTINGS": "none"}, "False False False"),
    ],
)
def test_what_the_import_changes_can_be_declined(imports, environment, left):
    code = (
        f"import os, {imports}; c = jax.config; "
        "print(c.jax_enable_x64, 'XLA_FLAGS' in os.environ, c.jax_compilation_cache_dir is not None)"
    )
    assert _in_a_process(code, **environment).strip() == left


def test_the_import_is_light_and_names_are_there_at_once():
    """An import of JAX before it is needed, which takes half a second."""
    code = "import sys, study; print({'jax', 'numpy'} & set(sys.modules), {'run', 'marching'} & set(dir(study)))"
    assert _in_a_process(code).strip() == "set() {'run'}"
    code = "import sys, study; study.open_dataset; print('jax' in sys.modules, study.run.__name__)"
    assert _in_a_process(code).strip() == "False run"
    assert "no attribute 'nonsense'" in _in_a_process("import study; study.nonsense")


def test_the_import_of_a_run_collects_no_garbage_and_leaves_out_what_few_runs_need():
    """Collections of garbage, which find none among imported objects, took a sixth of the time of the import."""
    heavy = "matplotlib scipy.optimize sympy diffrax netCDF4 reference study.assessment study.experiments"
    code = f"""
import gc, sys, study
collections = []
gc.callbacks.append(lambda *_: collections.append(1))
study.run
print(len(collections), gc.isenabled(), set("{heavy}".split()) & set(sys.modules))
gc.disable()
study.LinearTheory
print(gc.isenabled())
"""
    assert _in_a_process(code) == "0 True set()\nFalse\n"


def test_a_setting_that_does_not_exist_is_refused():
    stated = _in_a_process("import study", STUDY_SETTINGS="presision")
    assert "STUDY_SETTINGS must be 'none' or name some of precision, compiler, cache, not 'presision'." in stated


def test_jax_that_has_computed_nothing_is_no_reason_to_warn():
    code = "import jax, study; print(jax.config.jax_num_cpu_devices, len(jax.devices()))"
    assert _in_a_process(code) == "-1 1\n"
