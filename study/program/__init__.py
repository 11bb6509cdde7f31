"""Models in other programs: their runs, and the truth that these agree on."""
