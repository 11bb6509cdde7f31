"""What several products compute from datasets."""
