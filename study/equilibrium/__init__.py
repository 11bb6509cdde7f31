"""The balance of forces at one time, and the Newton-Raphson iteration that solves it."""
