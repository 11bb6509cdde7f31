"""The answers that a reader narrows, in a browser, compared with the decisions."""

import itertools
import math

import pytest
import xarray as xr

from docs import answers
from docs.plan import PAGES
from study import io
from study.runs.needs import ATTRIBUTES, decisions, exponents, joined_needs, needs
from tests.browser import check_page, set_width
from tests.runs.made_up import runs, with_kinds

ERRORS = [0.1, 0.01, 0.001]
#: Errors of the schemes at four steps, the coarsest first.
ACCURATE = [[0.2, 0.05, 0.005, 0.0005], [0.05, 0.05, 0.02, 0.02], [0.2, 0.02, 0.02, 0.001]]
#: Script that chooses an option of the form by its text.
CHOOSE = """const select = document.forms.answers.elements[arguments[0]];
select.value = [...select.options].find((one) => one.text === arguments[1]).value;
select.dispatchEvent(new Event("input", {bubbles: true}))"""
BEST = "return [...document.querySelectorAll('#answer b')].map((one) => one.innerText)"


@pytest.fixture(scope="module")
def needed():
    """Needs on a spring, under records and on a structure whose computing time decides, with names that codes know."""
    records = runs(ACCURATE, problem="records").assign_coords(quantity=["peak drift", "velocity"]).isel(quantity=[0])
    large = runs([ACCURATE[0]] * 3, problem="large").assign_coords(unknowns=200, free_vibration=0)
    ds = with_kinds(
        joined_needs([needs(data, ERRORS) for data in (runs(ACCURATE, problem="softening"), records, large)])
    )
    # the schemes with more forces take less time
    ds["seconds"] = (1 / ds.force_evaluations).where(ds.cost == "seconds")
    ds.verdict.attrs = ATTRIBUTES["verdict"]
    names = {"cheap": "central_difference", "dear": "rk4", "stiff": "bathe"}
    law = {"order": ("scheme", [2, 4, 2]), "order_of_loss": ("scheme", [math.inf, 5, 3])}
    in_codes = ("scheme", [1, 0, 1])
    ds = ds.assign_coords(scheme=[names[name] for name in ds.scheme.values], in_codes=in_codes, **law)
    return ds.assign(exponent=exponents(ds))


@pytest.fixture
def page(browser, needed, tmp_path):
    """The form in the browser."""
    io.write(needed.assign_attrs(source=io.SOURCE), tmp_path / "needs.nc")
    limits = (("scheme", "damping_ratio"), [[math.inf]] * needed.sizes["scheme"])
    spectral = xr.Dataset({"stability_limit": limits}, {"scheme": needed.scheme.values, "damping_ratio": [0.0]})
    io.write(spectral.assign_attrs(source=io.SOURCE), tmp_path / "spectral.nc")
    script, style = ((PAGES.parent / "static" / name).read_text() for name in ("answers.js", "site.css"))
    head = f'<meta charset="utf-8"><meta name="viewport" content="width=device-width"><style>{style}</style>'
    head += '<link rel="icon" href="data:,">'
    text = f"{head}{answers.form(tmp_path)}<script>{script}</script>"
    (tmp_path / "page.html").write_text(text)
    set_width(browser, 1000)
    browser.get((tmp_path / "page.html").as_uri())
    return browser


def _choose(page, name, text):
    page.execute_script(CHOOSE, name, text)


def test_the_answers_are_the_decisions(page, needed):
    """For each filter, model, error and kind the page names the scheme of the decision."""
    decided, checked = decisions(needed), 0
    models = {
        "softening": "Free vibration over a long time: softeninging thing",
        "records": "Frame under an earthquake: recordsing thing",
        "large": "Largeing thing",
    }
    programs = {"OpenSees, Abaqus or LS-DYNA": "codes", "any program or paper": "all"}
    for (program, choice), (problem, model) in itertools.product(programs.items(), models.items()):
        _choose(page, "code", program)
        _choose(page, "model", model)
        for error in ERRORS:
            _choose(page, "error", f"{100 * error:g} %")
            for kind in ("explicit", "implicit"):
                _choose(page, "kind", kind)
                quantity = "peak drift" if problem == "records" else "displacement"
                decision = decided.sel(
                    problem=problem, quantity=quantity, allowed_error=error, kind=kind, filter=choice
                )
                texts = page.execute_script(BEST)
                assert [text.split(":")[0] for text in texts] == [
                    name for name in [decision.scheme_title.item()] if name
                ]
                if texts and problem != "records":
                    assert f" {decision.steps_per_period.item():.0f}" in texts[0]
                checked += bool(texts)
    assert checked > 20
    check_page(page)


def test_the_choices_fit_a_phone(page):
    """A list of models that is wider than the form, whose end cannot be seen."""
    set_width(page, 390)
    page.execute_script("document.forms.answers.elements.model.options[0].text = 'long '.repeat(20)")
    right = "(one) => one.getBoundingClientRect().right"
    choices, form = page.execute_script(
        f"const right = {right}, form = document.forms.answers; return [[...form.elements].map(right), right(form)]"
    )
    assert len(choices) == 6 and max(choices) <= form


def test_a_program_and_a_duration_narrow_the_answer(page):
    """OpenSees has Bathe's method as TRBDF2. Four times the periods need 2 and 4^(2/3) times the steps."""
    _choose(page, "model", "Free vibration over a long time: softeninging thing")
    _choose(page, "error", "10 %")
    _choose(page, "code", "OpenSees")
    assert page.execute_script(BEST) == ["Cheap: 16 steps in a period", "Stiff: 16 steps in a period"]
    assert "integrator TRBDF2" in page.execute_script("return document.querySelector('#answer').innerText")
    last = (
        "const {periods} = document.forms.answers.elements; periods.value = arguments[0];"
        "periods.dispatchEvent(new Event('input', {bubbles: true}))"
    )
    page.execute_script(last, -5)
    assert page.execute_script(BEST) == []
    assert "above zero" in page.execute_script("return document.querySelector('#answer').innerText")
    forces = "return document.querySelector('#answer tbody td:nth-child(5)').innerText.replace(',', '')"
    page.execute_script(last, 10)
    short = float(page.execute_script(forces))
    page.execute_script(last, 40)
    assert float(page.execute_script(forces)) == pytest.approx(2 * short, rel=0.01)
    assert page.execute_script(BEST) == ["Cheap: about 32 steps in a period", "Stiff: about 41 steps in a period"]
    _choose(page, "model", "Largeing thing")
    page.execute_script(last, 40)
    assert page.execute_script(BEST) == []
    assert "known over 40 periods: the runs last 10" in page.execute_script(
        "return document.querySelector('#answer').innerText"
    )
