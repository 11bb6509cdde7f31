"""Observers: quantities of a run, as one value per run (reductions) or as values along time (records)."""
