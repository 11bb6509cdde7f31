"""The named problems."""
