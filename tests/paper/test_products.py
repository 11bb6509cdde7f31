"""Declarations of the products of the paper, and their requirements on the configuration."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
import yaml
from snakemake.utils import update_config

import paper
from paper import products
from paper.products import Product, check, content_of, discover, figure, table
from paper.requirements import rising
from pipeline.configuration import complete
from study.io import SOURCE

CONFIG = Path(__file__).parent.parent.parent / "config"
FOUND = discover()


@pytest.fixture
def empty(monkeypatch):
    """No product is declared; products that a test declares are removed after it."""
    monkeypatch.setattr(products, "PRODUCTS", {})


def test_all_products_are_found():
    kinds = [product.kind for product in FOUND]
    assert set(kinds) == {"claim", "figure", "numbers", "page", "table", "text"}
    assert kinds.count("figure") >= 30 and kinds.count("table") >= 12 and kinds.count("page") == 3
    assert all(product.caption for product in FOUND if product.kind in ("figure", "page", "claim"))
    # verdicts of the conformance kit are part of the repository; all other products except texts read results
    without = {product.module for product in FOUND if not product.files and product.kind != "text"}
    assert without == {"paper.numbers.other_programs", "paper.tables.other_programs"}


def test_finding_them_takes_no_jax():
    code = "import sys; from paper.products import discover; discover(); print({'jax'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "set()"


def test_a_name_stands_for_one_product(empty):
    table(name="own")(lambda data: None)
    with pytest.raises(ValueError, match="table 'own' is declared twice"):
        table(name="own")(lambda data: None)
    figure("Of the same name.", name="own")(lambda data: None)


def test_an_argument_takes_the_dataset_of_its_name_or_another(empty):
    table(name="own", portrait="phase_portrait/hardening")(lambda spectral, portrait: None)
    assert products.PRODUCTS["table", "own"].files == ["spectral.nc", "phase_portrait/hardening.nc"]
    with pytest.raises(
        ValueError, match=r"The datasets given do not fit .*: got an unexpected keyword argument 'other'"
    ):
        table(name="other", other="x")(lambda data: None)


def test_a_key_that_must_be_a_list_is_named():
    product = Product("table", "own", "here", lambda: None, {}, "", {"energy_error.periods": [100]})
    with pytest.raises(ValueError, match="energy_error.periods must be a list for table 'own', not 100."):
        check([product], {"energy_error": {"periods": 100}})


def test_datasets_come_by_name():
    product = Product("table", "own", "here", lambda b, a: (a, b), {"a": "x", "b": ["y", "z.csv"]}, "", {})
    assert product.files == ["x.nc", "y.nc", "z.csv"]
    assert content_of(product, str.upper) == ("X", ["Y", "Z.CSV"])


@pytest.mark.parametrize(
    "requires, sentence",
    [
        ({"runs.periods": [3]}, "runs.periods lacks 3, which table 'own' needs."),
        ({"runs.lengths.problem": ["b", "c"]}, "runs.lengths.problem lacks 'c', which table 'own' needs."),
        ({"runs.scheme": "rk4"}, "runs.scheme must be 'rk4' for table 'own', not 'houbolt'."),
        ({"runs.steps": 3}, "runs.steps is missing, and table 'own' needs it."),
        ({"": lambda config: f"{len(config)} is no section"}, "1 is no section."),
        ({"runs.periods": rising}, "runs.periods must be in ascending order, not [100, 1]."),
    ],
)
def test_what_is_asked(requires, sentence):
    config = {"runs": {"periods": [100, 1], "lengths": [{"problem": "a"}, {"problem": "b"}], "scheme": "houbolt"}}
    met = {"runs.periods": [100], "runs.lengths.problem": ["a"], "runs.scheme": "houbolt", "": lambda config: ""}
    check([Product("table", "own", "here", print, {}, "", met)], config)
    with pytest.raises(ValueError) as refusal:
        check([Product("table", "own", "here", print, {}, "", met | requires)], config)
    assert str(refusal.value) == sentence


@pytest.fixture(params=["study.yaml", "full.yaml"])
def config(request) -> dict:
    """Every shipped configuration in turn."""
    settings = yaml.safe_load((CONFIG / "study.yaml").read_text())
    update_config(settings, yaml.safe_load((CONFIG / request.param).read_text()))
    return complete(settings)


def test_what_is_shipped_has_all_that_is_asked(config):
    check(FOUND, config)


@pytest.mark.parametrize(
    "section, change, sentence",
    [
        ("references", {"problems": ["hardening"]}, "references.problems lacks 'softening'"),
        ("structure_history.stiff_soft", {"steps_per_period": 1, "every": 1}, "samples after the start"),
        ("structure_history.stiff_bar", {"problem": "fpu_chain"}, "stiff_bar.problem must be one of elastic_pendulum"),
        ("energy_error", {"periods": 10}, "energy_error.periods must be 100"),
        (
            "large_steps",
            {"step_size_over_period": [0.01, 0.1]},
            "large_steps.step_size_over_period needs a step above 0.2",
        ),
        (
            "large_steps",
            {"step_size_over_period": [0.1, 0.3]},
            "large_steps.step_size_over_period needs a step below 0.05",
        ),
        (
            "large_steps",
            {"step_size_over_period": [0.3, 0.01]},
            "large_steps.step_size_over_period must be in ascending order",
        ),
        ("energy_drift", {"steps_per_period": {"first": 10, "last": 24, "step": 1}}, "leaves out 25"),
        ("energy_drift.steps_per_period", {"step": 5}, "energy_drift.steps_per_period.step must be at most 0.5"),
        ("phase_portrait.hardening", {"duration": 0.05}, "phase_portrait.hardening has a duration of less than"),
        ("atlas", {"schemes": ["rk4", "houbolt"]}, "atlas.schemes"),
        ("atlas.amplitudes", {"first": 1, "last": 2, "count": 3}, "no amplitude within a factor of 3 of the paper's"),
        ("structures", {"lengths": [{"problem": "stiff_soft", "periods": 1}]}, "structures.lengths.problem lacks"),
    ],
)
def test_what_a_product_needs_is_asked(config, section, change, sentence):
    part = config
    for key in section.split("."):
        part = part[key]
    part.update(change)
    with pytest.raises(ValueError, match=sentence):
        check(FOUND, config)


@pytest.mark.parametrize("inner", ["accuracy", "atlas"])
def test_linear_theory_must_have_the_schemes_of_others(config, inner):
    config[inner] = config[inner] | {"schemes": [*config[inner]["schemes"], "own"]}
    with pytest.raises(ValueError, match=rf"spectral\.schemes lacks 'own', which {inner}\.schemes has"):
        check(FOUND, config)


def test_a_figure_is_one_new_file(tmp_path):
    """A list of figures outside their files."""
    shutil.copytree(Path(paper.__file__).parent, tmp_path / "paper", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "paper" / "figures" / "own.py").write_text(
        '"""A figure."""\n'
        "import matplotlib.pyplot as plt\n"
        "from paper.products import figure\n\n\n"
        '@figure("Own.", data="own", requires={"own.steps": [3]})\n'
        "def draw(data):\n"
        "    figure, ax = plt.subplots()\n"
        "    ax.plot(data.u)\n"
        "    return figure\n"
    )
    xr.Dataset({"u": ("t", [1.0, 2.0])}, attrs={"source": SOURCE}).to_netcdf(tmp_path / "own.nc")
    code = (
        "from paper.products import discover\n"
        "print(*[(p.module, p.caption, p.files, p.requires) for p in discover() if p.name == 'own'])"
    )
    environment = {"PYTHONPATH": f"{tmp_path}:{CONFIG.parent}", "PATH": ""}
    result = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert result.stdout.strip() == "('paper.figures.own', 'Own.', ['own.nc'], {'own.steps': [3]})", result.stderr
    command = [sys.executable, "-m", "paper.products", "paper.figures.own", "own", ".", "own.pdf"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert all((tmp_path / f"own{suffix}").stat().st_size > 1000 for suffix in (".pdf", ".png", ".svg"))
    assert b'width="238.32pt"' in (tmp_path / "own.svg").read_bytes()  # the width that the style of the figures sets
    done = subprocess.run([*command, "--width", "90"], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert b'width="255.118' in (tmp_path / "own.svg").read_bytes()
    for width in ("9", "wide"):
        done = subprocess.run(
            [*command, "--width", width], cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert f"'{width}' is not a number of millimetres between 20 and 2000" in done.stderr


def test_a_page_has_no_width():
    with pytest.raises(SystemExit, match=r"page 'explorer' has no width\."):
        products.main("paper.explorer.page", "explorer", ".", "explorer.html", width=90)


def test_an_unknown_product_is_refused_in_a_sentence():
    with pytest.raises(SystemExit, match=r"paper\.tables\.orders declares no product 'order'\."):
        products.main("paper.tables.orders", "order", ".", "order.csv")
