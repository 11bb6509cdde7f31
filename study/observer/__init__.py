"""Observers: quantities of a run, as one value a run (reductions) or as values along time (records)."""
