"""A conformance kit: cases that check whether the integrator of a code implements the scheme of its name."""

#: Year and number of the newest cases. A case never changes; a case with another name replaces a wrong one. New cases
#: raise the number, which is their version.
VERSION = "2026.2"
