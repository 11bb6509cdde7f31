"""Products that somebody has changed are put aside, and no others."""

import os
import shutil
import time
from pathlib import Path

import pytest

from study.pipeline import products

NAMES = ["results/manuscript.pdf", "results/tables/needs.csv", "results/energy_error.nc"]


@pytest.fixture(autouse=True)
def noted(tmp_path, monkeypatch):
    """A folder with some products, which a run has noted."""
    monkeypatch.chdir(tmp_path)
    Path("results/tables").mkdir(parents=True)
    for name in NAMES:
        Path(name).write_text(f"the content of {name}")
        os.utime(name, (1000.0, 1000.0))
    products.note([*NAMES, "results/never_made.nc"])


def test_untouched_copied_and_redated_products_stay():
    for name in NAMES:
        shutil.copyfile(name, f"{name}.copy")
        os.replace(f"{name}.copy", name)
    assert list(products.changed(time.time() + 1)) == []
    assert all(Path(name).is_file() for name in NAMES)


@pytest.mark.parametrize("damage", ["", "the content of", "THE content of results/tables/needs.csv", None])
def test_emptied_cut_exchanged_and_replaced_products_are_put_aside(damage):
    path = Path(NAMES[1])
    if damage is None:
        path.unlink()
        path.mkdir()
    else:
        path.write_text(damage)
    (sentence,) = products.changed(time.time() + 1)
    assert sentence.startswith(f"'{path}' is no longer what was made; it is kept as '{path}.unusable'")
    assert not path.exists() and Path(f"{path}.unusable").exists()
    assert list(products.changed(time.time() + 1)) == []


def test_what_a_dead_run_may_have_made_stays():
    Path(NAMES[0]).write_text("made anew")
    assert list(products.changed(time.time() - 100)) == [] and Path(NAMES[0]).is_file()


def test_missing_products_and_damaged_notes_are_no_matter():
    Path(NAMES[0]).unlink()
    assert list(products.changed(time.time() + 1)) == []
    products.NOTES.write_text('{"results')
    Path(NAMES[1]).write_text("")
    assert list(products.changed(time.time() + 1)) == []
