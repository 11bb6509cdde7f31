"""Products that somebody has changed are put aside, and no others."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from study.pipeline import products

NAMES = ["results/manuscript.pdf", "results/tables/needs.csv", "results/energy_error.nc"]
#: The note of the job that has made them.
NOTE = products.NOTES / "job"


@pytest.fixture(autouse=True)
def noted(tmp_path, monkeypatch):
    """A folder with some products, which their job has noted."""
    monkeypatch.chdir(tmp_path)
    Path("results/tables").mkdir(parents=True)
    products.NOTES.mkdir(parents=True)
    for name in NAMES:
        Path(name).write_text(f"the content of {name}")
    NOTE.write_bytes(subprocess.run(["cksum", *NAMES], capture_output=True, check=True).stdout)
    os.utime(NOTE, (1000.0, 1000.0))  # whatever follows is later


def test_untouched_copied_and_redated_products_stay():
    for name in NAMES:
        shutil.copyfile(name, f"{name}.copy")
        os.replace(f"{name}.copy", name)
    os.utime(NAMES[0], (1e10, 1e10))
    assert list(products.changed()) == []
    assert all(Path(name).is_file() for name in NAMES)


@pytest.mark.parametrize("date", [None, 0.0, 1e10])
@pytest.mark.parametrize("damage", ["", "the content of", "THE content of results/tables/needs.csv", None])
def test_emptied_cut_exchanged_and_replaced_products_are_put_aside(damage, date):
    """Whatever date they bear."""
    path = Path(NAMES[1])
    if damage is None:
        path.unlink()
        path.mkdir()
    else:
        path.write_text(damage)
    if date is not None:
        os.utime(path, (date, date))
    (sentence,) = products.changed()
    assert sentence.startswith(f"'{path}' is no longer what was made; it is kept as '{path}.unusable'")
    assert not path.exists() and Path(f"{path}.unusable").exists()
    assert list(products.changed()) == []


def test_what_was_found_to_be_the_same_is_not_read_again(monkeypatch):
    assert list(products.changed()) == []
    monkeypatch.setattr(products, "_sums", lambda paths: pytest.fail("it was read again"))
    assert list(products.changed()) == []


def test_missing_products_and_cut_notes_are_no_matter():
    Path(NAMES[0]).unlink()
    assert list(products.changed()) == []
    NOTE.write_text("12 3 results/manuscr\n4")
    assert list(products.changed()) == []


def test_what_is_kept_gets_a_free_name():
    path = Path(NAMES[1])
    Path(f"{path}.unusable/of/the/user").mkdir(parents=True)
    for number in (2, 3):
        path.write_text("damaged")
        assert products.put_aside(path) == Path(f"{path}.{number}.unusable")
    assert Path(f"{path}.2.unusable").read_text() == "damaged"


def test_a_product_that_cannot_be_put_aside_stops_with_a_sentence(monkeypatch):
    monkeypatch.setattr(Path, "rename", lambda *_: os.mkdir("results"))  # an error of the system, also for root
    Path(NAMES[1]).write_text("damaged")
    with pytest.raises(
        SystemExit, match="'results/tables/needs.csv' cannot be used, nor be renamed to '.*': File exists"
    ):
        list(products.changed())
