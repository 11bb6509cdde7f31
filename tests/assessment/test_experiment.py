"""Assessments that the configuration names, through the pipeline."""

import yaml

import study
from tests.pipeline.pipeline import SMALL, call_snakemake, copied, make


def test_the_pipeline_assesses_a_problem_in_a_file(tmp_path):
    folder = copied(tmp_path)
    asked = {"problem": "examples/driven.py:driven", "duration": 20.0, "own_schemes": ["examples/scheme.py:heun"]}
    overlay = folder / "mine.yaml"
    overlay.write_text(yaml.safe_dump({"assess": {"mine": asked | {"schemes": ["rk4"], "errors": [0.05]}}}))
    overlays = SMALL, overlay
    make(folder, "assessment/mine.html", overlays=overlays)
    assert "For 5 % of displacement: " in (folder / "results/assessment/mine.html").read_text()
    ds = study.open("assessment/mine", folder / "results")
    assert ds.scheme.values.tolist() == ["rk4", "heun"] and (ds.verdict == 0).any()
    (folder / "examples/driven.py").write_text((folder / "examples/driven.py").read_text().replace("0.5 *", "0.4 *"))
    planned = call_snakemake(folder, "-n", "results/assessment/mine.html", overlays=overlays)
    assert "Updated input files: examples/driven.py" in planned.stdout
