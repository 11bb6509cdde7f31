"""The time integration schemes, a file for each family."""
