"""The ledger of claims: every checkable statement of the paper, and what the datasets say of it."""
