"""Codes that the kit judges: two small examples, the study, and other codes if they are installed."""
