"""Configurations and results are data: whatever their strings say, nothing runs and nothing is written elsewhere."""

import json
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from pipeline import configuration
from pipeline.datasets import steps_of
from pipeline.sources import Sources
from study.declaration.experiment import discover
from tests.pipeline.pipeline import PROJECT, SMALL, call_snakemake, copied

#: Strings that a shell, a template, a path or a loader could interpret.
HOSTILE = [
    "$(touch pwned)",
    "`touch pwned`",
    "'; touch pwned; '",
    '"; touch pwned; "',
    "a\ntouch pwned\n",
    "{params.command}",
    "{workflow}",
    "~/pwned",
    "-c import os; os.mkdir('pwned')",
    "!!python/object/apply:os.mkdir ['pwned']",
]


def _whole(changes: dict) -> dict:
    whole = yaml.safe_load((PROJECT / "config" / "study.yaml").read_text())
    return configuration.check(discover(), whole | changes)


@pytest.mark.parametrize("name", [*HOSTILE, "../outside", "/tmp/outside", "a/../../outside", ".hidden", "a b", ""])
def test_a_name_that_becomes_a_file_is_plain(name):
    with pytest.raises(ValueError, match="assess"):
        _whole({"assess": {name: {"problem": "softening"}}})


@pytest.mark.parametrize("hostile", HOSTILE)
def test_a_string_reaches_the_experiment_as_it_is(tmp_path, monkeypatch, hostile):
    """The file of a problem may have any name, which the shell passes on unchanged."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    file = Path("problems", f"{hostile.replace('/', '_')}.py")
    file.parent.mkdir()
    file.write_text("import study\nproblem = study.Problem(lambda u: u, 1.0)\n")
    whole = _whole({"assess": {"own": {"problem": f"{file}:problem", "duration": 1.0}}})
    steps = steps_of(discover(), whole, Sources(PROJECT, "study", "reference", "pipeline"))
    (step,) = (step for step in steps if step.name == "assessment")
    command = step.jobs["own"].command
    words = shlex.split(command)
    assert json.loads(words[-1])["problem"] == f"{file}:problem"
    said = subprocess.run(f"printf '%s\\0' {command}", shell=True, capture_output=True, text=True)
    assert said.stdout.split("\0")[:-1] == words
    assert {path.name for path in tmp_path.rglob("*")} == {"problems", file.name}


def test_a_configuration_makes_no_objects_and_no_files(tmp_path):
    """A reader of YAML that runs code of the configuration."""
    folder = copied(tmp_path / "project")
    before = {path.name for path in tmp_path.rglob("*")}
    (folder / "hostile.yaml").write_text("sensitivity: !!python/object/apply:os.mkdir ['pwned']\n")
    done = call_snakemake(folder, "--dry-run", overlays=[SMALL, "hostile.yaml"])
    assert done.returncode != 0 and "Config file is not valid JSON or YAML" in done.stdout + done.stderr
    new = {path.name for path in tmp_path.rglob("*")} - before
    assert "pwned" not in new
