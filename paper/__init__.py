"""Figures, tables, ledger of claims and manuscript: everything here reads datasets and nothing else."""
