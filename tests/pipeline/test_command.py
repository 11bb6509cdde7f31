"""The command line of the experiments."""

import subprocess
import sys

import pytest


def _call(*arguments, cwd):
    return subprocess.run(
        [sys.executable, "-m", "study.experiments.energy_error", *arguments], cwd=cwd, capture_output=True, text=True
    )


OPTIONS = '{"problems": ["hardening"], "schemes": ["rk4"], "steps_per_period": [15], "periods": 1}'


@pytest.mark.parametrize(
    "options, sentence",
    [
        ("{", "the options must be a JSON object"),
        ('{"problem": []}', "there is no option 'problem'; did you mean 'problems'?"),
        ('{"problems": []}', "the option 'schemes' is missing."),
        (OPTIONS, "there is no dataset 'results/reference/hardening.nc'; `snakemake results/reference/hardening.nc`"),
        (OPTIONS.replace("hardening", "hard"), "did you mean 'hardening'?"),
    ],
)
def test_mistakes_get_one_sentence_and_leave_no_file(options, sentence, tmp_path):
    done = _call("results/energy_error.nc", options, cwd=tmp_path)
    assert done.returncode == 1
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "results" / "energy_error.nc").exists()


def test_an_output_that_cannot_be_written_stops_before_any_work(tmp_path):
    (tmp_path / "results").write_text("a file where a folder should be")
    done = _call("results/energy_error.nc", OPTIONS, cwd=tmp_path)
    assert done.returncode == 1
    assert "the results folder 'results' cannot be made" in done.stderr
