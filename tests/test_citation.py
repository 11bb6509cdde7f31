"""What catalogues read says what CITATION.cff says; ``make citation`` checks that, and derives the others from it."""

import json
from pathlib import Path

import pytest
import yaml

PROJECT = Path(__file__).parents[1]
CITATION = yaml.safe_load((PROJECT / "CITATION.cff").read_text())


@pytest.mark.parametrize(
    "file, title, authors", [("codemeta.json", "name", "author"), (".zenodo.json", "title", "creators")]
)
def test_what_catalogues_read_is_derived_from_it(file, title, authors):
    derived = json.loads((PROJECT / file).read_text())
    assert derived[title] == CITATION["title"]
    assert [one["name"] for one in derived[authors]] == [one["name"] for one in CITATION["authors"]]
    assert derived["version"] == CITATION["version"]
    assert CITATION["license"] in str(derived["license"])
