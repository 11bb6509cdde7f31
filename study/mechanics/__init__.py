"""The equation of motion: its terms, its tangent, and the balance of forces that every implicit step solves."""
