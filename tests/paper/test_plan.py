"""The plan of the paper."""

from dataclasses import replace
from pathlib import Path

import pytest

from paper import plan, products


def test_what_is_drawn_depends_on_the_style_and_what_is_counted_does_not():
    steps = {step["name"]: step["jobs"] for step in plan.steps_of(products.discover(), Path("."))}
    assert "paper/style.mplstyle" in steps["figure"]["instability"]["inputs"]
    assert "paper/style.mplstyle" not in steps["claims"][""]["inputs"]


def test_what_is_declared_where_nobody_looks_for_it_is_told():
    found = products.discover()
    plan.check_places(found)
    claim = next(product for product in found if product.kind == "claim")
    with pytest.raises(ValueError, match="is declared in paper.figures.own and looked for in paper/claims: move it"):
        plan.check_places([replace(claim, module="paper.figures.own")])


def test_a_dataset_that_is_not_made_is_told_with_its_reader():
    chosen = [product for product in products.discover(["figures"]) if product.name == "instability"]
    with pytest.raises(ValueError) as caught:
        plan.check_datasets(chosen, ["reference/softening_large"])
    assert str(caught.value) == (
        "figure 'instability' reads 'phase_portrait/softening_large', a dataset that this configuration does not make."
    )
    plan.check_datasets(chosen, ["reference/softening_large", "phase_portrait/softening_large"])
