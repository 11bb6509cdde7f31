"""A conformance kit: cases that check whether the integrator of a code implements the scheme of its name."""

#: Version of the kit: year and number of the newest cases. New cases raise the number and have it as their version. A
#: case never changes: a wrong case is removed, and its replacement has another name.
VERSION = "2026.2"
