"""The configuration of the pipeline, checked before any work starts."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import yaml

from study.analysis.comparison import MEASURES
from study.analysis.effective_equation import effective_coefficient
from study.problem.named import printed_periods, problems, time_scales
from study.registry import Registry, did_you_mean
from study.scheme.base import OneStep
from study.scheme.named import schemes

SCHEMA = Path(__file__).parent.parent / "config" / "schema.yaml"

_REGISTRIES: dict[str, Registry] = {
    "problem": problems,
    "problems": problems,
    "scheme": schemes,
    "schemes": schemes,
}

#: Lengths of runs, in time_scales, that figures and tables of the accuracy show.
_SHOWN_PERIODS = (1, 3, 100)

#: The sections whose products the manuscript compares with the paper, which has these schemes and problems.
_OF_THE_PAPER = ("atlas", "energy_error", "cpu_time", "large_steps", "sensitivity", "spectral", "accuracy")

_PAPER_SCHEMES = list(schemes)[:7]

_PAPER_PROBLEMS = ("hardening", "softening")

_PAPER_STEPS = (15, 20, 25, 50, 100, 200, 1000)

#: The verdicts are on amplitudes of the maps within this factor of the paper's.
_VERDICTS_WITHIN = 3

#: Schemes that a reader can tell apart in one panel of a figure.
_CURVES = 7


#: YAML tells 15 from 15.0, and so does a count.
_Validator = jsonschema.validators.extend(
    jsonschema.Draft202012Validator,
    type_checker=jsonschema.Draft202012Validator.TYPE_CHECKER.redefine(
        "integer", lambda _, value: isinstance(value, int) and not isinstance(value, bool)
    ),
)


def _sentence(error: jsonschema.ValidationError) -> str:
    place = ".".join(map(str, error.absolute_path)) or "the configuration"
    if error.validator == "additionalProperties":
        known: dict = error.schema["properties"]  # type: ignore[index, assignment]
        unknown = next(key for key in error.instance if key not in known)  # type: ignore[union-attr]
        return f"{place} has no key '{unknown}'; {did_you_mean(unknown, known)}"
    return f"{place}: {error.message}."


def complete(config: dict[str, Any]) -> dict[str, Any]:
    """The configuration with ``schemes: all`` written out, as every registered scheme."""
    return {
        key: complete(value)
        if isinstance(value, dict)
        else list(schemes)
        if (key, value) == ("schemes", "all")
        else value
        for key, value in config.items()
    }


def _check_names(section: dict[str, Any], place: str) -> None:
    """Look up every name of a problem or a scheme, however deep it stands."""
    for key, value in section.items():
        if isinstance(value, dict):
            _check_names(value, f"{place}{key}.")
        elif key in _REGISTRIES:
            for name in [value] if isinstance(value, str) else value:
                try:
                    _REGISTRIES[key].resolve(name)
                except KeyError as error:
                    raise ValueError(f"{place}{key}: {error}") from None
                if name in time_scales and "structure" not in place:
                    known = ", ".join(printed_periods)
                    raise ValueError(f"{place}{key}: '{name}' is a structure; give one of {known}.")


def _numbers(section: Any, place: str) -> Iterator[tuple[str, float]]:
    """Every number of a configuration with its place."""
    entries = section.items() if isinstance(section, dict) else enumerate(section) if isinstance(section, list) else ()
    for key, value in entries:
        if isinstance(value, float | int):
            yield f"{place}{key}", value
        yield from _numbers(value, f"{place}{key}.")


def _check_contained(config: dict) -> None:
    """What is drawn from another dataset must be in it."""
    accuracy, schemes, solvers = (
        config["accuracy"],
        config["work_precision"]["schemes"],
        config["work_precision"]["solvers"],
    )
    answer = config["recommendation"]
    for place, wanted, there in (
        ("work_precision.schemes.problems", schemes["problems"], accuracy["problems"]),
        ("work_precision.schemes.schemes", schemes["schemes"], accuracy["schemes"]),
        ("work_precision.schemes.steps_per_period", schemes["steps_per_period"], accuracy["steps_per_period"]),
        ("work_precision.solvers.problems", solvers["problems"], schemes["problems"]),
        ("work_precision.solvers.steps_per_period", solvers["steps_per_period"], schemes["steps_per_period"]),
        ("work_precision.solvers.periods", solvers["periods"], accuracy["periods"]),
        ("recommendation.problems", answer["problems"], schemes["problems"]),
        ("recommendation.measures", answer["measures"], MEASURES),
        ("recommendation.periods", answer["periods"], accuracy["periods"]),
    ):
        strange = [one for one in wanted if one not in there]
        if strange:
            raise ValueError(f"{place}: there is no {strange[0]} among {', '.join(map(str, there))}.")
    if 100 not in solvers["periods"]:
        raise ValueError("work_precision.solvers.periods lacks 100, which the figures need.")


def _check_structures(config: dict) -> None:
    """Structures by their names, with samples at whole steps, and what the figures draw among them."""
    structures = config["structures"]
    names = [one["problem"] for one in structures["lengths"]]
    for name in names:
        try:
            problems.resolve(name)
        except KeyError as error:
            raise ValueError(f"structures.lengths: {error}") from None
        if name not in time_scales:
            raise ValueError(f"structures.lengths: '{name}' is none of the structures {', '.join(time_scales)}.")
        if names.count(name) > 1:
            raise ValueError(f"structures.lengths has '{name}' twice.")
    for steps in structures["steps_per_period"]:
        if steps % structures["samples_per_period"]:
            raise ValueError(
                f"structures.steps_per_period: {steps} is no multiple of samples_per_period, "
                f"{structures['samples_per_period']}."
            )
    histories = config["structure_history"]
    keeping = ["implicit_midpoint", "energy_momentum"]
    _check_needed(
        ("structures.lengths", names, ["stiff_soft", "fpu_chain", "elastic_pendulum"]),
        ("structures.schemes", structures["schemes"], [*_PAPER_SCHEMES, *keeping, "gauss4"]),
        ("structures.steps_per_period", structures["steps_per_period"], [80]),
        ("structure_history.stiff_soft.schemes", histories["stiff_soft"]["schemes"], ["average_acceleration", "bathe"]),
        (
            "structure_history.long_times.schemes",
            histories["long_times"]["schemes"],
            ["central_difference", *keeping, "bathe"],
        ),
    )
    for name, history in config["structure_history"].items():
        place = f"structure_history.{name}"
        if history["problem"] not in names:
            raise ValueError(f"{place}: there is no reference of '{history['problem']}'; add it to structures.lengths.")
        if round(history["periods"] * history["steps_per_period"]) % history["every"]:
            raise ValueError(f"{place}: every, {history['every']}, does not divide the number of steps.")


def _check_long_times(config: dict) -> None:
    """Sums that can be compensated, lengths that a law of growth can be fitted to, and what the manuscript names."""
    section = config["long_times"]
    for name in section["schemes"]:
        if not isinstance(schemes[name], OneStep):
            raise ValueError(f"long_times.schemes: the sums of '{name}' cannot be compensated; give one-step schemes.")
    for name in ("central_difference", "energy_momentum", "yoshida4"):
        if name not in section["schemes"]:
            raise ValueError(f"long_times.schemes lacks '{name}', which the manuscript needs.")
    if section["problem"] not in config["references"]["problems"]:
        raise ValueError(f"long_times.problem: there is no '{section['problem']}' among references.problems.")
    lengths = section["periods"]
    if lengths != sorted(lengths):
        raise ValueError(f"long_times.periods must rise, not {lengths}.")
    if sum(length >= lengths[-1] / 100 for length in lengths) < 3:
        raise ValueError("long_times.periods: a law of growth takes three lengths within the last two decades.")


def _check_stability(config: dict) -> None:
    """What the maps and the reasons behind them need of each other, and the manuscript of them."""
    atlas, robustness, why = config["atlas"], config["robustness"], config["stability"]
    if atlas["tiles"] > atlas["amplitudes"]["count"]:
        raise ValueError(f"atlas.tiles: there are more of them, {atlas['tiles']}, than amplitudes.")
    if 10 ** atlas["dt_over_period"]["last"] > atlas["periods"]:
        raise ValueError(f"atlas.dt_over_period: a step is longer than the {atlas['periods']} periods of the run.")
    for name in robustness["problems"]:
        if name not in atlas["problems"]:
            raise ValueError(f"robustness.problems: '{name}' is none of atlas.problems, whose amplitudes it takes.")
    if why["bifurcation"]["shown"] > why["bifurcation"]["steps"]:
        raise ValueError(f"stability.bifurcation: shown, {why['bifurcation']['shown']}, are more than the steps.")
    for name in why["roots"]["schemes"]:
        try:
            effective_coefficient(schemes[name])
        except ValueError as error:
            raise ValueError(f"stability.roots.schemes: {error}") from None
    exponents = np.linspace(*(atlas["amplitudes"][key] for key in ("first", "last", "count")))
    if not np.any(np.abs(exponents) <= np.log10(_VERDICTS_WITHIN)):
        raise ValueError(
            f"atlas.amplitudes has none within a factor of {_VERDICTS_WITHIN} of the paper's, as verdicts need."
        )
    if why["roots"]["paper_dt"] != 2.5:
        raise ValueError(f"stability.roots.paper_dt: that of the paper is 2.5, not {why['roots']['paper_dt']}.")
    for one in why["structures"]["lengths"]:
        if one["periods"] * min(why["structures"]["steps_per_period"]) < 2:
            raise ValueError(f"stability.structures.lengths: {one['periods']} periods are less than two steps.")
    if 1 not in why["structures"]["excitations"]:
        raise ValueError("stability.structures.excitations lacks 1, the structure as it is.")
    lengths = [one["problem"] for one in why["structures"]["lengths"]]
    for name in lengths:
        if lengths.count(name) > 1:
            raise ValueError(f"stability.structures.lengths has '{name}' twice.")
        if name not in time_scales:
            raise ValueError(
                f"stability.structures.lengths: '{name}' is none of the structures {', '.join(time_scales)}."
            )
    if not why["bifurcation"]["dt"]["first"] < why["roots"]["paper_dt"] < why["bifurcation"]["dt"]["last"]:
        raise ValueError("stability.bifurcation.dt leaves out 2.5, the step size of the paper.")
    if 0.0 not in config["spectral"]["damping_ratios"]:
        raise ValueError("spectral.damping_ratios lacks 0.0, whose stability limit the maps show.")
    _check_needed(
        ("spectral.schemes", config["spectral"]["schemes"], atlas["schemes"]),
        ("atlas.problems", atlas["problems"], ["hardening", "softening", "double_well"]),
        ("robustness.problems", robustness["problems"], ["hardening", "softening", "double_well"]),
        ("robustness.schemes", robustness["schemes"], ["average_acceleration"]),
        ("stability.roots.schemes", why["roots"]["schemes"], ["average_acceleration", "wilson_theta", "houbolt"]),
        ("stability.structures.lengths", lengths, ["pendulum", "duffing_chaotic"]),
        ("stability.structures.schemes", why["structures"]["schemes"], ["average_acceleration", "central_difference"]),
    )


def _check_needed(*cases: tuple[str, Sequence, Sequence]) -> None:
    """Refuse a place that lacks what must be in it; each case is the place, what is there and what must be."""
    for place, there, needed in cases:
        missing = [one for one in needed if one not in there]
        if missing:
            raise ValueError(f"{place} lacks '{missing[0]}', which the manuscript and its ledger need.")


def _check_panels(config: dict) -> None:
    """As many schemes as figures can show."""
    sections = {key: config[key] for key in ("energy_error", "round_off", "long_times")}
    sections |= {f"stability.{key}": config["stability"][key] for key in ("roots", "structures")}
    for several in ("phase_portrait", "structure_history"):
        sections |= {f"{several}.{name}": section for name, section in config[several].items()}
    for place, section in sections.items():
        count = len(section["schemes"])
        if count > _CURVES:
            raise ValueError(f"{place}.schemes: {count} are more than the {_CURVES} curves of a panel of its figure.")
    if set(config["atlas"]["schemes"]) <= set(_PAPER_SCHEMES):
        raise ValueError("atlas.schemes has none but those of the paper; a figure shows the others, give one at least.")


def _check_values(config: dict) -> None:
    """What a schema cannot say: finite numbers, at least one step, ranges in order, what the manuscript needs."""
    for place, value in _numbers(config, ""):
        if not math.isfinite(value):
            raise ValueError(f"{place} must be finite, not {value}.")
    for name, portrait in {**config["phase_portrait"], "sensitivity": config["sensitivity"]}.items():
        if portrait["duration"] < portrait["dt"]:
            raise ValueError(f"{name}: a duration of {portrait['duration']} is less than one step of {portrait['dt']}.")
    large = config["large_steps"]
    if max(large["dt_over_period"]) > large["periods"]:
        raise ValueError(
            f"large_steps.dt_over_period: a step is longer than the {large['periods']} periods of the run."
        )
    for place, span in (
        ("energy_drift.steps_per_period", config["energy_drift"]["steps_per_period"]),
        ("spectral.exponents", config["spectral"]["exponents"]),
        ("atlas.amplitudes", config["atlas"]["amplitudes"]),
        ("atlas.dt_over_period", config["atlas"]["dt_over_period"]),
        ("stability.roots.dt", config["stability"]["roots"]["dt"]),
        ("stability.roots.predictor", config["stability"]["roots"]["predictor"]),
        ("stability.numerical_map.u0", config["stability"]["numerical_map"]["u0"]),
        ("stability.bifurcation.dt", config["stability"]["bifurcation"]["dt"]),
    ):
        if span["first"] >= span["last"]:
            raise ValueError(f"{place}: first, {span['first']}, must be less than last, {span['last']}.")
    missing_length = [length for length in _SHOWN_PERIODS if length not in config["accuracy"]["periods"]]
    if missing_length:
        raise ValueError(f"accuracy.periods lacks {missing_length[0]}, which the manuscript and its tables need.")
    for place, section in (
        ("agreement", config["agreement"]),
        ("work_precision.solvers", config["work_precision"]["solvers"]),
    ):
        if section["tolerances"] != sorted(section["tolerances"], reverse=True):
            raise ValueError(f"{place}.tolerances must fall, not {section['tolerances']}.")
    _check_contained(config)
    _check_structures(config)
    _check_stability(config)
    _check_long_times(config)
    _check_panels(config)
    _check_told(config)


def _check_told(config: dict) -> None:
    """What the manuscript and its ledger tell of by name."""
    portraits = {f"phase_portrait.{name}": portrait for name, portrait in config["phase_portrait"].items()}
    of_the_paper = {key: config[key] for key in _OF_THE_PAPER}
    for place, section in {**of_the_paper, **portraits}.items():
        for key, needed in (("schemes", _PAPER_SCHEMES), ("problems", _PAPER_PROBLEMS)):
            if key in section:
                _check_needed((f"{place}.{key}", section[key], needed))
    accuracy, work, answer = config["accuracy"], config["work_precision"], config["recommendation"]
    _check_needed(
        ("agreement.tolerances", config["agreement"]["tolerances"], [1e-9]),
        ("energy_error.steps_per_period", config["energy_error"]["steps_per_period"], _PAPER_STEPS),
        ("houbolt_start.steps_per_period", config["houbolt_start"]["steps_per_period"], _PAPER_STEPS),
        ("accuracy.schemes", accuracy["schemes"], ["bathe", "energy_momentum"]),
        ("accuracy.steps_per_period", accuracy["steps_per_period"], [64]),
        ("work_precision.schemes.schemes", work["schemes"]["schemes"], ["average_acceleration", "rk4"]),
        ("work_precision.schemes.problems", work["schemes"]["problems"], ["hardening"]),
        ("work_precision.solvers.problems", work["solvers"]["problems"], ["hardening"]),
        ("recommendation.problems", answer["problems"], ["hardening"]),
        ("recommendation.measures", answer["measures"], ["max_trajectory_error"]),
        ("round_off.schemes", config["round_off"]["schemes"], ["rk4"]),
        ("large_steps.problems", config["large_steps"]["problems"], list(printed_periods)),
        ("spectral.schemes", config["spectral"]["schemes"], ["generalized_alpha"]),
    )
    drift, why, histories = config["energy_drift"], config["stability"], config["structure_history"]
    for place, there, told in (
        ("energy_drift.problem", drift["problem"], "softening"),
        ("energy_drift.scheme", drift["scheme"], "rk4"),
        ("sensitivity.problem", config["sensitivity"]["problem"], "double_well"),
        ("structure_history.stiff_soft.problem", histories["stiff_soft"]["problem"], "stiff_soft"),
        ("structure_history.energy_exchange.problem", histories["energy_exchange"]["problem"], "fpu_chain"),
        ("structure_history.long_times.problem", histories["long_times"]["problem"], "fpu_chain"),
        ("stability.roots.problem", why["roots"]["problem"], "double_well"),
        ("stability.numerical_map.problem", why["numerical_map"]["problem"], "double_well"),
        ("stability.bifurcation.problem", why["bifurcation"]["problem"], "double_well"),
        ("stability.bifurcation.scheme", why["bifurcation"]["scheme"], "average_acceleration"),
    ):
        if there != told:
            raise ValueError(f"{place}: the manuscript tells of '{told}', not of '{there}'.")
    if not drift["steps_per_period"]["first"] <= 20 < 25 <= drift["steps_per_period"]["last"]:
        raise ValueError("energy_drift.steps_per_period leaves out 20 or 25, which the manuscript explains.")
    if max(config["large_steps"]["dt_over_period"]) <= 0.2:
        raise ValueError("large_steps.dt_over_period has none above 0.2, of which the ledger decides a claim.")
    if config["robustness"]["periods"] != sorted(config["robustness"]["periods"]):
        raise ValueError(f"robustness.periods must rise, not {config['robustness']['periods']}.")


def check(config: dict) -> None:
    """Refuse a configuration that cannot be run, with one sentence that names the key.

    Raises
    ------
    ValueError
        If a key is unknown, missing or of the wrong type, or a problem or scheme is unknown.
    """
    schema = yaml.safe_load(SCHEMA.read_text())
    error = jsonschema.exceptions.best_match(_Validator(schema).iter_errors(config))
    if error is not None:
        raise ValueError(_sentence(error))
    config = complete(config)
    _check_names(config, "")
    _check_values(config)
    for name in config["phase_portrait"]:
        problems.resolve(name)
