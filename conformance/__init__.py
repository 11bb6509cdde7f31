"""A conformance kit: cases that show whether the integrator of a code does what its name says."""

#: Version of the kit: year and number of the newest cases. New cases raise the number and have it as their version. A
#: case never changes: a wrong case is removed, and its replacement has another name.
VERSION = "2026.2"
