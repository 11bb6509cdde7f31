"""Schemes that step another scheme and add to its state."""
