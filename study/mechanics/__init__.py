"""The equation of motion: its terms, its tangent, and the balance that every step solves."""
