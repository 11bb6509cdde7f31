"""What catalogues read agrees with CITATION.cff, which ``make citation`` validates, and with pyproject.toml."""

import json
import tomllib
from pathlib import Path

import pytest
import yaml

PROJECT = Path(__file__).parents[1]
CITATION = yaml.safe_load((PROJECT / "CITATION.cff").read_text())
METADATA = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
CODEMETA, ZENODO = (json.loads((PROJECT / name).read_text()) for name in ("codemeta.json", ".zenodo.json"))


@pytest.mark.parametrize("catalogue, title, authors", [(CODEMETA, "name", "author"), (ZENODO, "title", "creators")])
def test_what_catalogues_read_is_that_of_the_citation(catalogue, title, authors):
    assert catalogue[title] == CITATION["title"]
    assert [one["name"] for one in catalogue[authors]] == [one["name"] for one in CITATION["authors"]]
    assert catalogue["version"] == CITATION["version"]
    assert CITATION["license"] in str(catalogue["license"])
    assert catalogue["description"] == CITATION["abstract"]
    assert catalogue["keywords"] == CITATION["keywords"] == METADATA["keywords"]
    assert CITATION["references"][0]["doi"] in str(catalogue)


def test_the_requirements_are_those_of_the_package():
    assert CODEMETA["softwareRequirements"] == [f"python{METADATA['requires-python']}", *METADATA["dependencies"]]
