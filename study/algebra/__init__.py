"""Matrices in the least form that holds them, their products and solutions, and compensated sums."""
