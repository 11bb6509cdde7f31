"""Tables and ledger as pages, which the report of the pipeline shows."""
