"""Linear algebra: matrices in the smallest form that holds them, solution of linear systems, compensated sums."""
