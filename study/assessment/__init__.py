"""The assessment of one problem: reference, runs of every scheme, errors, verdict, report."""
