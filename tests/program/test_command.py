"""Programs that are executables: their output, their failures, and the example in C."""

import contextlib
import io
import shutil
import stat
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

import study
from study.__main__ import main
from study.program import search
from study.program.attempt import attempt
from study.program.command import command
from study.scheme.codes import names_in_codes, steps_in_decks
from tests.program import models

PROJECT = Path(__file__).parents[2]
WORDS = "--dt {dt} --scheme {scheme} --output {output}"


@pytest.fixture
def script(tmp_path):
    """Function that makes a program from the lines of a shell script, in which $6 is the output file."""

    def make_program(lines, **options):
        path = tmp_path / "mycode"
        path.write_text(f"#!/bin/sh\n{lines}\n")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        return command(f"{path} {WORDS}", ["a", "b"], 4.0, **{"folder": tmp_path / "runs"} | options)

    return make_program


@pytest.mark.parametrize(
    "lines, status, reason",
    [
        ("exit 0", "nothing", "it wrote nothing to {output}"),
        ("echo t,u > $6", "nothing", "its output has a header and no row"),
        ("echo 1,2 > $6; exit 3", "exit_code", "it ended with the exit code 3"),
        ("echo no convergence at step 7 >&2; exit 1", "exit_code", "it ended with the exit code 1: no convergence at"),
        ("kill -SEGV $$", "signal", "the signal SIGSEGV ended it"),
        ("sleep 60", "timed_out", "it was stopped after 0.2 s"),
        (r"printf 't,u\n0,1\n2,1e200\n4,1\n' > $6", "not_finite", "'u' grows to 1e+200"),
        (r"printf 't,u\n0,1\n2,nan\n4,3\n' > $6", "not_finite", "'u' is not finite at t = 2 s"),
        (r"printf 't,u\n0,1\n2,3\n5,2\n' > $6", "unequal_times", "its times are 2 s apart, and 3 s after t = 2 s"),
        (r"printf 't,u\n0,1\n2,much\n4,3\n' > $6", "unusable", "'u' must be numbers (could not"),
        (r"printf 'u\n0\n2\n' > $6", "unusable", "its output has no column 't'"),
    ],
)
def test_a_run_that_goes_wrong_has_a_reason(script, lines, status, reason):
    program = script(lines, time_limit=0.2 if status == "timed_out" else None)
    run = attempt(program.run, "a", 2.0, program.duration)
    assert run.status == status and run.reason.startswith(reason)


_DECK = """** step of {dt} s
*{scheme}
{dt}, {duration}
*PARAMETER {other}
"""


def test_an_input_file_takes_the_values_of_each_run(tmp_path):
    """The program keeps a copy of its input file."""
    (tmp_path / "bridge.inp").write_text(_DECK)
    script = tmp_path / "mycode"
    script.write_text(f"#!/bin/sh\ncp $1 {tmp_path}/read.inp\nprintf 't,u\\n0,1\\n2,3\\n4,5\\n' > $2\n")
    script.chmod(script.stat().st_mode | stat.S_IXUSR)
    options = {"schemes": ["DYNAMIC, ALPHA=0", "DYNAMIC, ALPHA=-0.1"], "duration": 4.0, "deck": tmp_path / "bridge.inp"}
    program = command(f"{script} {{deck}} {{output}}", **options)
    run = attempt(program.run, "DYNAMIC, ALPHA=0", 2.0, program.duration)
    assert run.values["u"].tolist() == [1, 3, 5]
    text = (tmp_path / "read.inp").read_text()
    assert text == "** step of 2.0 s\n*DYNAMIC, ALPHA=0\n2.0, 4.0\n*PARAMETER {other}\n"
    source = program.run.source  # type: ignore[attr-defined]
    (tmp_path / "bridge.inp").write_text(_DECK + "*DENSITY\n")
    assert command(f"{script} {{deck}} {{output}}", **options).run.source != source  # type: ignore[attr-defined]


@pytest.mark.parametrize("row", [row for row in steps_in_decks() if row.line], ids=lambda row: row.code)
def test_the_line_of_a_code_takes_the_step(row, tmp_path):
    """The input file of each code has its line of the scheme, the line before the step and the line with the step."""
    line = next(name.name for name in names_in_codes() if row.code.startswith(name.code))
    (tmp_path / "bridge").write_text(f"{{scheme}}\n{row.after}\n{row.line}\n")
    (tmp_path / "mycode").write_text(f"#!/bin/sh\ncp $1 {tmp_path}/read\nprintf 't,u\\n0,1\\n2,3\\n4,5\\n' > $2\n")
    (tmp_path / "mycode").chmod(0o755)
    program = command(f"{tmp_path}/mycode {{deck}} {{output}}", [line, "other"], 4.0, deck=tmp_path / "bridge")
    assert attempt(program.run, line, 0.125, 4.0).completed
    scheme, *rest = (tmp_path / "read").read_text().splitlines()
    assert scheme == line and rest == [row.after, row.line.replace("{dt}", "0.125").replace("{duration}", "4.0")]


@pytest.mark.parametrize(
    "words, text, sentence",
    [
        ("{output}", _DECK, "the command lacks {deck}, the place of the input file"),
        ("{deck} {output}", "{scheme}", "the command and 'bridge.inp' lack {dt}, which each run replaces"),
    ],
)
def test_an_input_file_needs_its_places(words, text, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("bridge.inp").write_text(text)
    with pytest.raises(ValueError) as raised:
        command(f"sh {words}", ["a"], 4.0, deck="bridge.inp")
    assert sentence in str(raised.value)
    with pytest.raises(FileNotFoundError):
        command(f"sh {words}", ["a"], 4.0, deck="nowhere.inp")


def test_single_numbers_need_no_times(script):
    run = attempt(script(r"printf 'peak, drift\n1.5, 2\n' > $6").run, "a", 2.0, 4.0)
    assert run.completed and run.values == {"peak": 1.5, "drift": 2.0}


def test_a_scheme_that_hangs_is_run_once(script):
    """A run that was stopped is repeated once per assessment, and replaced if the time limit is longer."""
    program = script("sleep 60", time_limit=0.2)
    with pytest.raises(ValueError, match="no reference for 'mycode'.* 'a' and 'b' end at Δt = 0.25 s: it was stopped"):
        study.assess(program)
    kept = list(program.place.rglob("*.npz"))
    assert len(kept) == 2
    longer = replace(program, run=replace(program.run, time_limit=0.3))
    with pytest.raises(ValueError, match=r"it was stopped after 0.3 s"):
        study.assess(longer)
    assert list(program.place.rglob("*.npz")) == kept


def test_an_unfit_command_is_refused():
    with pytest.raises(ValueError, match=r"the command lacks \{output\}, which each run replaces by its value"):
        command("./mycode {dt} {scheme}", ["a", "b"], 4.0)
    with pytest.raises(ValueError, match="cannot be split into words: No closing quotation"):
        command("./mycode '{dt} {scheme} {output}", ["a", "b"], 4.0)
    with pytest.raises(ValueError, match="time_limit must be a time in s greater than zero, not -1."):
        command("sh {dt} {scheme} {output}", ["a", "b"], 4.0, time_limit=-1)
    with pytest.raises(FileNotFoundError, match="there is no executable './mycode'"):
        command("./mycode {dt} {scheme} {output}", ["a", "b"], 4.0)


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_the_example_in_c_is_assessed(tmp_path, monkeypatch):
    """The assessment of the example equals that of the same oscillator in Python."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    # otherwise the number of confirming runs would depend on the computing time of a run
    monkeypatch.setattr(search, "MOST_CONFIRMING", search.FEWEST_CONFIRMING)
    source, executable = PROJECT / "examples" / "oscillator.c", tmp_path / "oscillator"
    subprocess.run(["cc", "-O2", "-Wall", "-Werror", "-o", executable, source, "-lm"], check=True)
    words = ["assess", "--command", f"{executable} {WORDS}", "--schemes", ",".join(models.SCHEMES), "--duration", "10"]
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        main([*words, "--allowed-error", "0.01", "--output", str(tmp_path / "assessed")])
    ds = study.io.read(tmp_path / "assessed.nc")
    assert "For 1\u00a0% of velocity: " in printed.getvalue() and (tmp_path / "assessed.html").is_file()
    assert (ds.verdict == 0).all() and ds.attrs["problem"] == "oscillator"
    program = study.Program(models.hardening, models.SCHEMES, 10.0, folder=tmp_path, workers=1, coarsest=0.625)
    monkeypatch.setattr(models, "DURATION", 10.0)
    expected = study.assess(program, allowed_errors=[0.01])
    assert ds.recommended_step_size.values == pytest.approx(expected.recommended_step_size.values)
    assert ds.recommended_error.values == pytest.approx(expected.recommended_error.values, rel=1e-6)
