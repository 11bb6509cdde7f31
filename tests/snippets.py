"""Blocks of code in texts, and functions that run them as a reader would."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import matplotlib

from tests import small_results

PROJECT = Path(__file__).parent.parent


def blocks(text: str, language: str) -> list[str]:
    """Blocks of code of a text in one language."""
    fenced = re.findall(r"^```([^\n]*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    return [block for written_in, block in fenced if written_in == language]


def commands(text: str) -> list[list[str]]:
    """Arguments of each command ``study`` in the shell blocks of a text."""
    lines = "".join(blocks(text, "sh")).splitlines()
    return [line.split("#")[0].split()[1:] for line in lines if line.startswith(".venv/bin/study ")]


def run_examples(text: str, name: str, folder: Path, monkeypatch: Any) -> dict:
    """Run the Python blocks in order, with small results in a folder and JAX's default rules. Return all variables."""
    small_results.write_to(folder / "results")
    monkeypatch.chdir(folder)
    matplotlib.use("agg")
    seen: dict = {}
    with jax.numpy_rank_promotion("allow"), jax.numpy_dtype_promotion("standard"):
        for number, block in enumerate(blocks(text, "python"), start=1):
            exec(compile(block, f"{name}, example {number}", "exec"), seen)
    return seen


def run_command(words: list[str], folder: Path) -> None:
    """Run a command of ``study`` in a folder of small results and the examples, and check that it succeeds."""
    small_results.write_to(folder / "results")
    (folder / "examples").symlink_to(PROJECT / "examples")
    command = [sys.executable, "-m", "study", *words]
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]
