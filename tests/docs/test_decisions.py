"""The short table of recommendations, and one answer in all tables, in the explorer and by ``study.recommend``."""

import json
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import study
from docs.answers import data as answers_of
from docs.decisions import PARTLY, _decided, recommended, short_cell
from paper.explorer.page import _decisions as in_explorer
from paper.tables.decision import column, limits_of, sentence, tabulate
from study.runs.needs import ATTRIBUTES, DECIDED, decisions, joined_needs, needs
from tests.runs.made_up import runs, with_kinds

PROJECT = Path(__file__).parent.parent.parent


def _decision(**values) -> xr.Dataset:
    usual = {
        "scheme": "bathe",
        "cost": "force_evaluations",
        "force_evaluations": 80.0,
        "decided": 2.0,
        "duration": 0.2,
        "ties": 2,
        "scheme_title": "Bathe",
        "verdict": 0,
        "smaller_steps": 3.0,
        "step_size": 0.0025,
        "spacing": 0.02,
        "steps_per_period": 10.0,
        "omega_step": 0.1,
        "problem": "softening",
    }
    return xr.Dataset(usual | values)


@pytest.mark.parametrize(
    "omega_step, printed", [(1.7e6, "1.7 × 10⁶"), (5e-5, "5 × 10⁻⁵"), (1700.0, "1700"), (0.0537, "0.054")]
)
def test_a_cell_states_the_product_of_frequency_and_step(omega_step, printed):
    decision = _decision(omega_step=omega_step, verdict=1)
    assert short_cell(decision, {}).replace("\u00a0", " ") == f"Bathe: ≤ 10 steps, ωΔt = {printed}"
    assert (
        short_cell(decision, {"bathe": 2.0}).replace("\u00a0", " ") == f"Bathe: ≤ 10 steps, ωΔt = {printed} (limit 2)"
    )


@pytest.mark.parametrize("omega_step, printed", [(1.968, "1.97"), (1.99996, "1.99996")])
def test_a_product_below_the_limit_of_stability_is_printed_below_it(omega_step, printed):
    cell = short_cell(_decision(omega_step=omega_step), {"bathe": 2.0})
    assert cell.endswith(f"\u00a0{printed} (limit\u00a02)")  # a line may break before the limit only


def test_a_step_in_seconds_is_not_a_number_of_steps():
    assert short_cell(_decision(problem="records"), {}).startswith("Bathe: 2.5\u00a0ms, ωΔt")
    assert short_cell(_decision(step_size=float("nan")), {}) == "–"


def test_a_cell_with_costs_has_the_forces_and_a_time_that_decides():
    costs = short_cell(_decision(), {}, costs=True).replace("\u00a0", " ")
    assert costs == "Bathe: 10 steps, ωΔt = 0.1, 40 forces, …"
    timed = _decision(cost="seconds", seconds=0.05, ties=1)
    assert short_cell(timed, {}, costs=True).replace("\u00a0", " ") == "Bathe: 10 steps, ωΔt = 0.1, 40 forces, 25 ms"
    records = short_cell(_decision(problem="records", ties=1), {}, costs=True).replace("\u00a0", " ")
    assert records == "Bathe: 2.5 ms, ωΔt = 0.1, 400 forces/s"


def _parsed(cell: str) -> tuple[str, float]:
    """Scheme and number of steps, or step in ms, that a cell states."""
    match = re.match(r"(.+): (?:≤ )?([\d,./]+)", cell.replace("\u00a0", " "))
    return (match[1], float(Fraction(match[2].replace(",", "")))) if match else ("", np.nan)


def _same(stated: tuple[str, float], decision: xr.Dataset) -> bool:
    """Whether a cell states the scheme of a decision, and its step to the printed digits."""
    if decision.problem == "records":
        step, digits = 1e3 * decision.step_size.item(), 0.05 * stated[1]
    else:
        step, digits = decision.steps_per_period.item(), 0.5
    near = bool(np.isnan(step) and np.isnan(stated[1])) or abs(stated[1] - step) <= digits
    return stated[0] == decision.scheme_title.item() and near


def _check_one_answer(
    decided: xr.Dataset, short: str, article: pd.DataFrame, explorer: list[dict], folder: Path
) -> None:
    """Every decision is the one in the short table of the site, the article, the explorer and ``recommend``."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in short.splitlines()[2:]]
    in_short = {(row[0], row[1]): row[2:] for row in rows}
    in_article = article.set_index(["Problem", "Right in", "Kind", "Error"])[["Scheme", "Steps"]].agg(": ".join, axis=1)
    in_page = {
        (entry["problem"], entry["quantity"], entry["kind"], round(entry["error"] / 100, 9)): entry
        for entry in explorer
    }
    checked = 0
    for problem in decided.problem.values:
        title = sentence(decided.problem_title.sel(problem=problem).item())
        for quantity in DECIDED:
            if (title, quantity, "explicit", column(0.01)) not in in_article.index:
                continue
            for k, error in enumerate(decided.allowed_error.values.tolist()):
                table = study.recommend(problem, allowed_error=error, quantity=quantity, folder=folder)
                for kind in decided.kind.values:
                    decision = decided.sel(problem=problem, quantity=quantity, allowed_error=error, kind=kind)
                    best = decision.sel(filter="all")
                    assert _same(_parsed(in_article[title, quantity, kind, column(error)]), best)
                    if quantity != "energy":
                        assert _same(_parsed(in_short[title, kind][k]), decision.sel(filter="codes"))
                    if (problem, quantity, kind, error) in in_page:
                        shown = in_page[problem, quantity, kind, error]
                        assert _same(_parsed(f"{shown['title']}: {shown['steps']}"), best)
                    first = table[(table.kind == kind) & table.step_size.notna()].head(1)
                    assert first.index.tolist() == ([best.scheme.item()] if best.scheme.item() else [])
                    assert first.step_size.tolist() == ([best.step_size.item()] if best.scheme.item() else [])
                    checked += 1
    assert checked == len(in_article)


@pytest.mark.parametrize("velocity, marked", [(0.1, False), (2.0, True)])
def test_a_step_that_does_not_keep_the_velocity_is_marked(velocity, marked):
    data = runs([[0.2, 0.05, 0.005, 0.0005]] * 3, problem="hardening", velocity=np.full((3, 4), velocity))
    needed = with_kinds(joined_needs([needs(data, [0.1])]))
    decided = decisions(needed).sel(filter="codes", quantity=["displacement"])
    decided.verdict.attrs = ATTRIBUTES["verdict"]
    cells = [cell for row in _decided(decided, {}, needs=needed).values() for cell in row]
    assert [cell.endswith(PARTLY) for cell in cells] == [marked, marked]


def test_tables_explorer_and_recommend_give_one_answer(tmp_path):
    errors = [0.1, 0.01, 0.001]
    accurate = [[0.2, 0.05, 0.005, 0.0005], [0.05, 0.05, 0.02, 0.02], [0.2, 0.02, 0.02, 0.001]]
    records = runs(accurate, problem="records").assign_coords(quantity=["peak drift", "velocity"]).isel(quantity=[0])
    parts = [needs(data, errors) for data in (runs(accurate, problem="hardening"), records)]
    needed = with_kinds(joined_needs(parts))
    decided = decisions(needed)
    for name, ds in (("needs", needed), ("decisions", decided)):
        ds.verdict.attrs = ATTRIBUTES["verdict"]
        study.io.write(ds.assign_attrs(source=study.io.SOURCE), tmp_path / f"{name}.nc")
    limits = (("scheme", "damping_ratio"), [[2.0], [np.inf], [np.inf]])
    spectral = xr.Dataset({"stability_limit": limits}, {"scheme": ["cheap", "dear", "stiff"], "damping_ratio": [0.0]})
    study.io.write(spectral.assign_attrs(source=study.io.SOURCE), tmp_path / "spectral.nc")
    short = recommended(tmp_path)["recommended"]
    _check_one_answer(decided, short, tabulate(decided, spectral), in_explorer(decided), tmp_path)


def test_the_study_gives_one_answer():
    """Two of dataset, article, explorer, README and ``study.recommend`` that name different steps for one question."""
    results = PROJECT / "results"
    if not (results / "explorer.html").exists():
        pytest.skip("results/explorer.html is not there; `make` makes it")
    page = (results / "explorer.html").read_text()
    (meta,) = re.findall(r'<script id="meta" type="application/json">(.*?)</script>', page)
    article = pd.read_csv(results / "tables/decision.csv", keep_default_na=False)
    decided = study.open_dataset("decisions", results)
    short = recommended(results)["recommended"]
    readme_rows = [line for line in (PROJECT / "README.md").read_text().splitlines() if "ωΔt\u00a0=" in line]
    cells = {cell.replace(f"\u00a0{PARTLY}", "").strip() for line in short.splitlines() for cell in line.split("|")}
    assert readme_rows and all({cell.strip(" *") for cell in line.split("|")[2:4]} <= cells for line in readme_rows)
    _check_one_answer(decided, short, article, json.loads(meta)["decisions"], results)


@pytest.mark.parametrize("periods", [1000, 100_000])
def test_a_longer_free_vibration_has_one_answer(periods):
    """Scheme and steps of the page of answers, by the rule of docs/static/answers.js, and of ``study.recommend``."""
    results = PROJECT / "results"
    if not (results / "needs.nc").exists():
        pytest.skip("results/needs.nc is not there; `make` makes it")
    needed = study.open_dataset("needs", results)
    page = answers_of(needed, limits_of(study.open_dataset("spectral", results)))
    columns = [
        "problem",
        "quantity",
        "error",
        "scheme",
        "counts",
        "steps",
        "omega",
        "forces",
        "worst",
        "law",
        "cost",
        "mark",
    ]
    rows = pd.DataFrame(page["rows"], columns=columns).dropna(subset="law")
    assert len(rows)
    rows["kind"] = ["explicit" if page["schemes"][scheme]["explicit"] else "implicit" for scheme in rows.scheme]
    for (p, q, e), group in rows.groupby(["problem", "quantity", "error"]):
        problem, scale = needed.isel(problem=p), needed.time_scale[p].item()
        question = {"allowed_error": needed.allowed_error[e].item(), "quantity": page["quantities"][q]}
        table = study.recommend(problem, **question, duration=periods * scale)
        for kind, schemes in group.groupby("kind"):
            finer = (periods / problem.decided.item()) ** schemes.law
            cost = schemes.cost * finer
            best = schemes[cost <= page["tied"] * cost.min()].worst.idxmin()
            first = table[(table.kind == kind) & (table.step_size > 0)].iloc[0]
            assert first.name == needed.scheme.values[schemes.scheme[best]]
            steps = schemes.steps[best] * finer[best]
            unit = max(10 ** (np.floor(np.log10(steps)) - 2), 1)
            assert scale / first.step_size == pytest.approx(np.ceil(steps / unit - 1e-9) * unit)
