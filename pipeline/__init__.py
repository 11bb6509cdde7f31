"""The pipeline makes a plan of jobs from the declarations of experiments and products, and runs each job."""
