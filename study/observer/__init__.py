"""What a run reports: one value a run (reductions), or values along time (records)."""
