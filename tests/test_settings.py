"""Options of the compiler, and the cache of compiled programs."""

import os
import subprocess
import sys

from study import settings
from study.algebra import jit


def test_a_warning_if_jax_was_in_use_before_the_import():
    code = "import jax.numpy as jnp; jnp.ones(3).sum(); import study"
    environment = {name: value for name, value in os.environ.items() if name != "XLA_FLAGS"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert "JAX has computed something before study was imported" in done.stderr
    assert "XLA_FLAGS='" in done.stderr


def test_an_option_that_xla_does_not_have_is_left_out(monkeypatch):
    known = jit._known_options.__wrapped__()  # a recent XLA lacks the older generator of loops
    assert {"xla_cpu_prefer_vector_width", "xla_cpu_parallel_codegen_split_count"} <= set(known)
    monkeypatch.setattr(jit, "_OPTIONS", {"xla_no_such_option": True} | jit._OPTIONS)
    assert jit._known_options.__wrapped__() == known


def test_a_second_process_compiles_nothing(tmp_path):
    """A compiled program whose key in the cache differs from process to process."""
    code = (
        "import jax, study; hits = []; "
        "jax.monitoring.register_event_listener(lambda name, **_: hits.append(name.rsplit('/', 1)[-1])); "
        "study.run('hardening', 'houbolt', dt=1e-3, steps=10); print(hits.count('cache_misses'))"
    )
    environment = {name: value for name, value in os.environ.items() if name != "JAX_COMPILATION_CACHE_DIR"}
    environment["XDG_CACHE_HOME"] = str(tmp_path)
    misses = [
        int(subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True).stdout)
        for _ in range(2)
    ]
    assert misses[0] > 0 and misses[1] == 0


def test_a_cache_that_has_grown_too_large_loses_its_older_half(tmp_path, monkeypatch):
    for age in range(10):
        (tmp_path / f"program{age}").write_bytes(bytes(100))
        os.utime(tmp_path / f"program{age}", (0, 1000 - age))
    settings._prune(tmp_path)
    assert len(list(tmp_path.glob("program*"))) == 10
    monkeypatch.setattr(settings, "_CACHE_SIZE", 999)
    settings._prune(tmp_path)
    assert len(list(tmp_path.glob("program*"))) == 10, "the size is checked once a day"
    os.utime(tmp_path / "checked", (0, 0))
    settings._prune(tmp_path)
    assert {path.name for path in tmp_path.glob("program*")} == {f"program{age}" for age in range(5)}
