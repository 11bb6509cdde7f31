"""Codes that the kit judges: two small examples, the study, and others where they are installed."""
