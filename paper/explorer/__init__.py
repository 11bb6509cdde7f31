"""A page that shows every run of the maps.

The page is one file with all its data. A browser opens it without a server.
"""
