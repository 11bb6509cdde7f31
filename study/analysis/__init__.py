"""Linear theory, outcomes, comparison with references, and tables of assessments."""
