"""A conformance kit: cases that check whether the integrator of a code implements the scheme of its name."""

#: Version of the kit: a year, and a number that rises when cases are added. Every case states the version that added
#: it. A case never changes: a wrong case is removed, and its replacement has another name.
VERSION = "2026.2"
