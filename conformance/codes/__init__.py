"""Functions that run the kit on other codes; each needs its code."""
