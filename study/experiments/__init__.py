"""The questions of the study, a file each; every one returns one labelled dataset."""
