"""The rules of the design: allowed imports, the length of files, and what every scheme states."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import study
from paper.published import printed_energy_errors
from study.analysis.forces import forces_of
from study.problem.named import printed_periods

PROJECT = Path(__file__).parent.parent
FOLDERS = ("study", "reference", "conformance", "paper", "docs", "tests")
IN_WORDS = {"first": 1, "one": 1, "second": 2, "two": 2, "third": 3, "three": 3, "fourth": 4, "four": 4}
SOURCES = [path for folder in FOLDERS for path in (PROJECT / folder).rglob("*.py")]


def test_the_arrows_of_the_design_hold():
    """The linter of imports runs in a separate process, because it disables existing loggers."""
    command = [Path(sys.executable).with_name("lint-imports"), "--no-cache"]
    done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_files_use_what_is_public():
    """One test checks all files, because five hundred tests would take seconds to collect."""
    private = "jax." + "_src"
    assert [path for path in SOURCES if private in path.read_text()] == []


def test_every_scheme_explains_itself(scheme):
    text = type(scheme).__doc__ or ""
    assert "References" in text and re.search(r"\d{4}", text)
    assert scheme.title and scheme.family and scheme.source
    assert scheme.order in (1, 2, 3, 4, 6, 8, 12) and scheme.order_with_damping <= scheme.order
    assert (
        "Carries" in text
        and re.search(r"[Ss]tab(le|ility)", text)
        and re.search(r"forces?\s+per\s+step|Newton\s+iteration", text)
    )


@pytest.mark.slow
def test_the_text_of_a_scheme_states_its_order_and_its_number_of_forces(scheme):
    text = " ".join((type(scheme).__doc__ or "").split())
    counted = forces_of(scheme)
    unit, forces = ("step", counted.per_step) if scheme.explicit else ("Newton iteration", counted.per_iteration)
    stated = [(word, scheme.order) for word in re.findall(r"\b(First|Second|Third|Fourth) order(?! for)", text)]
    stated += [(word, forces) for word in re.findall(rf"\b(one|two|three|four) forces? per {unit}", text)]
    assert all(IN_WORDS[word.lower()] == value for word, value in stated)


def test_names_of_1996_come_first():
    assert list(study.problems)[:4] == list(printed_periods)
    assert list(study.schemes)[:7] == printed_energy_errors().scheme.values.tolist()
