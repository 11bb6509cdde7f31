"""Experiments that make reference solutions."""
