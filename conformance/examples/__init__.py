"""Three small codes that the kit runs, in NumPy, C and JavaScript."""
