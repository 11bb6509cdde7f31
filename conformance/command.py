"""The command: run a code over the cases, print the verdicts and write a report."""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from conformance.judge import CASES, judged
from conformance.report import badge, page, summary, table
from conformance.runners import command_runner, folder_runner, function_runner
from conformance.writers import write


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command to a parser."""
    parser.add_argument("code", nargs="?", metavar="MODULE:FUNCTION", help="a Python function of your code")
    parser.add_argument("--command", metavar="TEXT", help="a command with {case} and {out}, which writes a CSV file")
    parser.add_argument("--collect", type=Path, metavar="FOLDER", help="a folder of CSV files that exist already")
    parser.add_argument("--skip", nargs="+", default=[], metavar="TAG", help="tags of cases to leave out")
    parser.add_argument("--only", nargs="+", default=[], metavar="TAG", help="tags that a case must have")
    parser.add_argument("--tool", default="a code", help="name of the code")
    parser.add_argument("--tool-version", default="", metavar="VERSION", help="version of the code")
    parser.add_argument("--note", default="", metavar="TEXT", help="a sentence on how the code is run")
    parser.add_argument("--output", type=Path, metavar="PATH", help="write PATH.json, PATH.html and the badge PATH.svg")
    parser.add_argument(
        "--inputs", type=Path, metavar="FOLDER", help="write input files of OpenSees, Abaqus, code_aster"
    )


def cases(skip: list[str] | tuple[str, ...] = (), only: list[str] | tuple[str, ...] = ()) -> Iterator[dict[str, Any]]:
    """The cases, sorted by name, that have all tags of ``only`` and none of ``skip``."""
    for file in sorted(CASES.glob("*.json")):
        case = json.loads(file.read_text(encoding="utf-8"))
        if set(only) <= set(case["tags"]) and not set(skip) & set(case["tags"]):
            yield case


def conform(arguments: argparse.Namespace) -> None:
    """Run a code over the cases, print the verdicts and, with ``output``, write a report.

    With ``inputs``, only write input files.

    Raises
    ------
    ValueError
        If not exactly one of function, command and folder is given, if the function, the folder or a tag does not
        exist, if the command is not usable, or if ``only`` and ``skip`` leave no case.
    FileNotFoundError
        If the command cannot be started.
    SystemExit
        With code 1 if a case fails.
    """
    known = {tag for case in cases() for tag in case["tags"]}
    for tag in (*arguments.skip, *arguments.only):
        if tag not in known:
            raise ValueError(f"no case has the tag '{tag}'; tags are {', '.join(sorted(known))}.")
    chosen = list(cases(arguments.skip, arguments.only))
    if not chosen:
        raise ValueError("no case has all tags of --only and none of --skip.")
    if arguments.inputs:
        count = write(chosen, arguments.inputs)
        print(f"written: {count} files in {arguments.inputs}")
        return
    if sum(source is not None for source in (arguments.code, arguments.command, arguments.collect)) != 1:
        raise ValueError("name one code: MODULE:FUNCTION, or --command, or --collect.")
    if arguments.output:
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
    if arguments.code is not None:
        runner = function_runner(arguments.code)
    else:
        runner = folder_runner(arguments.collect) if arguments.command is None else command_runner(arguments.command)
    verdicts = judged(chosen, runner)
    result = summary(verdicts, arguments.tool, arguments.tool_version, arguments.note)
    print(table(verdicts))
    if arguments.output:
        titles = {case["name"]: case["title"] for case in chosen}
        for suffix, text in (
            (".json", json.dumps(result, indent=1, ensure_ascii=False)),
            (".html", page(result, titles)),
            (".svg", badge(result)),
        ):
            arguments.output.with_name(arguments.output.name + suffix).write_text(text + "\n", encoding="utf-8")
    if result["counts"]["fail"]:
        raise SystemExit(1)
