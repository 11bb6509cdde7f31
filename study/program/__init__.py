"""Models that live in another program: their runs, and the truth that these agree on."""
