"""The experiments of the study: each module declares one, which returns labelled datasets."""
