"""``python -m conformance my_code:step`` runs a code over the cases; see README.md."""

import argparse

from conformance import VERSION
from conformance.command import add_arguments, conform

parser = argparse.ArgumentParser(prog="python -m conformance", description=f"Conformance kit {VERSION}.")
add_arguments(parser)
try:
    conform(parser.parse_args())
except (ValueError, OSError) as mistake:
    parser.exit(2, f"conformance: {mistake}\n")
