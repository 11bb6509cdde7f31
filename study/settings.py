"""Settings of this process that importing ``study`` changes, and how to decline them.

``precision``
    JAX computes in double precision (``jax_enable_x64``).
``compiler``
    An option is added to ``XLA_FLAGS``, unless the user has set it. XLA compiles a loop natively only if its body is
    small, and otherwise executes it operation by operation, which is up to ten times slower. The option raises the
    allowed size, so that a whole march is one native loop. A loop with calls of LAPACK, as for many coupled unknowns,
    is never native. XLA reads ``XLA_FLAGS`` when JAX first computes; if JAX has already computed, a warning says so.
``cache``
    Compiled programs are stored for later processes, unless the user has set a cache for JAX. They are stored in the
    user's cache folder, in a folder named after this machine, since another processor may lack instructions. If the
    folder exceeds 1 GiB, the older half of its programs is removed; this is checked once a day.

The environment variable ``STUDY_SETTINGS`` names the settings to make, for instance ``precision,cache``. With ``none``
no setting is made. Without the variable all three settings are made. JAX's own switches keep working:
``with jax.enable_x64(False): study.run(...)`` computes in single precision.

This module does not import JAX, which takes half a second. If JAX is not imported yet, its settings are made as
environment variables, which JAX reads when it is imported, and which child processes inherit.
"""

import os
import platform
import sys
import time
from contextlib import suppress
from pathlib import Path

import platformdirs

from study.warn import warn

_OPTION = "xla_cpu_small_while_loop_byte_threshold"

#: Largest size in bytes of a loop that XLA compiles natively. The loop of a run that is compared with a reference
#: carries a table of some megabytes.
_THRESHOLD = 1 << 24

#: Size of the cache in bytes above which the older half of its programs is removed.
_CACHE_SIZE = 1 << 30

#: Seconds between two checks of the size of the cache. A check inspects every file.
_DAY = 86_400


def _set(option: str, value: bool | float | str) -> None:
    """Set an option of JAX, by its environment variable if JAX is not imported yet."""
    if "jax" in sys.modules:
        sys.modules["jax"].config.update(option, value)
    else:
        os.environ[option.upper()] = str(value)


def _named_settings(variable: str | None) -> tuple[str, ...]:
    """The settings that the value of ``STUDY_SETTINGS`` names; all settings if the value is None or empty."""
    if not variable:
        return tuple(_SETTINGS)
    if variable == "none":
        return ()
    names = tuple(name.strip() for name in variable.split(","))
    for name in names:
        if name not in _SETTINGS:
            raise ImportError(
                f"STUDY_SETTINGS must be 'none' or name some of {', '.join(_SETTINGS)}, not '{variable}'."
            )
    return names


def _with_option(flags: str) -> str:
    """The value of ``XLA_FLAGS`` with the option added, unless it is there already.

    The flag for backend options holds the option. If the value does not have this flag, the flag is added too.
    """
    if _OPTION in flags:
        return flags
    option, extra = f"{_OPTION}={_THRESHOLD}", "--xla_backend_extra_options="
    if extra in flags:
        return flags.replace(extra, f"{extra}{option},")
    return f"{flags} {extra}{option}".strip()


def _has_computed() -> bool:
    """Whether JAX has computed something in this process.

    No public function of JAX reports this. It follows from a change of the number of CPU devices, which JAX refuses
    after its first computation.
    """
    if "jax" not in sys.modules:
        return False
    config = sys.modules["jax"].config
    before = config.jax_num_cpu_devices
    try:
        config.update("jax_num_cpu_devices", 2 if before == 1 else 1)
    except RuntimeError:
        return True
    config.update("jax_num_cpu_devices", before)
    return False


def _set_compiler() -> None:
    flags = _with_option(os.environ.get("XLA_FLAGS", ""))
    if flags != os.environ.get("XLA_FLAGS") and _has_computed():
        warn(
            "JAX has computed something before study was imported, and ignores the option that makes a march one "
            f"native loop: runs take up to ten times longer. Import study first, or set XLA_FLAGS='{flags}'."
        )
    os.environ["XLA_FLAGS"] = flags


def _prune(cache: Path) -> None:
    """Remove the older half of the programs if the cache exceeds ``_CACHE_SIZE``; this is checked once a day.

    JAX's own limit is not used, because it inspects every file whenever a program is added; with ten thousand files
    that takes a third of a second.
    """
    checked = cache / "checked"
    if checked.exists() and abs(time.time() - checked.stat().st_mtime) < _DAY:
        return
    programs = (entry for entry in os.scandir(cache) if entry.name != checked.name)
    files = [(entry.stat().st_mtime, entry.stat().st_size, entry.path) for entry in programs]
    if sum(size for _, size, _ in files) > _CACHE_SIZE:
        for _, _, path in sorted(files)[: len(files) // 2]:
            Path(path).unlink(missing_ok=True)
    checked.touch()


def _set_cache() -> None:
    option = "jax_compilation_cache_dir"
    if getattr(sys.modules["jax"].config, option) if "jax" in sys.modules else os.environ.get(option.upper()):
        return
    cache = platformdirs.user_cache_path("time-integration-study") / platform.node()
    # The folder may not exist yet, may belong to another user, or another process may be removing programs from it. JAX
    # reports a folder that it cannot use.
    with suppress(OSError):
        _prune(cache)
    _set(option, str(cache))
    # keep every program: even the smallest takes a tenth of a second to compile
    _set("jax_persistent_cache_min_compile_time_secs", 0.0)
    _set("jax_persistent_cache_min_entry_size_bytes", 0)


def cores() -> int:
    """Number of cores that a run may use: ``OMP_NUM_THREADS``, which Snakemake sets for its jobs, or all cores."""
    granted = os.environ.get("OMP_NUM_THREADS", "")
    if granted.isdigit() and int(granted):
        return int(granted)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


_SETTINGS = {
    "precision": lambda: _set("jax_enable_x64", True),
    "compiler": _set_compiler,
    "cache": _set_cache,
}

for _name in _named_settings(os.environ.get("STUDY_SETTINGS")):
    _SETTINGS[_name]()
