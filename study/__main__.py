"""The command line: ``study run``, ``study recommend`` and ``study list``, also as ``python -m study``."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from study import datasets
from study.analysis.recommendation import recommend
from study.marching.run import run
from study.observer.named import observers
from study.problem.named import problems
from study.registry import Registry, UnknownName
from study.scheme.named import schemes

_REGISTRIES: dict[str, Registry[Any]] = {"problems": problems, "schemes": schemes, "observers": observers}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="study", description="Time integration schemes on non-linear dynamics.")
    parser.add_argument("--version", action="version", version=f"study {datasets.VERSION}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    command = commands.add_parser("run", help="march a scheme on a problem and print what was observed")
    command.set_defaults(function=_run)
    command.add_argument("problem", metavar="PROBLEM", help="name of a problem")
    command.add_argument("scheme", metavar="SCHEME", help="name of a scheme")
    command.add_argument("--dt", type=float, required=True, help="step size")
    command.add_argument("--steps", type=int, required=True, help="number of steps")
    command.add_argument(
        "--observe", nargs="+", metavar="NAME", default=["trajectory"], help="names of observers; default: trajectory"
    )
    command.add_argument("--every", type=int, default=1, metavar="N", help="steps between two samples; default: 1")
    command.add_argument("--output", type=Path, metavar="FILE.nc", help="write a dataset instead of printing it")

    command = commands.add_parser("recommend", help="list the schemes that keep an error, the cheapest first")
    command.set_defaults(function=_recommend)
    command.add_argument("problem", metavar="PROBLEM", help="name of a problem")
    command.add_argument("--error", type=float, required=True, help="largest allowed error as a fraction")
    command.add_argument(
        "--measure",
        default="max_trajectory_error",
        help="measure of error; default: max_trajectory_error",
    )
    command.add_argument("--periods", type=float, default=100, help="length of the run in periods; default: 100")
    command.add_argument(
        "--folder", type=Path, default=datasets.RESULTS, help="folder of the results; default: results"
    )

    command = commands.add_parser("list", help="list the names of problems, schemes and observers")
    command.set_defaults(function=_list)
    command.add_argument("kind", nargs="?", choices=list(_REGISTRIES), help="what to list; default: all three")
    return parser


def _run(arguments: argparse.Namespace) -> None:
    if arguments.output:
        datasets.check_writable(arguments.output)
    dataset = run(
        arguments.problem,
        arguments.scheme,
        dt=arguments.dt,
        steps=arguments.steps,
        observe=arguments.observe,
        every=arguments.every,
    )
    if arguments.output:
        dataset.attrs |= datasets.provenance(dataset.title, "study run")
        datasets.write(dataset, arguments.output)
    else:
        print(dataset)


def _recommend(arguments: argparse.Namespace) -> None:
    table = recommend(
        arguments.problem,
        error=arguments.error,
        measure=arguments.measure,
        periods=arguments.periods,
        folder=arguments.folder,
    )
    print(table.to_string())


def _list(arguments: argparse.Namespace) -> None:
    if arguments.kind:
        print(*_REGISTRIES[arguments.kind], sep="\n")
    else:
        print(*(f"{kind}:\n  " + "\n  ".join(names) for kind, names in _REGISTRIES.items()), sep="\n\n")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command.

    Parameters
    ----------
    arguments
        Words of the command line; those of this process for None.

    Raises
    ------
    SystemExit
        With code 2 after a mistake, which one sentence on the standard error output explains.
    """
    parser = _parser()
    chosen = parser.parse_args(arguments)
    try:
        chosen.function(chosen)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, such as head, has closed the pipe, into which exit would flush again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return
    except (UnknownName, ValueError, OSError) as error:
        mistake = str(error)
    except SystemExit as error:  # a file that cannot be written
        mistake = str(error)
    else:
        return
    parser.exit(2, f"study: {mistake}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
