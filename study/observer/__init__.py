"""Observers: what a run reports, as one value a run (reductions) or as values along time (records)."""
