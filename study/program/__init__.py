"""Models in other programs: their runs, and the reference that follows from them."""
