"""Schemes that wrap another scheme: they step it, and extend or change its state."""
