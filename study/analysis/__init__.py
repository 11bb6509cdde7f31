"""Linear theory, outcomes, comparison with references, and recommendation."""
