"""Which step keeps an error, and what it costs: runs over sizes of steps, the needs of schemes, and decisions.

Data flow one way: runs (error, status and costs of each scheme at each step size) → needs (the largest step size that
keeps each allowed error) → decisions (the cheapest scheme of each kind).
"""
