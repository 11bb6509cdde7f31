"""Assessments of problems and schemes in a user's files, which the configuration of the pipeline names."""

from pathlib import Path

import pytest
import yaml

import study
from study.assessment.experiment import _check
from study.scheme.named import SCHEMES_OF_1996
from tests.pipeline.pipeline import SMALL, call_snakemake, copied, make


@pytest.mark.parametrize(
    "options, sentence",
    [
        ({"problem": "examples/driven.py:drive", "duration": 20.0}, "has no 'drive'; did you mean 'driven'?"),
        ({"problem": "examples/driven.py:driven"}, "has no period that gives the length of the runs: give a duration"),
        ({"problem": "hardnening"}, "there is no problem 'hardnening'; did you mean 'hardening'?"),
        ({"problem": "hardening", "quantities": "examples/driven.py:driven"}, "must be a dict, not Problem."),
    ],
)
def test_what_cannot_be_assessed_is_refused_before_any_work(options, sentence):
    assert sentence in str(_check(options, {}))


def _edited(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.mark.pipeline
def test_the_pipeline_assesses_a_problem_and_a_scheme_in_files(tmp_path):
    """A problem or scheme in a file that the pipeline loads wrongly, or whose change it does not notice."""
    folder = copied(tmp_path)
    options = {
        "problem": "examples/driven.py:driven",
        "duration": 20.0,
        "schemes": ["rk4", "heun"],
        "allowed_errors": [0.05],
    }
    overlay = {
        "own_schemes": ["examples/scheme.py:heun"],
        "assess": {"mine": options, "spring": {"problem": "hardening", "periods": 10, "schemes": ["rk4"]}},
        "sensitivity": {"schemes": [*SCHEMES_OF_1996, "heun"]},
    }
    (folder / "mine.yaml").write_text(yaml.safe_dump(overlay))
    overlays = SMALL, folder / "mine.yaml"
    make(folder, "assessment/mine.html", "assessment/spring.nc", "sensitivity.nc", overlays=overlays)
    spring = study.open_dataset("assessment/spring", folder / "results")
    period = study.open_dataset("reference/hardening", folder / "results").period.item()
    assert spring.duration == spring.periods * period and (spring.verdict == 0).any()
    assert "<td>5\u00a0%</td>" in (folder / "results/assessment/mine.html").read_text()
    ds = study.open_dataset("assessment/mine", folder / "results")
    assert ds.scheme.values.tolist() == ["rk4", "heun"] and (ds.verdict == 0).any()
    assert study.open_dataset("sensitivity", folder / "results").scheme_title.values[-2:].tolist() == [
        "Runge-Kutta",
        "Heun",
    ]
    _edited(folder / "examples/driven.py", "0.5 *", "0.4 *")
    planned = call_snakemake(folder, "-n", "results/assessment/mine.html", overlays=overlays)
    assert "Updated input files: examples/driven.py" in planned.stdout
    _edited(folder / "examples/scheme.py", "dt**2 / 2 * slope", "dt * dt / 2 * slope")
    planned = call_snakemake(folder, "-n", "results/sensitivity.nc", overlays=overlays)
    assert "Updated input files: examples/scheme.py" in planned.stdout
