"""Blocks of code in texts, run as their readers run them."""

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
    """Blocks of code in one language."""
    fenced = re.findall(r"^```([^\n]*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    return [block for written_in, block in fenced if written_in == language]


def commands(text: str) -> list[list[str]]:
    """Words of the commands of ``study`` in a text."""
    lines = "".join(blocks(text, "sh")).splitlines()
    return [line.split("#")[0].split()[1:] for line in lines if line.startswith(".venv/bin/study ")]


def run_examples(text: str, name: str, folder: Path, monkeypatch: Any) -> dict:
    """Run the blocks of Python in order next to small results, under JAX's default rules; return what they define."""
    small_results.write_to(folder / "results")
    monkeypatch.chdir(folder)
    matplotlib.use("agg")
    seen: dict = {}
    with jax.numpy_rank_promotion("allow"), jax.numpy_dtype_promotion("standard"):
        for number, block in enumerate(blocks(text, "python"), start=1):
            exec(compile(block, f"{name}, example {number}", "exec"), seen)
    return seen


def run_command(words: list[str], folder: Path) -> None:
    """Run a command of ``study`` next to small results and the examples."""
    small_results.write_to(folder / "results")
    (folder / "examples").symlink_to(PROJECT / "examples")
    command = [sys.executable, "-m", "study", *words]
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]
