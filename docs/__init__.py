"""The site of the study: pages written by hand, and pages made of its datasets and docstrings."""
