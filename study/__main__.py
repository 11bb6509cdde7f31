"""The command line, ``study`` or ``python -m study``."""

import argparse
import math
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from study import io
from study.assessment.assess import assess
from study.assessment.assurance import limits_of_reference
from study.assessment.report import answer, report
from study.assessment.scheme import COMPARED, ON, assess_scheme, scheme_page
from study.marching.run import run
from study.mechanics.definition import Problem
from study.observer.named import observers
from study.problem.named import problems
from study.program.command import command
from study.program.definition import Program
from study.program.opensees import opensees
from study.registry import Registry, UnknownName
from study.runs.recommendation import recommend
from study.scheme.base import Scheme
from study.scheme.named import schemes
from study.user_files import load

_REGISTRIES: dict[str, Registry[Any]] = {"problems": problems, "schemes": schemes, "observers": observers}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="study", description="Time integration schemes on non-linear dynamics.")
    parser.add_argument("--version", action="version", version=f"study {io.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    command = commands.add_parser("run", help="march a scheme on a problem and print the observed values")
    command.set_defaults(function=_run)
    command.add_argument("problem", metavar="PROBLEM", help="name of a problem, or FILE.py:NAME")
    command.add_argument("scheme", metavar="SCHEME", help="name of a scheme, or FILE.py:NAME")
    command.add_argument("--dt", type=float, required=True, help="step size")
    command.add_argument("--steps", type=int, required=True, help="number of steps")
    command.add_argument(
        "--observe", nargs="+", metavar="NAME", default=["trajectory"], help="names of observers; default: trajectory"
    )
    command.add_argument("--every", type=int, default=1, metavar="N", help="steps between two samples; default: 1")
    command.add_argument("--output", type=Path, metavar="FILE.nc", help="write a dataset instead of printing it")

    command = commands.add_parser("assess", help="find the scheme and the step that a problem of your own needs")
    command.set_defaults(function=_assess)
    command.add_argument(
        "problem", metavar="FILE.py:NAME", nargs="?", help="a study.Problem in a file, or the name of a problem"
    )
    command.add_argument("--command", metavar="WORDS", help="a program instead, with {dt}, {scheme} and {output} in it")
    command.add_argument("--opensees", action="store_true", help="a model of OpenSees in FILE.py instead")
    command.add_argument("--spacing", type=float, help="time between the samples of a record of such a program")
    command.add_argument("--time-limit", type=float, help="seconds after which a run of such a program is stopped")
    command.add_argument("--workers", type=int, metavar="N", help="runs of such a program at once; default: cores")
    command.add_argument("--duration", type=float, help="time of the runs in seconds; default: ten periods, if any")
    command.add_argument("--seconds", type=float, default=math.inf, help="wall time after which no run begins")
    command.add_argument("--controller", metavar="NAME", help="also find tolerances, with steps that it controls")
    command.add_argument(
        "--allowed-error", type=float, nargs="+", default=[0.1, 0.01, 0.001], help="allowed errors, as fractions"
    )
    command.add_argument(
        "--schemes", nargs="+", metavar="SCHEME", help="names of schemes, or FILE.py:NAME; default: ten common ones"
    )
    command.add_argument(
        "--quantities", metavar="FILE.py:NAME", help="a dict of study.Quantity in a file; default: u, velocity, energy"
    )
    command.add_argument("--no-maps", dest="maps", action="store_false", help="leave out how the schemes fail")
    command.add_argument("--output", type=Path, metavar="PATH", help="PATH.nc and PATH.html are written; default: none")

    command = commands.add_parser("assess-scheme", help="compare your own scheme with those of the study")
    command.set_defaults(function=_assess_scheme)
    command.add_argument("scheme", metavar="FILE.py:NAME", help="a study.Scheme in a file, or the name of a scheme")
    command.add_argument("--compare-with", nargs="+", metavar="NAME", default=COMPARED, help="schemes to compare with")
    command.add_argument("--problems", nargs="+", metavar="NAME", help="springs to run; default: also stiff systems")
    command.add_argument("--output", type=Path, required=True, metavar="FILE.html", help="page to write")

    command = commands.add_parser("recommend", help="list the schemes that keep an error, the cheapest first")
    command.set_defaults(function=_recommend)
    command.add_argument(
        "name", metavar="NAME", help="name of an assessment, or of a problem of the study, such as softening"
    )
    command.add_argument("--allowed-error", type=float, required=True, help="an error that was assessed, as a fraction")
    command.add_argument("--quantity", help="quantity that must keep the error; default: the first, displacement")
    command.add_argument("--duration", type=float, metavar="SECONDS", help="a longer duration than that of the runs")
    command.add_argument("--folder", type=Path, default=io.RESULTS, help="folder of the results; default: results")

    command = commands.add_parser("list", help="list the names of problems, schemes and observers")
    command.set_defaults(function=_list)
    command.add_argument("kind", nargs="?", choices=list(_REGISTRIES), help="what to list; default: all three")
    return parser


def _object_or_name(place: str, kind: type) -> Any:
    """The object in a user's file if ``place`` is ``FILE.py:NAME``, otherwise the given name."""
    return load(place, (kind,)) if ".py" in place else place


def _run(arguments: argparse.Namespace) -> None:
    if arguments.output:
        io.check_writable(arguments.output)
    dataset = run(
        _object_or_name(arguments.problem, Problem),
        _object_or_name(arguments.scheme, Scheme),
        dt=arguments.dt,
        steps=arguments.steps,
        observe=arguments.observe,
        every=arguments.every,
    )
    if arguments.output:
        dataset.attrs |= io.provenance(dataset.title, "study run", io.now())
        io.write(dataset, arguments.output)
    else:
        print(dataset)


def _assess(arguments: argparse.Namespace) -> None:
    outputs = []
    if arguments.output:
        # both files are written, even if PATH ends in .nc or .html
        stem = arguments.output.name.removesuffix(".nc").removesuffix(".html")
        outputs = [io.check_writable(arguments.output.with_name(stem + suffix)) for suffix in (".nc", ".html")]
    if arguments.command or arguments.opensees:
        dataset = assess(_program(arguments), allowed_errors=arguments.allowed_error, seconds=arguments.seconds)
    else:
        if not arguments.problem:
            raise ValueError("assess needs FILE.py:NAME, the name of a problem, or --command.")
        _refuse(arguments, {"spacing": None, "time_limit": None, "workers": None}, "a program, not of a problem")
        schemes = None
        if arguments.schemes:
            schemes = {place.rpartition(":")[2]: _object_or_name(place, Scheme) for place in arguments.schemes}
        dataset = assess(
            _object_or_name(arguments.problem, Problem),
            schemes,
            duration=arguments.duration,
            quantities=load(arguments.quantities, (dict,)) if arguments.quantities else None,
            allowed_errors=arguments.allowed_error,
            maps=arguments.maps,
            controller=arguments.controller,
            seconds=arguments.seconds,
        )
    dataset.attrs["command"] = shlex.join(["study", *arguments.words])
    if outputs:
        io.write(dataset, outputs[0])
        report(dataset, outputs[1])
    for quantity in dataset.quantity.values:
        for error in dataset.allowed_error.values:
            print(f"{recommend(dataset, allowed_error=error, quantity=quantity).to_string()}\n")
            print(f"{answer(dataset, quantity, error)}\n")
    if limits := limits_of_reference(dataset):
        print(f"{limits}\n")
    if outputs:
        print(f"written: {outputs[0]}, {outputs[1]}")


def _refuse(arguments: argparse.Namespace, defaults: dict[str, Any], whose: str) -> None:
    """Raise an error for an option that was given although it has no effect."""
    for name, default in defaults.items():
        if getattr(arguments, name) != default:
            raise ValueError(f"--{name.replace('_', '-')} is an option of {whose}; leave it out.")


def _program(arguments: argparse.Namespace) -> Program:
    """The program that a command, or a model of OpenSees, defines."""
    _refuse(arguments, {"quantities": None, "controller": None}, "a problem, not of a program")
    if not arguments.schemes or not arguments.duration:
        raise ValueError("a program needs --schemes, such as newmark hht, and --duration.")
    schemes = [name for word in arguments.schemes for name in word.split(",") if name]
    options = {key: getattr(arguments, key) for key in ("spacing", "time_limit", "workers")}
    if bool(arguments.opensees) != bool(arguments.problem):
        raise ValueError("give --opensees with FILE.py, or --command without a file.")
    if arguments.opensees:
        return opensees(arguments.problem, schemes, arguments.duration, **options)
    return command(arguments.command, schemes, arguments.duration, **options)


def _assess_scheme(arguments: argparse.Namespace) -> None:
    output = io.check_writable(arguments.output)
    scheme = _object_or_name(arguments.scheme, Scheme)
    assessed = assess_scheme(scheme, compare_with=arguments.compare_with, problems=arguments.problems or ON)
    assessed.linear.attrs["command"] = shlex.join(["study", *arguments.words])
    io.write(scheme_page(assessed), output)
    print(f"written: {output}")


def _recommend(arguments: argparse.Namespace) -> None:
    options = {key: getattr(arguments, key) for key in ("allowed_error", "quantity", "duration", "folder")}
    table = recommend(arguments.name, **options)
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
        Words of the command line; by default those given to this process.

    Raises
    ------
    SystemExit
        With code 2 after a mistake; one sentence on the standard error output explains it. With code 130 after an
        interrupt.
    """
    parser = _parser()
    words = sys.argv[1:] if arguments is None else list(arguments)
    chosen = parser.parse_args(words, argparse.Namespace(words=words))
    try:
        chosen.function(chosen)
        sys.stdout.flush()
    except BrokenPipeError:
        # a reader such as head has closed the pipe; the rest of the output, written at the exit, is discarded
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return
    except KeyboardInterrupt:
        parser.exit(130, "study: interrupted.\n")
    except (UnknownName, TypeError, ValueError, OSError, ImportError) as error:
        mistake = str(error)
    else:
        return
    parser.exit(2, f"study: {mistake}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
