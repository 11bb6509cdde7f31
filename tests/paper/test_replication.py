"""The replication in the form of ReScience C."""

import json
import re
from pathlib import Path

import pytest
import yaml

from paper.manuscript import LAYOUT

PROJECT = Path(__file__).parents[2]
ABOUT = yaml.safe_load(LAYOUT.with_name("metadata.yaml").read_text())
CITATION = yaml.safe_load((PROJECT / "CITATION.cff").read_text())
#: Keys of the metadata in the template of ReScience C.
KEYS = """
title authors affiliations keywords code data replication abstract bibliography type domain language review contributors
dates article journal
"""


def test_the_metadata_have_the_form_of_the_template():
    assert list(ABOUT) == KEYS.split()
    assert ABOUT["title"] == f"[Re] {CITATION['references'][0]['title']}" and ABOUT["type"] == "Replication"
    assert [author["name"] for author in ABOUT["authors"]] == [author["name"] for author in CITATION["authors"]]
    replicated = {key: value for entry in ABOUT["replication"] for key, value in entry.items()}
    assert replicated["doi"] == CITATION["references"][0]["doi"]
    assert f"{{{replicated['bib']}," in (LAYOUT.parent / ABOUT["bibliography"]).read_text()


def test_the_numbers_of_the_abstract_are_those_of_the_study():
    results = PROJECT / "results" / "numbers.json"
    if not results.exists():
        pytest.skip("results/numbers.json is not there; `make` makes it")
    numbers = json.loads(results.read_text())
    pattern = r"Of the (\d+) errors .* (\d+) agree .* and (\d+) if once.* Each of its (\d+) checkable claims"
    (stated,) = re.findall(pattern, ABOUT["abstract"])
    names = ("cells", "cells_rounded_twice", "cells_rounded_once", "claims")
    assert list(stated) == [numbers[name] for name in names]
    assert numbers["rk4_held_at_20"] and numbers["others_grow_too"]
