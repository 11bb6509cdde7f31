"""A script per figure: ``python -m paper.figures.NAME OUTPUT DATASET...`` writes OUTPUT as PDF, PNG and SVG."""
