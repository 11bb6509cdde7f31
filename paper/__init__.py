"""Figures, tables, numbers, ledger of claims and manuscript; all are made from datasets alone."""
