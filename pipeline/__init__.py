"""The pipeline: from declarations to a plan of jobs, and how each job runs."""
