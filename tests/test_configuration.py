"""The configuration is refused with one sentence that names the key."""

from pathlib import Path

import pytest
import yaml
from snakemake.utils import update_config

import study
from study.pipeline.configuration import check, complete

FOLDER = Path(__file__).parent.parent / "config"


@pytest.fixture(params=["study.yaml", "full.yaml"])
def config(request) -> dict:
    """The configurations that are shipped, each laid over that of the study, as Snakemake does."""
    settings = yaml.safe_load((FOLDER / "study.yaml").read_text())
    update_config(settings, yaml.safe_load((FOLDER / request.param).read_text()))
    return settings


def test_what_is_shipped_is_accepted(config):
    check(config)


def test_all_schemes_are_written_out(config):
    config["accuracy"]["schemes"] = "all"
    check(config)
    complete_one = complete(config)
    assert complete_one["accuracy"]["schemes"] == list(study.schemes)
    assert complete_one["energy_error"] == config["energy_error"]


@pytest.mark.parametrize(
    "change, sentence",
    [
        (
            lambda c: c.update(enery_error={}),
            "the configuration has no key 'enery_error'; did you mean 'energy_error'?",
        ),
        (lambda c: c["cpu_time"].update(repeat=3), "cpu_time has no key 'repeat'; did you mean 'repeats'?"),
        (lambda c: c["cpu_time"].update(repeats="many"), "cpu_time.repeats: 'many' is not of type 'integer'."),
        (lambda c: c["energy_error"].update(periods=0), "energy_error.periods: 0 is less than the minimum of 1."),
        (lambda c: c["energy_error"].pop("periods"), "energy_error: 'periods' is a required property."),
        (lambda c: c["cpu_time"].update(repeats=15.0), "cpu_time.repeats: 15.0 is not of type 'integer'."),
        (lambda c: c["sensitivity"].update(dt=float("nan")), "sensitivity.dt must be finite, not nan."),
        (
            lambda c: c["phase_portrait"]["hardening"].update(dt=75),
            "hardening: a duration of 15.0 is less than one step of 75.",
        ),
        (lambda c: c["energy_drift"]["steps_per_period"].update(first=50), "first, 50, must be less than last, 40."),
        (lambda c: c["large_steps"].update(dt_over_period=[0.1, 300.0]), "a step is longer than the 100 periods"),
        (lambda c: c["round_off"].update(schemes="all"), "round_off.schemes: 33 are more than the 7 curves"),
        (lambda c: c["atlas"].update(schemes=list(study.schemes)[:7]), "atlas.schemes has none but those of the paper"),
        (
            lambda c: c["stability"]["structures"].update(excitations=[0.5, 2]),
            "stability.structures.excitations lacks 1",
        ),
        (lambda c: c["cpu_time"].update(schemes=["rk4"]), "cpu_time.schemes lacks 'average_acceleration', which the"),
        (
            lambda c: c["structures"]["lengths"].append({"problem": "fpu_chian", "periods": 1}),
            "structures.lengths: there is no problem 'fpu_chian'; did you mean 'fpu_chain'?",
        ),
        (lambda c: c["large_steps"].update(problems=["pendulum"]), "problems: 'pendulum' is a structure; give one of"),
        (
            lambda c: c["structures"]["lengths"].append({"problem": "hardening", "periods": 1}),
            "'hardening' is none of the structures pendulum,",
        ),
        (lambda c: c["atlas"].update(tiles=1000), "atlas.tiles: there are more of them, 1000, than amplitudes."),
        (lambda c: c["atlas"]["dt_over_period"].update(last=5), "atlas.dt_over_period: a step is longer than the"),
        (
            lambda c: c["atlas"]["amplitudes"].update(first=2),
            "atlas.amplitudes: first, 2, must be less than last, 1.5.",
        ),
        (
            lambda c: c["robustness"]["problems"].append("softening_large"),
            "robustness.problems: 'softening_large' is none",
        ),
        (
            lambda c: c["stability"]["bifurcation"].update(shown=10**6),
            "stability.bifurcation: shown, 1000000, are more",
        ),
        (
            lambda c: c["stability"]["roots"]["schemes"].append("bathe"),
            "a step of 'Bathe' is not one effective equation",
        ),
        (
            lambda c: c["stability"]["roots"]["schemes"].append("bathed"),
            "stability.roots.schemes: there is no scheme 'bathed'",
        ),
        (
            lambda c: c["stability"]["structures"]["lengths"].pop(0),
            "stability.structures.lengths lacks 'pendulum', which",
        ),
        (
            lambda c: c["stability"]["structures"]["lengths"].append({"problem": "hardening", "periods": 1}),
            "stability.structures.lengths: 'hardening' is none of the structures pendulum,",
        ),
        (lambda c: c["stability"]["bifurcation"].update(problem="hardening"), "the manuscript tells of 'double_well'"),
        (
            lambda c: c["stability"]["roots"].update(paper_dt=7),
            "stability.roots.paper_dt: that of the paper is 2.5, not 7",
        ),
        (lambda c: c["spectral"].update(damping_ratios=[0.1]), "spectral.damping_ratios lacks 0.0"),
        (lambda c: c["robustness"].update(problems=["softening"]), "robustness.problems lacks 'hardening', which the"),
        (lambda c: c["structures"].update(steps_per_period=[25]), "25 is no multiple of samples_per_period, 20."),
        (
            lambda c: c["structures"].update(lengths=[{"problem": "stiff_soft", "periods": 1}]),
            "structures.lengths lacks 'fpu_chain', which the",
        ),
        (
            lambda c: c["structure_history"]["stiff_soft"].update(problem="duffing"),
            "structure_history.stiff_soft.problem: there is no problem 'duffing'; did you mean 'duffing_",
        ),
        (lambda c: c["structure_history"]["stiff_soft"].update(every=7), "stiff_soft: every, 7, does not divide the"),
        (lambda c: c["sensitivity"].update(dt=0), "sensitivity.dt: 0 is less than or equal to the minimum of 0."),
        (lambda c: c["large_steps"].update(schemes=["rk5"]), "large_steps.schemes: there is no scheme 'rk5'; did you"),
        (
            lambda c: c["references"].update(problems=["hard"]),
            "references.problems: there is no problem 'hard'; did you mean 'hardening'?",
        ),
        (lambda c: c["accuracy"].update(periods=[1, 100]), "accuracy.periods lacks 3, which the manuscript and its"),
        (
            lambda c: c["agreement"].update(tolerances=[1e-9, 1e-4]),
            "agreement.tolerances must fall, not [1e-09, 0.0001]",
        ),
        (
            lambda c: c["recommendation"].update(measures=["energy"]),
            "recommendation.measures: there is no energy among rms",
        ),
        (
            lambda c: c["work_precision"]["schemes"].update(steps_per_period=[9]),
            "steps_per_period: there is no 9 among 8",
        ),
        (
            lambda c: c["work_precision"]["solvers"].update(tolerances=[1e-14]),
            "solvers.tolerances.0: 1e-14 is less than the minimum of 2.3e-14",
        ),
        (
            lambda c: c["long_times"].update(schemes=["park"]),
            "long_times.schemes: the sums of 'park' cannot be compens",
        ),
        (
            lambda c: c["long_times"].update(schemes=["rk4"]),
            "long_times.schemes lacks 'central_difference', which the",
        ),
        (lambda c: c["long_times"].update(periods=[10, 3, 30]), "long_times.periods must rise, not [10, 3, 30]."),
        (lambda c: c["long_times"].update(periods=[1, 2, 3, 1000]), "a law of growth takes three lengths within the"),
        (lambda c: c["references"].update(problems=["softening"]), "long_times.problem: there is no 'hardening' among"),
        (lambda c: c["accuracy"].update(schemes="most"), "accuracy.schemes: 'all' was expected"),
        (lambda c: c["spectral"].update(damping_ratios=[1.0]), "damping_ratios.0: 1.0 is greater than or equal to the"),
        (
            lambda c: c["energy_drift"].update(scheme="houbolt"),
            "energy_drift.scheme: the manuscript tells of 'rk4', not",
        ),
        (
            lambda c: c["sensitivity"].update(problem="hardening"),
            "sensitivity.problem: the manuscript tells of 'double",
        ),
        (
            lambda c: c["structure_history"]["long_times"].update(problem="elastic_pendulum"),
            "structure_history.long_times.problem: the manuscript tells of 'fpu_chain', not of 'elastic_pendulum'",
        ),
        (
            lambda c: c["energy_drift"]["steps_per_period"].update(first=30),
            "energy_drift.steps_per_period leaves out 20",
        ),
        (lambda c: c["large_steps"].update(dt_over_period=[0.1, 0.2]), "large_steps.dt_over_period has none above 0.2"),
        (
            lambda c: c["structures"]["lengths"].append({"problem": "stiff_soft", "periods": 3}),
            "structures.lengths has 'stiff_soft' twice.",
        ),
        (lambda c: c["robustness"].update(periods=[100, 10]), "robustness.periods must rise, not [100, 10]"),
        (lambda c: c["large_steps"].update(problems=["hardening", "softening"]), "large_steps.problems lacks 'soften"),
        (lambda c: c["energy_error"]["steps_per_period"].remove(25), "energy_error.steps_per_period lacks '25', which"),
        (lambda c: c["round_off"].update(schemes=["houbolt"]), "round_off.schemes lacks 'rk4', which the"),
        (lambda c: c["structures"]["schemes"].remove("gauss4"), "structures.schemes lacks 'gauss4', which the"),
        (lambda c: c["agreement"].update(tolerances=[1e-4, 1e-8]), "agreement.tolerances lacks '1e-09', which the"),
        (
            lambda c: c["structure_history"]["stiff_soft"].update(schemes=["bathe"]),
            "structure_history.stiff_soft.schemes lacks 'average_acceleration', which the",
        ),
        (lambda c: c["work_precision"]["solvers"].update(periods=[1]), "work_precision.solvers.periods lacks 100"),
        (
            lambda c: c["work_precision"]["solvers"].update(longest=0),
            "work_precision.solvers.longest: 0 is less than or",
        ),
        (lambda c: c["phase_portrait"].update(soft=c["phase_portrait"]["softening"]), "there is no problem 'soft'"),
    ],
)
def test_mistakes_get_a_sentence(config, change, sentence):
    change(config)
    with pytest.raises((ValueError, KeyError)) as caught:
        check(config)
    assert sentence in str(caught.value)
