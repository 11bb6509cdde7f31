"""The ledger of claims: every checkable statement of the paper and its verdict from the datasets."""
