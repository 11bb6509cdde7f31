"""Reference solutions: exact motions and periods by routes that share no code with the schemes.

A route is a solver with its method, for instance CVODE with Adams' formulas.
"""
