"""Time marching: a run, an ensemble of runs, and their timing."""
