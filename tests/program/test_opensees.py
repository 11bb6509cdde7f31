"""Models of OpenSees in files; tests that run OpenSees are skipped if it is not installed."""

import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import study
from study.program import opensees_run
from study.program.attempt import Unfit, attempt

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def example(tmp_path):
    """Function that makes a program of an example; tests are skipped if OpenSees is not installed."""
    try:
        opensees_run.interpreter()
    except ImportError as reason:
        pytest.skip(str(reason))
    return lambda name, *arguments, **options: study.opensees(EXAMPLES / name, *arguments, folder=tmp_path, **options)


def _errors_against(coarse, finer):
    """Largest differences of a run from a finer run by quantity, relative to the largest value of the finer run."""
    stride = round((len(finer["t"]) - 1) / (len(coarse["t"]) - 1))
    return {n: np.abs(coarse[n] - finer[n][::stride]).max() / np.abs(finer[n]).max() for n in coarse}


def test_a_frame_of_fibres_keeps_its_errors_against_steps_ten_times_finer(example):
    program = example("opensees_frame.py", ["hht", "TRBDF2"], 4.0, spacing=0.02)
    assert program.schemes == ["hht_alpha", "bathe"] and program.title == "opensees_frame"
    ds = study.assess(program, allowed_errors=[0.05, 0.01])
    assert (ds.verdict <= 1).all() and (ds.reference_uncertainty <= 1e-3).all()
    steps = ds.recommended_step_size.sel(allowed_error=0.01)
    assert np.allclose(0.02 / steps, np.round(0.02 / steps))
    model = runpy.run_path(str(EXAMPLES / "opensees_frame.py"))
    for scheme in program.schemes:
        step = steps.sel(scheme=scheme, quantity="drift").item()
        coarse, finer = (opensees_run.history(model, scheme, dt, 4.0) for dt in (step, step / 10))
        error, stated = (
            _errors_against(coarse, finer)["drift"],
            ds.error.sel(scheme=scheme, step_size=step, quantity="drift"),
        )
        assert error <= 0.01 and error == pytest.approx(stated.item(), abs=2e-3)
        if (coarser := ds.step_size[ds.step_size > step]).size:
            coarse = opensees_run.history(model, scheme, float(coarser.min()), 4.0)
            assert max(_errors_against(coarse, finer).values()) > 0.005


def test_floors_that_pound_are_assessed(example):
    program = example("opensees_gap.py", ["average_acceleration", "central_difference"], 1.0, coarsest=0.04)
    ds = study.assess(program, allowed_errors=[0.1])
    assert (ds.verdict == 0).all() and (ds.largest_error <= ds.allowed_error).all()
    beyond = ds.sel(scheme="central_difference", quantity="second floor").error.max()
    assert not float(beyond) <= 1  # steps beyond the stability limit


def test_a_file_that_fails_says_why(example, tmp_path):
    program = example("opensees_gap.py", ["Newmark", "hht"], 2.0)
    (tmp_path / "broken.py").write_text("quantities = {}\ndef build(ops):\n    raise RuntimeError('no such section')\n")
    broken = study.opensees(tmp_path / "broken.py", program.schemes, 2.0)
    run = attempt(broken.run, "hht_alpha", 0.5, 2.0)
    assert run.reason == "it ended with the exit code 1: RuntimeError: no such section"
    with pytest.raises(KeyError, match="OpenSees has no scheme 'rk4'; known are average_acceleration, newmark_diss"):
        example("opensees_gap.py", ["rk4", "hht"], 2.0)
    with pytest.raises(FileNotFoundError, match="there is no file 'none.py' with a model of OpenSees."):
        study.opensees("none.py", ["Newmark", "hht"], 2.0)


def test_a_scheme_that_is_no_name_is_refused():
    with pytest.raises(TypeError, match="must be a name, such as 'hht_alpha', not an object of Houbolt."):
        study.opensees(EXAMPLES / "opensees_gap.py", ["hht", study.schemes["houbolt"]], 2.0)  # type: ignore[list-item]


def _interpreter(clock):
    """The commands of OpenSees that begin a run, for a model whose ``build`` leaves the clock at ``clock``."""
    names = ("wipe", "wipeAnalysis", "constraints", "numberer", "system", "test", "algorithm", "integrator", "analysis")
    return SimpleNamespace(**dict.fromkeys(names, lambda *words: None), getTime=lambda: clock)


def test_a_clock_that_gravity_has_moved_is_refused(monkeypatch):
    model = {"build": lambda ops: None, "quantities": {"roof": lambda ops: 1.0}}
    monkeypatch.setattr(opensees_run, "interpreter", lambda: _interpreter(1.0))
    sentence = r"build\(ops\) leaves the clock at 1 s, and must end with ops.loadConst\('-time', 0.0\)"
    with pytest.raises(Unfit, match=sentence):
        opensees_run.history(model, "hht_alpha", 0.1, 0.0)
    monkeypatch.setattr(opensees_run, "interpreter", lambda: _interpreter(0.0))
    assert opensees_run.history(model, "hht_alpha", 0.1, 0.0)["roof"] == [1.0]


def test_gravity_without_a_constant_load_ends_the_assessment(example, tmp_path):
    (tmp_path / "model.py").write_text(
        f"import runpy\nmodel = runpy.run_path({str(EXAMPLES / 'opensees_gap.py')!r})\n"
        "quantities = model['quantities']\ndef build(ops):\n    model['build'](ops)\n    ops.setTime(1.0)\n"
    )
    program = study.opensees(tmp_path / "model.py", ["Newmark", "hht"], 2.0, folder=tmp_path)
    with pytest.raises(ValueError, match=r"^'model' cannot be run: build\(ops\) leaves the clock at 1 s, and must"):
        study.assess(program)
    assert not [*tmp_path.rglob("*.npz")]


def test_the_library_that_opensees_lacks_is_named(monkeypatch, tmp_path):
    message = "libblas.so.3: cannot open shared object file: No such file or directory"
    (tmp_path / "openseespy").mkdir()
    (tmp_path / "openseespy" / "__init__.py").touch()
    (tmp_path / "openseespy" / "opensees.py").write_text(
        f"try:\n    raise ImportError('{message}')\nexcept ImportError:\n    raise RuntimeError('Failed to import.')\n"
    )
    for name in ("openseespy", "openseespy.opensees"):
        monkeypatch.setitem(sys.modules, name, None)  # type: ignore[arg-type]  # is undone to what it was before
        del sys.modules[name]
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ImportError, match=rf"Debian the packages libblas3, liblapack3 and libgfortran5 \({message}\)"):
        study.opensees(EXAMPLES / "opensees_gap.py", ["Newmark", "hht"], 2.0)
