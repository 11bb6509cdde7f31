"""BibTeX entries of the works on which a dataset is based."""

import re

import numpy as np
import pytest
import xarray as xr

import study
from study.assessment import citation
from tests import bibliography


def test_every_scheme_of_a_dataset_is_cited():
    text = study.cite(xr.Dataset(coords={"scheme": [*study.schemes, "of another program"]}, attrs={"version": "1.2"}))
    keys = re.findall(r"^@\w+\{(\w+),", text, re.MULTILINE)
    works = bibliography.works()
    sources = {(scheme.source, scheme.doi) for scheme in study.schemes.values()}
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


def test_records_of_ground_motion_are_cited():
    def cited(ground):
        problem = study.Problem(lambda u: 40 * u, 0.0, ground=ground)
        return study.cite(study.run(problem, "rk4", dt=0.01, steps=1))

    text = cited(study.GroundMotion.el_centro().scaled(2.0))
    assert "@misc{el_centro_1940_ns,\n  title = {El Centro 1940, north-south component" in text
    assert "Imperial Valley earthquake, 18 May 1940}" in text
    text = cited(study.GroundMotion.kanai_tajimi(3, duration=1.0))
    assert "{tajimi1960," in text and "{jennings1969," in text and "@misc" not in text
    assert "@misc" not in cited(study.GroundMotion(np.array([0.0, 1.0]), 0.1))


def test_the_bibliography_is_that_of_the_article():
    assert citation.WORKS.read_text() == bibliography.FILE.read_text()
