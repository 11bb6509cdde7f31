"""The examples; each problem is assessed with one scheme."""

import runpy
import subprocess
import sys
from pathlib import Path
from types import FunctionType

import jax
import numpy as np
import pytest
import xarray as xr

import study
from study.mechanics.frequencies import frequencies
from study.user_files import load

FOLDER = Path(__file__).parent.parent / "examples"

#: Problems of the example files, with the duration of their runs and their quantities.
PROBLEMS = {
    "frame.py:frame": (3.0, "frame.py:quantities"),
    "yielding_frame.py:frame": (2.0, "yielding_frame.py:quantities"),
    "driven.py:driven": (15.0, "driven.py:quantities"),
    "truss.py:truss": (0.5, None),
    "pendulum.py:pendulum": (10.0, None),
}


@pytest.fixture(autouse=True)
def usual_rules():
    """JAX's usual rules, which are less strict than those of the tests."""
    with jax.numpy_rank_promotion("allow"), jax.numpy_dtype_promotion("standard"):
        yield


@pytest.mark.slow
@pytest.mark.parametrize(
    "place",
    [pytest.param(place, marks=() if place == "driven.py:driven" else pytest.mark.exhaustive) for place in PROBLEMS],
)
def test_a_problem_is_assessed(place):
    """A file of examples that no longer works as the problem of an assessment."""
    duration, wanted = PROBLEMS[place]
    problem = load(f"{FOLDER / place}", (study.Problem,))
    quantities = load(f"{FOLDER / wanted}", (dict,)) if wanted else None
    ds = study.assess(
        problem, "average_acceleration", duration=duration, quantities=quantities, allowed_errors=0.05, maps=False
    )
    assert (ds.recommended_error.where(ds.recommended_step_size.notnull(), 0) <= 0.05).all()
    assert (ds.verdict <= 1).any()


def test_the_scheme_of_the_examples_has_its_order():
    """A change of the interface of schemes after which the one of the examples no longer works."""
    heun = load(f"{FOLDER / 'scheme.py'}:heun", (study.Scheme,))
    assert study.LinearTheory(heun, np.logspace(-3, 0, 31)).order() == pytest.approx(2, abs=0.05)
    driven = load(f"{FOLDER / 'driven.py'}:driven", (study.Problem,))
    ours, accurate = (
        study.run(driven, scheme, dt=0.01, steps=1000, every=1000).u[-1].item() for scheme in (heun, "rk4")
    )
    assert ours == pytest.approx(accurate, abs=1e-3)


@pytest.mark.pipeline
def test_the_parts_of_a_snakefile_are_the_ensemble(tmp_path):
    """Parts of an ensemble that differ from the ensemble in one run, or that Snakemake gathers wrongly."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(FOLDER / "parts.smk"), "--cores", "1", "--config"]
    subprocess.run([*command, "lanes=600", "parts=2"], cwd=tmp_path, check=True)
    drift = load(f"{FOLDER / 'intensities.py'}:fragility", (FunctionType,))(600).drift
    parts = [xr.load_dataset(path) for path in sorted((tmp_path / "runs").iterdir())]
    np.testing.assert_array_equal(xr.concat(parts, "lane").drift, drift)
    share = f"{100 * float((drift > 0.04).mean()):.2f} % of 600 exceed 40 mm"
    assert share in (tmp_path / "shares.txt").read_text()


@pytest.mark.slow
def test_ensembles_of_yielding_oscillators():
    """The drift is much larger at the largest intensity than at the smallest; lanes agree with single runs."""
    analysis = load(f"{FOLDER / 'intensities.py'}:analysis", (FunctionType,))()
    assert float(analysis.drift[-1]) > 5 * float(analysis.drift[0]) and (analysis.status == 0).all()
    oscillator = load(f"{FOLDER / 'intensities.py'}:oscillator", (FunctionType,))
    alone = study.run(oscillator(float(analysis.intensity[7])), "average_acceleration", **_run_of_intensities())
    np.testing.assert_allclose(alone.drift, analysis.drift[7], rtol=1e-12)
    few = load(f"{FOLDER / 'intensities.py'}:fragility", (FunctionType,))(count=20)
    assert few.drift.shape == (20,) and float(few.drift.std()) > 0


def _run_of_intensities():
    return load(f"{FOLDER / 'intensities.py'}:RUN", (dict,))


def test_every_example_is_tested():
    others = {"scheme.py", "intensities.py", "plate.py", "opensees_frame.py", "opensees_gap.py", "parts.py"}
    assert {path.name for path in FOLDER.glob("*.py")} == {place.split(":")[0] for place in PROBLEMS} | others


@pytest.mark.slow
def test_the_plate_bends_like_a_beam():
    """The first frequency of a plate, whose elements bend too stiffly, is that of a beam to 3 %."""
    plate = load(f"{FOLDER / 'plate.py'}:cantilever", (FunctionType,))(40, 4)
    file = runpy.run_path(str(FOLDER / "plate.py"))
    length, height = 40 * file["SIDE"], 4 * file["SIDE"]
    beam_frequency = 1.8751**2 / length**2 * np.sqrt(file["YOUNG"] * height**2 / (12 * file["DENSITY"]))
    plate_frequencies = frequencies(plate)
    assert plate_frequencies is not None and plate_frequencies[0] == pytest.approx(beam_frequency, rel=0.03)
    ds = study.run(plate, "average_acceleration", dt=5e-5, steps=100, observe=["max_energy_error"])
    assert ds.status == 0 and ds.max_energy_error < 0.01
