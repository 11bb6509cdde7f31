"""The command ``conform``, also ``python -m conformance``: run a code over the cases; see README.md."""

import argparse
from collections.abc import Sequence

from conformance import VERSION
from conformance.command import add_arguments, conform


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command.

    Parameters
    ----------
    arguments
        Words of the command line; by default those given to this process.

    Raises
    ------
    SystemExit
        With code 1 if a case fails. With code 2 after a wrong call; one sentence on the standard error output explains
        it.
    """
    parser = argparse.ArgumentParser(prog="conform", description=f"Conformance kit {VERSION}.")
    add_arguments(parser)
    try:
        conform(parser.parse_args(arguments))
    except (ValueError, OSError) as mistake:
        parser.exit(2, f"conform: {mistake}\n")


if __name__ == "__main__":
    main()
