"""A script per table: ``python -m paper.tables.NAME OUTPUT DATASET...`` writes OUTPUT as CSV and as booktabs LaTeX."""
