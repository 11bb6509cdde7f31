"""What JAX must know before it compiles anything: double precision, and one native loop for a whole march.

XLA's CPU compiler turns a loop into one native loop only while the loop's body is small, and walks it operation by
operation (ten times slower) otherwise. The threshold is raised here; whatever the user has set in ``XLA_FLAGS`` stands.
"""

import os

import jax

_OPTION = "xla_cpu_small_while_loop_byte_threshold"
_THRESHOLD = 1 << 20


def _with_threshold(flags: str) -> str:
    """Add the threshold to a value of ``XLA_FLAGS``, next to backend options that are already there."""
    if _OPTION in flags:
        return flags
    option, extra = f"{_OPTION}={_THRESHOLD}", "--xla_backend_extra_options="
    if extra in flags:
        return flags.replace(extra, f"{extra}{option},")
    return f"{flags} {extra}{option}".strip()


os.environ["XLA_FLAGS"] = _with_threshold(os.environ.get("XLA_FLAGS", ""))
jax.config.update("jax_enable_x64", True)
