"""Declarations of experiments: their datasets, inputs and options."""
