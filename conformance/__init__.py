"""A conformance kit: cases that show whether the integrator of a code does what its name says."""

#: Year and number of the cases. A case never changes; a wrong one retires, and another name takes its place.
VERSION = "2026.1"
