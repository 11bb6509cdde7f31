"""The experiments of the study. Each returns labelled datasets.

Every module except ``circumstances`` and ``coordinates``, which experiments share, declares one experiment.
"""
