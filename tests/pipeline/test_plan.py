"""The plan of the pipeline."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from paper import products
from pipeline import paper, start
from pipeline.plan import plan
from pipeline.step import Job
from tests.pipeline.pipeline import PROJECT


@pytest.fixture(scope="module")
def jobs() -> dict[tuple[str, str], Job]:
    """The jobs of the default study, by the names of step and job."""
    planned = plan(Path(), yaml.safe_load((PROJECT / "config" / "study.yaml").read_text()))
    return {(step["name"], name): Job(**job) for step in planned["steps"] for name, job in step["jobs"].items()}


def _readers(jobs, source: str) -> set[tuple[str, str]]:
    return {key for key, job in jobs.items() if source in job.inputs}


def _names(keys: Iterable[tuple[str, str]]) -> set[str]:
    return {step for step, _ in keys}


def test_an_edited_scheme_concerns_what_runs_it(jobs):
    runge_kutta, alpha = (_readers(jobs, f"study/scheme/{name}.py") for name in ("runge_kutta", "alpha"))
    assert {"energy_error", "energy_drift", "large_steps", "phase_portrait"} <= _names(runge_kutta)
    assert "energy_error" in _names(alpha) and not {"energy_drift", "houbolt_start"} & _names(alpha)
    assert not any(name.startswith("reference_") for name in _names(runge_kutta | alpha))


def test_an_edited_problem_concerns_what_runs_it_and_a_new_one_nothing_else(jobs):
    chains = _readers(jobs, "study/problem/chains.py")
    assert ("reference_structures", "fpu_chain") in chains and ("structures", "fpu_chain") in chains
    steps = {"reference_structures", "structures", "structure_history", "published_numbers", "runs", "site"}
    assert _names(chains) <= steps
    springs = _readers(jobs, "study/problem/springs.py")
    assert {"reference_springs", "energy_error", "accuracy", "kinks"} <= _names(springs)
    assert ("kinks", "hardening") in springs and ("kinks", "yielding") not in springs


def test_the_site_depends_on_the_modules_that_its_pages_import(jobs):
    imported = {f"paper/{name}.py" for name in ("data", "tables/decision", "tables/orders", "figures/style")}
    assert imported <= {*jobs["site", ""].inputs} and "paper/figures/atlas.py" not in jobs["site", ""].inputs


def test_the_records_of_a_folder_are_inputs(tmp_path):
    configuration = yaml.safe_load((PROJECT / "config" / "study.yaml").read_text())
    configuration["record_error"]["folder"] = str(tmp_path)
    (tmp_path / "a.txt").write_text("t (s), a (m/s2)\n0, 1\n0.01, 2")
    jobs = {step["name"]: step["jobs"] for step in plan(Path(), configuration)["steps"]}
    assert str(tmp_path / "a.txt") in jobs["reference_record_error"][""]["inputs"]
    # Snakemake makes another plan if a file is added
    before = [*start._listings(configuration)]
    (tmp_path / "b.txt").touch()
    assert before != [*start._listings(configuration)]


def test_schemes_and_data_that_no_option_names_are_inputs(jobs):
    assert "later_schemes" in _names(_readers(jobs, "study/scheme/noh_bathe.py"))
    assert "kinks" in _names(_readers(jobs, "study/mechanics/records/el_centro_1940_ns.at2"))
    configuration = yaml.safe_load((PROJECT / "config" / "study.yaml").read_text())
    configuration["published_numbers"]["coarsest"].append({"problem": "elastic_beam", "steps": 64})
    configuration["assess"]["own"] = {"problem": "pendulum", "duration": 60.0}
    steps = {step["name"]: step["jobs"] for step in plan(Path(), configuration)["steps"]}
    assert "study/problem/elastic_beam.csv" in steps["published_numbers"][""]["inputs"]
    assert {"study/scheme/bathe.py", "study/scheme/houbolt.py"} <= {*steps["assessment"]["own"]["inputs"]}


def test_every_job_of_the_study_depends_on_the_settings_of_jax(jobs):
    commands = {key for key, job in jobs.items() if job.command.startswith("pipeline.command")}
    assert len(commands) > 50 and commands <= _readers(jobs, "study/settings.py")


def test_what_is_drawn_depends_on_the_style_and_what_is_counted_does_not(jobs):
    assert "paper/figures/style.mplstyle" in jobs["figure", "instability"].inputs
    assert "paper/figures/style.mplstyle" not in jobs["claims", ""].inputs


def test_a_product_outside_of_the_folder_of_its_kind_is_refused():
    discovered = products.discover()
    paper.check_places(discovered)
    claim = next(product for product in discovered if product.kind == "claim")
    with pytest.raises(ValueError, match="is declared in paper.figures.own: move it to paper/claims"):
        paper.check_places([replace(claim, module="paper.figures.own")])


def test_a_dataset_that_is_not_made_is_named_with_its_reader():
    files = ["reference/softening_large.nc", "phase_portrait/softening_large.nc"]
    with pytest.raises(ValueError) as caught:
        paper.check_datasets("figure 'instability'", files, ["reference/softening_large"])
    assert str(caught.value) == (
        "figure 'instability' reads 'phase_portrait/softening_large', a dataset that this configuration does not make."
    )
    paper.check_datasets("figure 'instability'", files, ["reference/softening_large", "phase_portrait/softening_large"])
