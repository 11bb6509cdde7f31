"""The files for catalogues agree with CITATION.cff, which ``make citation`` validates, and with pyproject.toml."""

import json
import re
import tomllib
from pathlib import Path

import pytest
import yaml

import study

PROJECT = Path(__file__).parents[1]
CITATION = yaml.safe_load((PROJECT / "CITATION.cff").read_text())
METADATA = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
RECIPE = yaml.safe_load((PROJECT / "recipe" / "recipe.yaml").read_text())
CODEMETA, ZENODO = (json.loads((PROJECT / name).read_text()) for name in ("codemeta.json", ".zenodo.json"))


@pytest.mark.parametrize("catalogue, title, authors", [(CODEMETA, "name", "author"), (ZENODO, "title", "creators")])
def test_what_catalogues_read_is_that_of_the_citation(catalogue, title, authors):
    assert catalogue[title] == CITATION["title"]
    assert [author["name"] for author in catalogue[authors]] == [author["name"] for author in CITATION["authors"]]
    assert catalogue["version"] == CITATION["version"] == METADATA["version"]
    assert str(CITATION["date-released"]) in catalogue.values()
    assert CITATION["license"] in str(catalogue["license"])
    assert catalogue["description"] == CITATION["abstract"]
    assert catalogue["keywords"] == CITATION["keywords"] == METADATA["keywords"]
    assert CITATION["references"][0]["doi"] in str(catalogue)
    assert "More than forty schemes" in catalogue["description"] and len(study.schemes) > 40


def test_the_requirements_are_those_of_the_package():
    assert CODEMETA["softwareRequirements"] == [f"python{METADATA['requires-python']}", *METADATA["dependencies"]]


def test_the_changelog_begins_with_the_release():
    text = (PROJECT / "CHANGELOG.md").read_text()
    assert re.findall("^## (.*)$", text, re.MULTILINE)[0] == f"{CITATION['version']} - {CITATION['date-released']}"


def test_the_conda_recipe_is_that_of_the_package():
    assert RECIPE["context"] == {"version": METADATA["version"], "python_min": METADATA["requires-python"].strip(">=")}
    assert RECIPE["about"]["license"] == METADATA["license"] and RECIPE["package"]["name"] == METADATA["name"]
    assert RECIPE["about"]["summary"] == METADATA["description"]
    _, *run = RECIPE["requirements"]["run"]
    assert run == [requirement.lower().replace(">=", " >=") for requirement in METADATA["dependencies"]]
    (name, command), *others = METADATA["scripts"].items()
    assert not others and RECIPE["build"]["python"]["entry_points"] == [f"{name} = {command}"]
