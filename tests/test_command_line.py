"""The command ``study``: its output, its files, and one sentence with exit code 2 for a mistake."""

import subprocess
import sys

import pytest
import xarray as xr

import study
from study.__main__ import main
from tests import small_results

RUN = ["run", "hardening", "rk4", "--dt", "0.0075", "--steps", "20"]


def test_a_run_is_printed(capsys):
    main([*RUN, "--observe", "max_energy_error", "energy_drift"])
    printed = capsys.readouterr().out
    expected = study.run("hardening", "rk4", dt=0.0075, steps=20, observe=["max_energy_error", "energy_drift"])
    assert printed == f"{expected}\n"


def test_a_run_beyond_the_stability_limit_warns(capsys):
    with pytest.warns(RuntimeWarning, match="ωΔt = 9 about u = 0 exceeds 2, the stability limit"):
        main(["run", "softening", "central_difference", "--dt", "0.9", "--steps", "1000"])
    assert "status" in capsys.readouterr().out


def test_a_run_is_written(tmp_path, capsys):
    main([*RUN, "--every", "5", "--output", str(tmp_path / "made" / "one.nc")])
    assert capsys.readouterr().out == ""
    back = study.open_dataset("one", tmp_path / "made")
    assert back.sizes["t"] == 5 and back.attrs["history"].endswith("made by study run")
    xr.testing.assert_equal(back, study.run("hardening", "rk4", dt=0.0075, steps=20, every=5))


def test_names_are_listed(capsys):
    main(["list", "schemes"])
    assert capsys.readouterr().out.split() == list(study.schemes)
    main(["list"])
    printed = capsys.readouterr().out
    for heading, registry in (("problems", study.problems), ("schemes", study.schemes), ("observers", study.observers)):
        assert f"{heading}:\n  " in printed
        assert all(f"\n  {name}\n" in printed for name in registry)


def test_a_recommendation_is_printed(capsys, tmp_path):
    folder = small_results.write_to(tmp_path)
    main(["recommend", "softening", "--allowed-error", "0.01", "--quantity", "displacement", "--folder", str(folder)])
    table = study.recommend("softening", allowed_error=0.01, quantity="displacement", folder=folder)
    assert capsys.readouterr().out == f"{table.to_string()}\n"


def test_an_assessment_is_found_by_its_file(capsys, tmp_path, monkeypatch):
    """`study assess --output mynm` writes mynm.nc, which all of these words name."""
    monkeypatch.chdir(tmp_path)
    study.io.write(small_results.assessment().assign_attrs(source=study.io.SOURCE), "mynm.nc")
    study.io.write(small_results.assessment().assign_attrs(source=study.io.SOURCE), "sub/mynm.nc")
    study.io.write(small_results.assessment().assign_attrs(source=study.io.SOURCE), "sub/other.nc")
    folder_arguments = ["mynm", "--folder", "."], ["mynm", "--folder", "sub"], ["other.nc", "--folder", "sub"]
    ways = ["mynm"], ["mynm.nc"], ["sub/mynm"], ["sub/mynm.nc"], *folder_arguments
    for way in ways:
        main(["recommend", *way, "--allowed-error", "0.01"])
    printed = capsys.readouterr().out
    assert printed == len(ways) * f"{study.recommend('mynm', allowed_error=0.01).to_string()}\n"
    with pytest.raises(SystemExit):
        main(["recommend", "other.nc", "--allowed-error", "0.01"])
    assert "there is no file 'other.nc'; `study assess --output other.nc` writes it." in capsys.readouterr().err


@pytest.mark.parametrize(
    "words, sentence",
    [
        ([*RUN[:2], "newmark_d", *RUN[3:]], "there is no scheme 'newmark_d'; did you mean 'newmark_dissipative'?"),
        ([*RUN[:4], "-1", *RUN[5:]], "dt must be finite and greater than zero, not -1.0."),
        ([*RUN, "--every", "3"], "every must divide the number of steps; 3 does not divide 20."),
        ([*RUN, "--output", "{folder}"], "'{folder}' cannot be written: it is a folder."),
        ([*RUN, "--output", "{folder}/file/one.nc"], "'{folder}/file/one.nc' cannot be written: File exists."),
        (
            ["assess", "hardening", "--time-limit", "3"],
            "--time-limit is an option of a program, not of a problem; leave it out.",
        ),
        (
            ["assess", "--command", "mycode", "--schemes", "a", "b", "--duration", "1", "--quantities", "file.py:name"],
            "--quantities is an option of a problem, not of a program; leave it out.",
        ),
        (
            ["assess", "--command", "mycode", "--schemes", "a", "b", "--duration", "1", "--controller", "pi"],
            "--controller is an option of a problem, not of a program; leave it out.",
        ),
        (
            ["recommend", "hardening", "--allowed-error", "0.01", "--folder", "{folder}"],
            "there is no dataset '{folder}/needs.nc': another folder of results is given as `folder`, "
            "and a dataset of the study is made by `snakemake {folder}/needs.nc` in the folder of its "
            "sources.",
        ),
    ],
)
def test_a_mistake_ends_with_one_sentence(words, sentence, tmp_path, capsys):
    (tmp_path / "file").touch()
    with pytest.raises(SystemExit) as caught:
        main([word.format(folder=tmp_path) for word in words])
    assert caught.value.code == 2
    assert capsys.readouterr().err == f"study: {sentence.format(folder=tmp_path)}\n"


def test_the_package_is_a_command():
    """A wrong command that ends with a traceback."""
    done = subprocess.run([sys.executable, "-m", "study", "run", "hardening"], capture_output=True, text=True)
    assert done.returncode == 2 and "the following arguments are required: SCHEME, --dt, --steps" in done.stderr
    assert "Traceback" not in done.stderr
    done = subprocess.run([sys.executable, "-m", "study", "--version"], capture_output=True, text=True)
    assert done.stdout == f"study {study.__version__}\n"
