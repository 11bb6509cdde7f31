"""The ledger of claims: checkable statements of the paper, further claims, and their verdicts from the datasets."""
