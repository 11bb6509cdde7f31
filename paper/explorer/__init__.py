"""A page to look at every run of the maps.

It is one file that a browser opens without a server, and holds all that it shows.
"""
