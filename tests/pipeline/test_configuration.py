"""Invalid configurations are refused before any work, with one sentence that names the key."""

import copy
import math
import re
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from snakemake.utils import update_config

import study
from paper import products
from pipeline import configuration, keys
from pipeline.datasets import steps_of
from pipeline.sources import Sources
from study.declaration.experiment import discover

PROJECT = Path(__file__).parents[2]
SOURCES = Sources(PROJECT, "study", "reference", "pipeline")
EXPERIMENTS = discover()
PRODUCTS = products.discover()


def _shipped(name: str) -> dict:
    """The configuration study.yaml, overridden by another file as Snakemake does."""
    settings = yaml.safe_load((PROJECT / "config" / "study.yaml").read_text())
    update_config(settings, yaml.safe_load((PROJECT / "config" / name).read_text()))
    return settings


SHIPPED = {name: _shipped(name) for name in ("study.yaml", "full.yaml")}


@pytest.fixture(params=SHIPPED)
def config(request) -> dict:
    """Every shipped configuration in turn."""
    return copy.deepcopy(SHIPPED[request.param])


def _check(config):
    return configuration.check(EXPERIMENTS, config)


def test_what_is_shipped_is_accepted(config):
    assert _check(config)["energy_error"] == config["energy_error"]


def test_a_users_scheme_with_an_invalid_order_is_refused(config, tmp_path):
    heun = (PROJECT / "examples" / "scheme.py").read_text()
    (tmp_path / "scheme.py").write_text(heun.replace("order = 2", 'order = "two"').replace("heun", "unfit"))
    config["own_schemes"] = [f"{tmp_path}/scheme.py:unfit"]
    with pytest.raises(
        ValueError, match=r"own_schemes: order of Heun must be a whole number of at least 1, not 'two'\."
    ):
        _check(config)


def test_all_schemes_are_written_out(config):
    config["accuracy"]["schemes"] = "all"
    assert _check(config)["accuracy"]["schemes"] == list(study.schemes)


def test_the_schema_has_every_section():
    schema = configuration.model_of(tuple(EXPERIMENTS)).model_json_schema()
    assert set(schema["properties"]) == set(SHIPPED["study.yaml"]) and schema["additionalProperties"] is False
    assert set(schema["properties"]) - set(schema["required"]) == {"own_schemes"}


def test_every_dataset_is_made_once(config):
    names = configuration.datasets_of(EXPERIMENTS, _check(config))
    assert len(names) == len(set(names))


@pytest.mark.parametrize("whole", [{}, [], None, "x", 3, [{}]])
def test_an_invalid_configuration_is_refused(whole):
    with pytest.raises(ValueError, match="^the configuration (must be a mapping|lacks '\\w+')"):
        _check(whole)


@pytest.mark.parametrize(
    "change, sentence",
    [
        (lambda c: c.update(enery_error={}), "the configuration has no key 'enery_error'; did you mean 'energy_error'"),
        (lambda c: c.update({True: 1}), "the key True of the configuration must be a string"),
        (lambda c: c["phase_portrait"].update({1: {}}), "the key phase_portrait.1 of the configuration must be"),
        (lambda c: c["cpu_time"].update(repeat=3), "cpu_time has no key 'repeat'; did you mean 'repeats'?"),
        (lambda c: c["cpu_time"].update(repeats="many"), "cpu_time.repeats must be a whole number, not 'many'."),
        (lambda c: c["cpu_time"].update(repeats=15.0), "cpu_time.repeats must be a whole number, not 15.0."),
        (lambda c: c["cpu_time"].update(repeats=True), "cpu_time.repeats must be a whole number, not True."),
        (lambda c: c["work_precision"].update(solvers=None), "work_precision.solvers must be a mapping of keys, not"),
        (lambda c: c["energy_error"].update(periods=0), "energy_error.periods must be greater than or equal to 1"),
        (lambda c: c["energy_error"].pop("periods") and None, "the configuration lacks 'energy_error.periods'."),
        (lambda c: c["sensitivity"].update(dt=math.nan), "sensitivity.dt must be less than or equal to 1000000000,"),
        (lambda c: c["sensitivity"].update(dt=0), "sensitivity.dt must be greater than or equal to"),
        (lambda c: c["sensitivity"].update(dt=1e6), "sensitivity.duration, 2500.0, is less than"),
        (lambda c: c["phase_portrait"]["hardening"].update(dt=75), "phase_portrait.hardening.duration, 15.0, is"),
        (lambda c: c["energy_drift"]["steps_per_period"].update(first=50), "first, 50.0, must be less than last"),
        (lambda c: c["large_steps"].update(step_size_over_period=[0.1, 300.0]), "step_size_over_period: a step is"),
        (lambda c: c["cpu_time"].update(schemes=["rk4"]), "cpu_time.schemes lacks 'average_acceleration', with which"),
        (
            lambda c: c["structures"]["lengths"].append({"problem": "fpu_chian", "periods": 1}),
            "there is no structure 'fpu_chian'; did you mean 'fpu_chain'?",
        ),
        (
            lambda c: c["structures"]["lengths"].append({"problem": "fpu_chain", "period": 1}),
            "has no key 'period'; did you mean 'periods'?",
        ),
        (lambda c: c["structures"]["lengths"].append(c["structures"]["lengths"][0]), "is listed twice."),
        (lambda c: c["structures"]["lengths"][0].update(periods=0.001), "not a whole number of samples, 10 in each."),
        (lambda c: c["structures"].update(steps_per_period=[25]), "25 is not a multiple of samples_per_period, 10."),
        (lambda c: c["large_steps"].update(problems=["pendulum"]), "large_steps.problems.0: there is no spring"),
        (lambda c: c["atlas"].update(tiles=1000), "atlas.tiles: 1000 tiles are more than the"),
        (lambda c: c["atlas"]["step_size_over_period"].update(last=5), "step_size_over_period: a step is longer"),
        (lambda c: c["atlas"]["amplitudes"].update(first=2), "atlas.amplitudes: first, 2.0, must be less than last,"),
        (lambda c: c["atlas"]["amplitudes"].update(count=63 * 10**12), "atlas.amplitudes.count must be less than or"),
        (lambda c: c["atlas"]["amplitudes"].update(first=-400), "atlas.amplitudes.first must be greater than or equal"),
        (lambda c: c["stability"]["bifurcation"].update(shown=10**5), "stability.bifurcation.shown must be at most"),
        (lambda c: c["stability"]["roots"]["schemes"].append("bathe"), "a step of 'Bathe' is not one effective"),
        (lambda c: c["stability"]["roots"]["schemes"].append("bathed"), "there is no scheme 'bathed'; did you mean"),
        (lambda c: c["stability"]["roots"].update(steps=4 * 10**14), "stability.roots.steps must be less than or"),
        (lambda c: c["energy_drift"]["steps_per_period"].update(step=1e-12), "step must be greater than or equal to"),
        (lambda c: c["spectral"]["exponents"].update(first=-3000), "spectral.exponents.first must be greater than"),
        (lambda c: c["spectral"].update(damping_ratios=[1.0]), "spectral.damping_ratios.0 must be less than 1, not"),
        (lambda c: c["long_times"].update(periods=[10**7], runs=900), "a law of growth needs three lengths"),
        (lambda c: c["long_times"].update(periods=[10, 3, 30]), "long_times.periods: must be in ascending order"),
        (lambda c: c["long_times"].update(schemes=["park"]), "there is no one-step scheme 'park'"),
        (lambda c: c["references"].update(problems=["hardening"]), "reads 'reference/softening', a dataset that this"),
        (lambda c: c["references"].update(problems=["hard"]), "references.problems.0: there is no spring 'hard';"),
        (lambda c: c["references"].update(steps_per_period=[8]), "among references.steps_per_period, 8."),
        (lambda c: c["work_precision"]["solvers"].update(problems=["double_well"] * 2), "is listed twice."),
        (lambda c: c["work_precision"]["schemes"].update(steps_per_period=[9]), "steps_per_period: there is no"),
        (lambda c: c["work_precision"]["solvers"].update(tolerances=[1e-14]), "tolerances must be at least 2.2e-14,"),
        (lambda c: c["work_precision"]["solvers"].update(periods=[1]), "work_precision.solvers.periods lacks 100,"),
        (lambda c: c["work_precision"]["solvers"].update(longest=0), "solvers.longest must be greater than 0, not 0."),
        (lambda c: c["agreement"].update(tolerances=[1e-9, 1e-4]), "tolerances: must be in descending order"),
        (lambda c: c["runs"].update(allowed_errors=[0.01, 0.1]), "allowed_errors: must be in descending order"),
        (lambda c: c["assess"]["driven"].update(periods=1), "assess.driven.periods: duration already gives"),
        (lambda c: c["accuracy"].update(periods=[100, 1, 3]), "periods: must be in ascending order, not [100, 1"),
        (lambda c: c["accuracy"].update(schemes=[]), "accuracy.schemes must have at least 1 items, not 0."),
        (lambda c: c["cpu_time"].update(repeats=10**7), "cpu_time.repeats must be less than or equal to 1000, not"),
        (lambda c: c["long_times"].update(runs=9000), "long_times.runs must be less than or equal to 1000, not 9000."),
        (lambda c: c["agreement"].update(tolerances=[0.9, 1e-9]), "tolerances.0 must be less than or equal to 0.1"),
        (lambda c: c["structure_history"].update({"": {}}), "structure_history.'': '' must be a name of small letters"),
        (lambda c: c["structure_history"].update({"\n": {}}), "structure_history.'\\n': "),
        (lambda c: c["accuracy"].update(schemes="most"), "accuracy.schemes must be a list, or the word all, not"),
        (lambda c: c["structure_history"]["stiff_soft"].update(every=7), "every, 7, does not divide the number of"),
        (lambda c: c["structure_history"].update({"../x": c["structure_history"]["stiff_soft"]}), "'../x' must be a"),
        (lambda c: c.update(own_schemes="heun"), "own_schemes must be a list of FILE.py:NAME, not 'heun'."),
        (lambda c: c.update(own_schemes=["heun"]), "own_schemes: 'heun' must name a file and a study.Scheme in it,"),
        (lambda c: c.update(own_schemes=["no.py:heun"]), "own_schemes: there is no file 'no.py'."),
        (lambda c: c.update(own_schemes=["examples/scheme.py:hein"]), "has no 'hein'; did you mean 'heun'?"),
        (lambda c: c["accuracy"].update(schemes=["newmark"]), "write 'average_acceleration', the name in the"),
        (lambda c: c["large_steps"].update(problems=["Softening-Large"]), "write 'softening_large', the name in"),
        (lambda c: c["structures"]["lengths"][0].update(problem="Pendulum"), "problem: write 'pendulum', the name"),
        (lambda c: c["long_times"].update(problem="double_well"), "the motion of 'double_well' does not cross zero"),
        (lambda c: c["spectral"].update(damping_ratios=[0.0, 0.0]), "damping_ratios: 0.0 is listed twice."),
        (lambda c: c["energy_drift"].update(oscillations=101), "oscillations must be less than periods, 100, not 101."),
        (lambda c: c["sensitivity"]["schemes"].append("heum"), "there is no scheme 'heum'"),
        (lambda c: c["phase_portrait"].update(soft=c["phase_portrait"]["softening"]), "there is no spring 'soft';"),
    ],
)  # fmt: skip
def test_mistakes_get_a_sentence(config, change, sentence):
    change(config)
    with pytest.raises(ValueError) as caught:
        _check(config)
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    "content, sentence",
    [
        (None, "record_error.folder: there is no folder"),
        ("notes", "has no columns of numbers"),
        ("0 1\n0.01 2", "does not state its unit"),
        ("t (s), a (m/s2)\n0, 1\n0.1, 2", "'record' are 0.1 s apart, and must be at most 0.4 of the shortest"),
    ],
)
def test_records_of_a_folder_are_read_before_any_work(config, tmp_path, content, sentence):
    folder = tmp_path / "records"
    config["record_error"]["folder"] = str(folder)
    if content is not None:
        folder.mkdir()
        (folder / "record.txt").write_text(content)
    with pytest.raises(ValueError, match=r"^record_error\.folder: ") as caught:
        _check(config)
    assert sentence in str(caught.value) and len(str(caught.value).splitlines()) == 1


#: Strategy for values that a user may put into a configuration by mistake.
_ODD = st.one_of(
    st.sampled_from([None, True, -1, 0, 1, 7, 10**7, 10**30, 1e-12, 1e300, math.nan, math.inf, "", "all", "hardening"]),
    st.sampled_from(["rk4", "houbolt", "bdf2", "../up", "$(touch x)", [], {}, [1, 1], [[]], ["rk4", "rk4"], {1: 2}]),
    st.integers(-(10**6), 10**6),
    st.floats(),
    st.text(max_size=5),
    st.lists(st.integers(1, 10**5), max_size=4),
)


def _places(section, above=()):
    """Yield the path of keys to every value of a configuration."""
    entries = section.items() if isinstance(section, dict) else enumerate(section) if isinstance(section, list) else ()
    for key, value in entries:
        yield (*above, key)
        yield from _places(value, (*above, key))


@st.composite
def _mutated(draw):
    config = copy.deepcopy(SHIPPED[draw(st.sampled_from(sorted(SHIPPED)))])
    for _ in range(draw(st.integers(1, 3))):
        places = list(_places(config))
        *above, last = places[draw(st.integers(0, len(places) - 1))]
        section = config
        for key in above:
            section = section[key]
        match draw(st.sampled_from(["put", "put", "put", "scale", "remove", "rename", "again"])):
            case "put":
                section[last] = copy.deepcopy(draw(_ODD))
            case "scale" if isinstance(section[last], int | float):
                section[last] *= draw(st.sampled_from([-1, 0.5, 2, 10, 1e4]))
            case "remove":
                del section[last]
            case "rename" if isinstance(section, dict):
                section[draw(st.one_of(st.text(max_size=8), st.integers(), st.none()))] = section.pop(last)
            case "again" if isinstance(section, list):
                section.append(section[last])
        if not list(_places(config)):
            break
    return config


@settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
@given(_mutated(), st.integers(1, 10))
def test_any_configuration_is_accepted_or_refused_in_one_sentence(config, chance):
    """A wrong value that no check expects, and that ends with a traceback or names a file outside the results."""
    before = copy.deepcopy(config)
    try:
        whole = _check(config)
    except ValueError as error:
        sentence = str(error)
        assert sentence and "\n" not in sentence and sentence.endswith((".", "?")), sentence
        return
    finally:
        assert repr(config) == repr(before)
    try:
        products.check(PRODUCTS, whole)
    except ValueError as error:
        assert re.fullmatch(r"\S[^\n]*[.?]", str(error)), error
        return
    # an accepted configuration names no file outside the results, and can be planned; the plan is slow, so that it is
    # tested for a random tenth of the configurations
    names = configuration.datasets_of(EXPERIMENTS, whole)
    assert len(names) == len(set(names)) and not any(".." in name or name.startswith("/") for name in names)
    if chance == 1:
        assert all(step.jobs for step in steps_of(EXPERIMENTS, whole, SOURCES))


def test_the_page_of_the_keys_is_current():
    """The command ``python -m pipeline.keys > config/README.md`` writes the current page."""
    assert keys.page() == (PROJECT / "config" / "README.md").read_text()


def test_the_page_of_the_keys_has_every_key_of_the_configurations(config):
    listed = {re.sub(r"\[\]", "", key) for key in re.findall(r"^\| `([\w.\[\]]+)` \|", keys.page(), re.MULTILINE)}
    patterns = [re.compile(key.replace("NAME", r"\w+")) for key in listed]

    def keys_of(value, place):
        if isinstance(value, dict):
            for key, entry in value.items():
                yield from keys_of(entry, f"{place}.{key}".lstrip("."))
        else:
            yield place

    unknown = [key for key in keys_of(config, "") if not any(pattern.fullmatch(key) for pattern in patterns)]
    assert len(listed) > 50 and unknown == []
