"""README, CONTRIBUTING and pages: their examples run, and their statements agree with the code and the results."""

import json
import os
import re
import subprocess
import sys
import unicodedata
from fractions import Fraction
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pandas as pd
import pytest
import yaml
from matplotlib.image import imread
from scipy.special import ellipj, ellipk

import study
from docs.decisions import by_model, frame
from paper import products
from paper.claims import ledger
from reference.experiments.record_error import record_error as motions_under_records
from reference.experiments.spectrum import spectrum as exact_peaks
from study.analysis.duration import round_up, step_exponent
from study.problem.inelastic import yielding_under_record
from study.runs.records import spectrum
from study.sizes import least_number
from study.words import up_to
from tests.snippets import blocks, run_examples

PROJECT = Path(__file__).parent.parent
README, CONTRIBUTING = ((PROJECT / name).read_text() for name in ("README.md", "CONTRIBUTING.md"))
PAGES = {name: (PROJECT / "docs" / "pages" / name).read_text() for name in ("design.md", "how_to/pipeline.md")}
ANSWERS = " ".join((PROJECT / "docs" / "pages" / "answers.md").read_text().split())
TEXTS = {"README.md": README, "CONTRIBUTING.md": CONTRIBUTING} | {f"docs/pages/{n}": text for n, text in PAGES.items()}


def test_the_examples_of_the_readme_print_what_follows_them(tmp_path, monkeypatch, capsys):
    """An example of the README that prints another answer than the one below it."""
    run_examples(README, "README.md", tmp_path, monkeypatch)
    printed = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    (stated,) = blocks(README, "text")
    assert printed == stated.splitlines()


def test_the_first_page_of_the_site_has_the_same_lines():
    page = (PROJECT / "docs" / "pages" / "index.md").read_text()
    assert blocks(page, "python") == blocks(README, "python")


def test_the_readme_has_few_words_before_the_first_command():
    assert len(README.partition("```sh")[0].split()) <= 150


def test_no_code_of_the_readme_scrolls_sideways():
    """A line that is wider than a page of 800 pixels on a host of code."""
    code = "\n".join(re.findall(r"^```\w+\n(.*?)^```", README, re.DOTALL | re.MULTILINE)).splitlines()
    assert len(code) > 10
    assert [line for line in code if len(line) > 88] == []


def _headings(text: str) -> set[str]:
    """Anchors of the headings of a text."""
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-") for heading in headings}


def test_the_links_of_the_readme_lead_to_files_and_headings():
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", README) if not link.startswith("https://doi.org/")]
    assert len(links) > 8
    for file, _, heading in (link.partition("#") for link in links):
        path = PROJECT / (file or "README.md")
        assert path.exists() and (not heading or heading in _headings(path.read_text())), (file, heading)


def test_the_texts_state_the_law_of_longer_durations():
    stated = {
        "½": ["central_difference", "average_acceleration", "fox_goodwin"],
        "⅔": ["hht_alpha", "generalized_alpha", "bathe", "noh_bathe"],
    }
    assert {*re.findall("[¼⅓½⅔]", ANSWERS.replace("≤ ½ max", ""))} == {*stated}
    words = " ".join(README.split())
    assert "a = ½ with central difference, average acceleration or Fox-Goodwin, and ⅔ with generalized-α" in words
    for fraction, names in stated.items():
        for scheme in (study.schemes[name] for name in names):
            assert step_exponent(scheme.order, scheme.order_of_loss) == pytest.approx(unicodedata.numeric(fraction))
    steps, longer = _stated(r"1,000 periods the (\d+) steps of central difference thus become ([\d,]+)\.")
    assert f"Central difference: {steps} steps" in README.replace("\u00a0", " ")
    assert steps * 10**0.5 <= longer < steps * 10**0.5 + 10


def test_the_answers_state_the_amplitudes():
    pattern = r"spring's period is ([\d.]+) times .* yield, and reaches ([\d.]+) times"
    ((slower, ductility),) = re.findall(pattern, ANSWERS)
    spring, yielding = study.problems["softening"], study.problems["yielding"]
    small = 2 * np.pi / np.sqrt(spring.stiffness_at(0.0).item())
    assert f"{study.step_bound(spring, 'central_difference').period.item() / small:.1f}" == slower
    assert np.isclose(yielding.damping, 2 * 0.02 * np.sqrt(yielding.stiffness_at(0.0)))
    article = (PROJECT / "paper" / "text" / "manuscript.typ").read_text()
    assert "(yielding oscillator: 2 % of critical damping)" in article
    motion = study.run(yielding, "rk4", dt=1e-3, steps=10_000)
    assert f"{np.abs(motion.u).max().item() / 0.1:.1f}" == ductility


def test_the_readme_states_the_steps_of_a_pendulum():
    """From its fastest point u = 2 arcsin(k sn(t, k)); the error over 100 periods, over the amplitude."""
    pattern = r"the (\d+) steps keep 1 % on a .* to (\d) rad, and up to ([\d.]+) rad it needs ([\d,]+), unless"
    (stated,) = re.findall(pattern, " ".join(README.split()))
    of_row, moderate, large, needed = (float(number.replace(",", "")) for number in stated)
    (slower,) = re.findall(r"pendulum whose period is ([\d.]+) times that of its small motions, three times", ANSWERS)
    assert f"Central difference: {of_row:g} steps" in README.replace("\u00a0", " ")
    for amplitude, steps, kept in ((moderate, of_row, True), (large, of_row, False), (large, needed, True)):
        k = np.sin(amplitude / 2)
        pendulum = study.Problem(jnp.sin, 0.0, 2 * k, potential=lambda u: 1 - jnp.cos(u))
        bound = study.step_bound(pendulum, "central_difference", 0.01, periods=100)
        period, step = bound.period.item(), bound.step_size.sel(quantity="displacement").item()
        ds = study.run(pendulum, "central_difference", dt=period / steps, steps=int(100 * steps))
        exact = 2 * np.arcsin(k * ellipj(ds.t.values, k**2)[0])
        assert (np.abs(ds.u - exact).max() <= 0.01 * amplitude) == kept == (period / step <= steps)
    assert f"{period / (2 * np.pi):.1f}" == slower
    assert round_up(period / step) == needed == pytest.approx(3 * of_row, rel=0.1)


def test_the_pages_state_what_cancels_over_the_shorter_run():
    """With u = 2 arcsin(k sn(t + T/4, k))."""
    page = " ".join((PROJECT / "docs" / "pages" / "how_to" / "choose.md").read_text().split())
    assert (
        "on a pendulum from rest at 2 rad, the coarsest step of generalized-α that keeps 1 % over 100 periods" in page
    )
    assert "leads to one with an error of 2 % over 1,000." in page
    k, steps = np.sin(1), 122
    period, errors = 4 * ellipk(k**2), []
    pendulum = study.Problem(jnp.sin, 2.0)
    for number, periods in ((steps, 100), (steps * 10 ** (2 / 3), 1000)):
        ds = study.run(pendulum, "generalized_alpha", dt=period / number, steps=int(periods * number))
        exact = 2 * np.arcsin(k * ellipj(ds.t.values + period / 4, k**2)[0])
        errors.append(np.abs(ds.u - exact).max().item() / 2)
    assert errors[0] < 0.01 and errors[1] == pytest.approx(0.02, rel=0.05)


def test_the_examples_of_steps_follow_from_the_table():
    words = " ".join(README.replace("\u00a0", " ").split())
    (of_frame,) = re.findall(r"\*\*Central difference: (\d+) ms, ωΔt = 0\.13", words)
    assert "every 10 ms: 10/3 ms, or, if an unknown has no mass, average acceleration with 2.5 ms, which has" in words
    assert 10 / 3 <= int(of_frame) < 10 / 2 and "`Newmark 0.5 0.08333333333333333` | 2.5 ms, ωΔt" in words
    ((steps, omega_step),) = re.findall(
        r"impact and contact \| \*\*Central difference: (\d+) steps, ωΔt = ([\d.]+)", words
    )
    assert f"T/{steps}, with T from bounce to bounce, and {omega_step} √(m/k)." in words
    (longer,) = re.findall(r"thus become ([\d,]+)\.", words)
    assert f"up to 2 rad to each side, over 1,000 of its periods T: T/{longer}." in words


def test_the_texts_state_how_limits_depend_on_damping():
    def limit(scheme: str, damping_ratio: float) -> float:
        return study.LinearTheory(scheme, np.linspace(0.01, 0.7, 100), damping_ratio).stability_limit()

    pattern = r"of Noh-Bathe falls with damping: to ([\d.]+) at 5 % of critical and ([\d.]+) at 50 %"
    (falls,) = re.findall(pattern, ANSWERS)
    assert [*falls] == [up_to(limit("noh_bathe", ratio)) for ratio in (0.05, 0.5)]
    for scheme in ("fox_goodwin", "central_difference"):
        assert limit(scheme, 0.5) == pytest.approx(study.schemes[scheme].stability_limit)
    assert "limit is 2 (√(1 + ξ²) − ξ)" in ANSWERS
    ratio = 0.3
    at_limit = 2 * (np.sqrt(1 + ratio**2) - ratio)
    # u and Δt u̇ at the half step: u̇ changes by −Δt (2ξ u̇ + u), then u by Δt u̇
    kick = np.array([[1, 0], [-(at_limit**2), 1 - 2 * ratio * at_limit]])
    step = np.array([[1, 1], [0, 1]]) @ kick
    assert np.abs(np.linalg.eigvals(step)).max() == pytest.approx(1)


def test_the_answers_state_the_law_of_the_energy():
    """The largest error of the energy over (ωΔt)² is ¼ and 1/6 for convex potentials."""
    (printed,) = re.findall(r"ωΔt = ([\d.]+) with central difference and ([\d.]+) with average acceleration", ANSWERS)
    for scheme, omega_step in zip(("central_difference", "average_acceleration"), printed, strict=True):
        bound = study.step_bound(study.Problem(potential=jnp.cosh, u0=1.0), scheme).convex_coefficient.item()
        assert float(omega_step) == pytest.approx(np.sqrt(0.01 / bound), abs=0.005)


@pytest.mark.parametrize(("scheme", "divisor"), [("central_difference", 24), ("average_acceleration", 12)])
def test_the_answers_state_the_error_at_resonance(scheme, divisor):
    """The whole motion at resonance, in closed form, against the formula to leading order."""
    assert f"(ωΔt)²/({divisor}ξ)" in ANSWERS
    ratio, dt = 0.05, 2 * np.pi / 100
    problem = study.Problem(
        force=lambda u: u, damping=2 * ratio, load=jnp.cos, u0=0.0, v0=1 / (2 * ratio)
    )  # u = sin(t)/(2ξ)
    ds = study.run(problem, scheme, dt=dt, steps=6000)
    error = np.abs(ds.u - np.sin(ds.t) / (2 * ratio)).max() * 2 * ratio
    assert error == pytest.approx(dt**2 / (divisor * ratio), rel=0.05)


#: Program that runs the files of CONTRIBUTING, and makes and prints their products.
_EXAMPLES = """
import json, sys, types
from pathlib import Path

files = json.loads(sys.argv[1])
modules = {}
for path, source in files.items():
    name = path.removesuffix(".py").replace("/", ".")
    modules[path] = sys.modules[name] = types.ModuleType(name)
    exec(compile(source, path, "exec"), vars(modules[path]))

import study
from paper.products import PRODUCTS, reader
from paper import products
from pipeline import configuration
from study.declaration.experiment import DECLARED

scheme, cubic = modules["study/scheme/implicit_euler.py"].implicit_euler, modules["study/problem/cubic.py"].cubic()
peak = modules["study/observer/peak.py"].Peak()
ds = study.run(cubic, scheme, dt=7.4163 / 1000, steps=1000, observe=["trajectory", peak])
assert ds.peak == 1 and ds.status == 0 and abs(ds.u[-1] - 1) < 0.1, ds

experiment = DECLARED["study.experiments.last_displacement", "last_displacement"]
options = json.loads(sys.argv[2])
configuration.check([experiment], options)
ds = experiment.function(**options["last_displacement"])
study.io.write(ds.assign_attrs(source=study.io.SOURCE), Path("last_displacement.nc"))
examples = [p for p in PRODUCTS.values() if p.module in {m.__name__ for m in modules.values()}]
assert sorted(p.kind for p in examples) == ["claim", "figure", "numbers", "table"], examples
for product in examples:
    print(product.kind, products.content_of(product, reader(Path("."))))
"""


def test_the_examples_of_contributing_run(tmp_path):
    """The examples run in a separate process, because their declarations would persist."""
    files = {block.split("\n")[0].removeprefix("# "): block for block in blocks(CONTRIBUTING, "python")}
    options = yaml.safe_load(next(block for block in blocks(CONTRIBUTING, "yaml") if "last_displacement" in block))
    environment = os.environ | {"PYTHONPATH": str(PROJECT), "MPLBACKEND": "agg"}
    command = [sys.executable, "-c", _EXAMPLES, json.dumps(files), json.dumps(options)]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]
    assert "numbers {'last_displacement': '" in done.stdout and "holds=True" in done.stdout


def _stated(pattern: str, text: str = README) -> list[int]:
    """Numbers in a text that match the groups of a pattern, which must occur once."""
    matches = re.findall(pattern, " ".join(text.split()))
    assert len(matches) == 1, f"the text states {pattern!r} {len(matches)} times"
    return [int(digits.replace(",", "")) for digits in (matches[0] if isinstance(matches[0], tuple) else matches)]


def _claims_of_the_paper() -> list[ledger.Claim]:
    products.discover(["claims"])
    return [claim for claim in ledger.CLAIMS if claim.section not in ledger.OURS]


def test_the_counts_of_the_readme_are_those_of_the_code():
    assert _stated(r"The paper makes (\d+) checkable claims") == [len(_claims_of_the_paper())]
    spectrum_options = yaml.safe_load((PROJECT / "config" / "study.yaml").read_text())["spectrum"]
    assert _stated(r"El Centro \(1940\) and (\d+) artificial ones", ANSWERS) == [spectrum_options["records"] - 1]
    assert "yield at less than a quarter of the elastic force" in ANSWERS
    assert max(spectrum_options["reductions"]) == 4


#: Name of the figure that the README shows.
PICTURE = "error_against_cost"
#: Largest mean difference of the pixels of two pictures, with values from 0 to 1, in their right part, which shows no
#: measured times.
PIXELS = 0.003


def check_the_results_of_the_readme(results: Path) -> None:
    """Compare the README's counts of cells with the results of a study."""
    numbers = json.loads((results / "numbers.json").read_text())
    (cells,) = _stated(r"tables of the paper hold (\d+) errors")
    (twice,) = _stated(r"and then to one, (\d+) of them agree")
    (once,) = _stated(r"if they were rounded once, (\d+) do")
    counts = [int(numbers[name]) for name in ("cells", "cells_rounded_twice", "cells_rounded_once")]
    assert counts == [cells, twice, once]


@pytest.mark.exhaustive
def test_the_step_for_a_period_of_a_frame_serves_up_to_the_next(monkeypatch):
    """The advice for periods that the study does not run, under all its records, elastic and yielding."""
    (stated,) = re.findall(r"the error within 1 % at ([\d., ]+) and ([\d.]+) s too", ANSWERS)
    between = [float(period) for period in re.findall(r"[\d.]+", " ".join(stated))]
    pattern = r"difference at ([\d.]+), ([\d.]+) and ([\d.]+) s: one of (\d+) runs at each errs by up to ([\d.]+) %"
    ((*critical, count, most),) = re.findall(pattern, ANSWERS)
    critical = [float(period) for period in critical]
    options = yaml.safe_load((PROJECT / "config" / "study.yaml").read_text())["spectrum"]
    tabled = options["periods"]
    shared = {key: options[key] for key in ("records", "reductions", "duration")}
    shared |= {"periods": sorted([*tabled, *between, *critical])}
    reference = exact_peaks(**shared)
    monkeypatch.setattr(study.io, "open_dataset", lambda name: reference)
    schemes = ["central_difference", "fox_goodwin", "average_acceleration"]
    ds, _ = spectrum(**shared, schemes=schemes, coarsest=0.02, finest=options["finest"], allowed_error=0.01)
    kept = ds.largest_step_size.sel(condition="practice").min(["record", "reduction"], skipna=False)
    advised = kept.sel(period=tabled).sel(period=shared["periods"], method="ffill").assign_coords(period=kept.period)
    serves = kept >= advised * (1 - 1e-9)
    assert serves.sel(period=between).all()
    assert serves.sel(period=critical).sum("period").to_series().to_dict() == dict(zip(schemes, (0, 3, 3), strict=True))
    step = advised.sel(scheme="central_difference", period=critical[0]).item()
    error = ds.peak_drift_error.sel(scheme="central_difference", period=critical).sel(step_size=step, method="nearest")
    assert ((error > 0.01).sum(["record", "reduction"]) == 1).all()
    assert error.size == 3 * int(count) and f"{100 * error.max().item():.2f}" == most
    assert f"which errs by up to {most} % just above 0.2 s." in " ".join(README.split())


@pytest.mark.exhaustive
def test_the_steps_of_a_frame_under_measured_records():
    """The exceptions that the answers name, elastic and with a quarter of the elastic strength."""
    pattern = r"needs (\S+) ms at ([\d.]+) s, (\S+) ms at ([\d.]+) s, (\S+) ms at (\d) s and (\S+) ms at (\d) s"
    (found,) = re.findall(pattern, " ".join(README.split()))
    sizes, periods = np.array([1e-3 * float(Fraction(size)) for size in found[::2]]), np.array(found[1::2], float)
    grounds, over = study.GroundMotion.measured(), {"period": np.repeat(periods, 2)}
    exact = motions_under_records([0.02], [0.5], [0.02], 1, duration=32.0, periods=periods, reduction=4)
    errors = np.zeros((len(grounds), len(periods)))
    for number, ground in enumerate(grounds):
        peaks = exact.peak_drift.values[number]
        steps = np.repeat(ground.dt / np.ceil(ground.dt / sizes - 1e-9), 2)
        runs = study.run(
            lambda period, strength, ground=ground: yielding_under_record(ground, period, strength),
            "central_difference",
            over=over | {"strength": np.stack([np.full(4, 1e9), exact.yield_force.values[number]], axis=1).ravel()},
            dt=steps,
            steps=np.ceil(ground.duration / steps - 1e-9).astype(int),
            observe="peak",
        )
        errors[number] = np.abs(runs.peak.values.reshape(peaks.shape) / peaks - 1).max(axis=1)
    near = np.array(["Waipawa" in ground.title for ground in grounds])
    assert len(grounds) == int(*re.findall(r"under (\d+) more measured records", ANSWERS)) + 1 and near.sum() == 2
    assert errors[:, :2].max() < 0.01 and errors[~near].max() < 0.01
    most = [f"{100 * error:.1f} %" for error in errors.max(axis=0)[2:]]
    assert "they err by up to {} at 1 s and {} at 2 s".format(*most) in ANSWERS


def test_the_results_of_the_readme_are_those_of_the_study():
    """Counts, picture, table and laws of the README and the page of answers are those of the short study."""
    results = PROJECT / "results"
    if not (results / "numbers.json").exists():
        pytest.skip("results/numbers.json is not there; `make` makes it")
    check_the_results_of_the_readme(results)
    n, words = json.loads((results / "numbers.json").read_text()), " ".join(README.split())
    shown, drawn = map(imread, (PROJECT / ".github" / "cost.png", results / "figures" / f"{PICTURE}.png"))
    right = abs(shown - drawn)[:, int(0.6 * shown.shape[1]) :] if shown.shape == drawn.shape else np.ones(1)
    assert right.mean() < PIXELS, f"copy {PICTURE}.png to .github/cost.png"
    table = by_model(results)
    assert table in README
    (of_frame,) = (line for line in frame(results).splitlines() if line.startswith("| Central difference"))
    needed = [cell.strip().replace("\u00a0", " ") for cell in of_frame.split("|")[2:-1]]
    assert "Central difference needs {} at 0.2 s, {} at 0.5 s, {} at 1 s and {} at 2 s.".format(*needed) in words
    cheapest, kinds = table.count("**Central difference"), len(table.strip().splitlines()) - 2
    assert (cheapest, kinds) == (5, 8)
    assert "central difference is the cheapest scheme (within a tenth) of OpenSees, Abaqus and LS-DYNA" in words
    assert "on five of [eight example models]" in words
    assert f"Over n > {n['decided_periods']} periods" in words and f"(n/{n['decided_periods']})^a" in words
    assert study.open_dataset("chaos", results).sizes["scheme"] == 4
    assert "In the last row four schemes were run" in words
    assert n["moves_step_is_least"]
    runs = study.open_dataset("runs/softening", results).sel(scheme="central_difference", quantity="displacement")
    from_rest = runs.error.sel(periods=100).swap_dims(size="steps_per_period").dropna("steps_per_period")
    (stated,) = _stated(r"Central difference: (\d+) steps, ωΔt = 0\.015")
    assert least_number(from_rest <= 0.01, "steps_per_period") < stated
    assert n["momentum_method_stable"]
    assert n["moves_periods"].startswith("0.2, ") and n["moves_periods"].endswith(" and 2")
    assert n["model_is_a_bound"]
    assert "does not become stiffer than the model" in ANSWERS


@pytest.mark.parametrize("name", TEXTS)
def test_files_that_are_named_exist(name):
    """Files named in the texts exist, except files that a reader of CONTRIBUTING adds."""
    added = {block.split("\n")[0].removeprefix("# ") for block in blocks(CONTRIBUTING, "python")}
    named = set(re.findall(r"[`(]((?:study|paper|tests|config|docs|\.github|\.ci)/[\w./-]*)[`)]", TEXTS[name]))
    named |= set(re.findall(r"`([\w.-]+\.(?:md|cff|toml|txt))`", TEXTS[name]))
    assert named
    assert [path for path in sorted(named - added) if not (PROJECT / path).exists()] == []


def test_the_rooms_of_the_design_are_those_of_the_tree():
    (tree,) = (block for block in blocks(TEXTS["docs/pages/design.md"], "text") if "snakefile" in block)
    stated = set(re.findall(r"^  (\w+)/", tree, re.MULTILINE))
    assert stated == {path.parent.name for path in (PROJECT / "study").glob("*/__init__.py")}


@pytest.mark.parametrize("name", TEXTS)
def test_a_target_stands_before_the_configuration(name):
    """Snakemake would read a target after ``--configfile`` as one more configuration."""
    commands = [line for line in TEXTS[name].splitlines() if "snakemake " in line and "--configfile" in line]
    assert not any(re.search(r"--configfile \S+ +results/", line) for line in commands)
    assert commands or name != "docs/pages/how_to/pipeline.md"


def test_the_study_on_many_cores_takes_the_stated_time():
    table, stated = pd.read_csv(PROJECT / "docs" / "scaling.csv"), TEXTS["docs/pages/how_to/pipeline.md"]
    on, stated = table.set_index("cores"), " ".join(stated.split())
    assert "95 minutes on one core" in stated and on.seconds[1] / 60 == pytest.approx(95, abs=0.5)
    assert "On eight cores less than a tenth of the time is lost" in stated and 0.08 < on.lost[8] < 0.1
    assert "On 64 and more cores that study takes less than four minutes" in stated and on.seconds[64] < 240
    assert on.seconds[64] == pytest.approx(on.seconds[128], rel=0.01)


def test_the_torture_has_the_stated_kills_and_differences():
    table, stated = pd.read_csv(PROJECT / "docs" / "torture.csv"), TEXTS["docs/pages/how_to/pipeline.md"]
    stated = " ".join(stated.split())
    assert "kills a small study a hundred times" in stated and "no difference" in stated
    assert table.kills.sum() == 100 and (table["of runs at work"] > 0.8 * table.kills).all()
    assert table.differences.sum() == table["unfinished files left"].sum() == 0
