"""The texts as LaTeX, generated from their only source by pandoc."""
