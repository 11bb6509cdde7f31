"""Contents of an archive, and files that an archive cannot hold."""

import subprocess
from pathlib import Path

import pytest

from pipeline import archive


def test_files_that_are_new_are_packed_and_those_that_git_ignores_are_not(tmp_path):
    subprocess.run(["git", "init", "--quiet"], cwd=tmp_path, check=True)
    (tmp_path / ".gitignore").write_text("results/\n")
    for name in ("study/tracked.py", "study/experiments/mine.py", "results/made.nc", ".password"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    subprocess.run(["git", "add", ".gitignore", "study/tracked.py"], cwd=tmp_path, check=True)
    packed = {file.as_posix() for file in archive.sources(tmp_path)}
    assert packed == {".gitignore", "study/tracked.py", "study/experiments/mine.py"}


@pytest.mark.parametrize("outside", [True, False])
@pytest.mark.parametrize("section", ["assess", "own_schemes", "record_error"])
def test_a_file_outside_of_the_project_is_refused_with_what_to_do(tmp_path, monkeypatch, outside, section):
    (tmp_path / "project").mkdir()
    monkeypatch.chdir(tmp_path / "project")
    (tmp_path / "frame.py").write_text("")
    file = "../frame.py" if outside else str(tmp_path / "frame.py")
    used = {
        "assess": {"a": {"problem": f"{file}:f"}},
        "own_schemes": [f"{file}:mine"],
        "record_error": {"folder": str(Path(file).parent)},
    }
    with pytest.raises(
        SystemExit, match=rf"the configuration names '{file}', which an archive cannot hold: put the file"
    ):
        archive.own_files({section: used[section]})


def test_what_is_hidden_is_no_product(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("site/index.html", ".site.1.ab.unfinished/index.html", "x.nc"):
        Path("results", name).parent.mkdir(parents=True, exist_ok=True)
        Path("results", name).write_text("")
    assert archive.products() == [Path("results/site/index.html"), Path("results/x.nc")]
