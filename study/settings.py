"""What JAX must know before it compiles anything: double precision, one native loop for a whole march, and a cache.

XLA's CPU compiler turns a loop into one native loop only while the loop's body is small, and walks it operation by
operation (up to ten times slower) otherwise. The threshold is raised here; a call of LAPACK, as more than one unknown
takes, is no part of such a loop. Vector registers are used in their full width, which ensembles gain from. Loops come
from XLA's older generator: the newer one takes half as long again to compile a march, and twice as long where schemes
iterate on several unknowns, for the same numbers at a speed within a sixth, more or less.

What has been compiled is kept for the next process, in a folder of this machine alone, as another processor may lack
instructions. Whatever the user has set in ``XLA_FLAGS`` or as JAX's cache stands.
"""

import os
import platform
import warnings
from contextlib import suppress
from pathlib import Path

import jax
import platformdirs
from jax._src import xla_bridge

_OPTION = "xla_cpu_small_while_loop_byte_threshold"

_THRESHOLD = 1 << 20

_FLAGS = ("--xla_cpu_prefer_vector_width=512", "--xla_cpu_use_fusion_emitters=false")

#: Bytes of programs in the cache, at most, when a process starts.
_CACHE_SIZE = 1 << 30


def _with_options(flags: str) -> str:
    """Add ours to a value of ``XLA_FLAGS``, next to backend options that are already there."""
    flags = " ".join([flags, *(flag for flag in _FLAGS if flag.partition("=")[0] not in flags)])
    if _OPTION in flags:
        return flags
    option, extra = f"{_OPTION}={_THRESHOLD}", "--xla_backend_extra_options="
    if extra in flags:
        return flags.replace(extra, f"{extra}{option},")
    return f"{flags} {extra}{option}".strip()


def _prune(cache: Path) -> None:
    """Remove the older half of the programs of a cache that has grown too large.

    JAX's own bound looks at every file whenever it adds one, a third of a second once there are ten thousand.
    """
    files = [(entry.stat().st_mtime, entry.stat().st_size, entry.path) for entry in os.scandir(cache)]
    if sum(size for _, size, _ in files) > _CACHE_SIZE:
        for _, _, path in sorted(files)[: len(files) // 2]:
            Path(path).unlink(missing_ok=True)


_flags = _with_options(os.environ.get("XLA_FLAGS", ""))


# the flags are read once, with JAX's first computation; that it is over only JAX's own module tells
if _flags != os.environ.get("XLA_FLAGS") and xla_bridge.backends_are_initialized():
    warnings.warn(
        "JAX has computed something before study was imported, and ignores the options that make a march one native "
        f"loop: runs take up to seven times longer. Import study first, or set XLA_FLAGS='{_flags}'.",
        RuntimeWarning,
        stacklevel=2,
    )


os.environ["XLA_FLAGS"] = _flags


jax.config.update("jax_enable_x64", True)


if jax.config.jax_compilation_cache_dir is None:  # type: ignore[attr-defined]
    cache = platformdirs.user_cache_path("time-integration-study") / platform.node()
    # a folder that is not there yet, that another process prunes too, or that is not ours: JAX tells what it cannot use
    with suppress(OSError):
        _prune(cache)
    jax.config.update("jax_compilation_cache_dir", str(cache))
    # every program: the least of them takes a tenth of a second
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", 0)
