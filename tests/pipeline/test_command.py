"""The command that runs an experiment."""

import os
import subprocess
import sys

import numpy as np
import pytest

from pipeline import command
from pipeline.configuration import model_of
from study import io
from study.declaration.experiment import Experiment, experiment
from study.declaration.options import Sampled, SchemeName, StructureLengths, names_in
from tests.pipeline.pipeline import PROJECT

MODULE = "study.experiments.energy_error"
OPTIONS = '{"problems": ["hardening"], "schemes": ["rk4"], "steps_per_period": [15], "periods": 1}'
OUTPUT = "results/energy_error.nc"


@pytest.mark.parametrize(
    "dataset, options, sentence",
    [
        ("energy_error", "{", "the options must be a JSON object"),
        ("energy_error", '{"problem": []}', "there is no option 'problem'; did you mean 'problems'?"),
        ("energy_error", '{"problems": []}', "the option 'schemes' is missing."),
        ("energy_error", OPTIONS, "there is no dataset 'results/reference/hardening.nc'"),
        ("energy_error", OPTIONS.replace("hardening", "hard"), "there is no problem 'hard'; did you mean 'hardening'?"),
        ("energy", OPTIONS, "study.experiments.energy_error makes no dataset 'energy'; did you mean 'energy_error'?"),
    ],
)
def test_mistakes_get_one_sentence_and_leave_no_file(dataset, options, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as caught:
        command.main([MODULE, dataset, OUTPUT, options])
    assert sentence in str(caught.value)
    assert not (tmp_path / OUTPUT).exists()


def test_an_output_that_cannot_be_written_stops_before_any_work(tmp_path):
    (tmp_path / "results").write_text("a file where a folder should be")
    done = subprocess.run(
        [sys.executable, "-m", "pipeline.command", MODULE, "energy_error", OUTPUT, OPTIONS],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert done.stderr.startswith("'results/energy_error.nc' cannot be written: File exists")


def test_a_dataset_that_is_not_declared_is_not_read():
    with io.reading_only(["reference/hardening"]), pytest.raises(ValueError, match="'accuracy' is read without"):
        io.open_dataset("accuracy")


def _untyped(steps):
    """An experiment whose option has no bounds."""


def _unbounded(samples: np.ndarray):
    """An experiment whose option no configuration can hold."""


def _unmarked(method: str | None):
    """An experiment with a string that may or may not name a scheme."""


@pytest.mark.parametrize(
    "function, sentence",
    [
        (_unmarked, "the argument 'method' of '_unmarked' needs a type of study.declaration.options, such as"),
        (_untyped, "the argument 'steps' of '_untyped' needs a type, which bounds its option in the configuration."),
        (_unbounded, "the type of an argument of '_unbounded' is not one that a configuration can hold: "),
    ],
)
def test_an_experiment_with_an_option_without_bounds_is_refused(function, sentence):
    entry = Experiment(("own",), function, "own")
    with pytest.raises(ValueError) as caught:
        model_of((entry,))
    assert str(caught.value).startswith(f"{__name__}: {sentence}") and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "kind, value, names",
    [
        (dict[str, SchemeName], {"a": "rk4"}, [("scheme", "rk4")]),
        (SchemeName | None, None, []),
        (Sampled, ["hardening", "stiff_soft"], [("problem", "hardening"), ("problem", "stiff_soft")]),
        (StructureLengths, [{"problem": "fpu_chain", "periods": 1.0}], [("problem", "fpu_chain")]),
    ],
)
def test_names_inside_options_are_found(kind, value, names):
    assert list(names_in(kind, value)) == names


def test_an_experiment_names_its_dataset():
    with pytest.raises(ValueError, match="an experiment must name the dataset that it makes"):
        experiment()
    with pytest.raises(ValueError, match="an experiment must name the dataset that it makes"):
        experiment(_untyped)  # type: ignore[arg-type]
