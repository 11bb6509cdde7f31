"""A page that shows the runs of the maps of stability, at a limited number of amplitudes and step sizes.

The page is one file with all its data. A browser opens it without a server.
"""
