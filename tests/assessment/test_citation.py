"""What a dataset rests on, as BibTeX."""

import re

import pytest
import xarray as xr

import study
from study.assessment import citation
from tests import bibliography


def test_every_scheme_of_a_dataset_is_cited():
    text = study.cite(xr.Dataset(coords={"scheme": [*study.schemes, "of another program"]}, attrs={"version": "1.2"}))
    keys = re.findall(r"^@\w+\{(\w+),", text, re.MULTILINE)
    works = bibliography.works()
    sources = {(one.source, one.doi) for one in study.schemes.values()}
    cited = {(bibliography.label(works[key]), works[key].get("doi", "")) for key in keys[1:]}
    assert cited == sources | {("Xie (1996)", "10.1006/jsvi.1996.0190")}
    assert keys[0] == "time_integration_study" and "version = {1.2}" in text and "shortjournal" not in text


def test_a_run_and_the_solvers_of_a_reference_are_cited():
    ds = study.run("softening", "bathe", dt=0.01, steps=1)
    ds.attrs |= {"reference": "heyoka", "witness": "CVODE Adams", "date_created": "2026-11-25"}
    text = study.cite(ds)
    assert re.findall(r"^@\w+\{(\w+),", text, re.MULTILINE)[1:] == [
        "bathe2005",
        "biscani2021",
        "hindmarsh2005",
        "xie1996",
    ]
    assert "year = {2026}" in text
    with pytest.raises(ValueError, match="cite takes a dataset of the study"):
        study.cite(xr.Dataset())


def test_the_bibliography_is_that_of_the_article():
    assert citation.WORKS.read_text() == bibliography.FILE.read_text()
