"""Causes of mistakes that a rule makes in the example codes."""

import pytest

from conformance.tests.mutants import FORMULAS, drawn, few, mutants, named


@pytest.mark.parametrize("file", FORMULAS)
def test_a_mutant_differs_from_the_example_in_one_line(file):
    candidates = [*mutants(file)]
    assert len(candidates) >= 50 and len({mutant.text for mutant in candidates}) >= 0.9 * len(candidates)
    assert all(mutant.before != mutant.after and mutant.after in mutant.text for mutant in candidates)


def test_most_mutants_are_named(tmp_path):
    """Of six mutants, two of each example, at least five are named; ``mutants.py`` counts more of them.

    Only this test finds that the search names the mistakes of the tests by hand, but no others.
    """
    chosen = [case for case in few() if case["name"].startswith("A-")]
    results = [named(causes) for _, causes in drawn(6, 1, chosen, tmp_path)]
    assert len(results) == 6 and sum(results) >= 5
