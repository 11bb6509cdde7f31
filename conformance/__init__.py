"""A conformance kit: cases that show whether the integrator of a code does what its name says."""

#: Year and number of the newest cases. A case never changes; a wrong one retires, and another name takes its place. New
#: cases raise the number, which they have as their version.
VERSION = "2026.2"
