"""Compilation by XLA, with the options for marches."""

import functools
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import equinox as eqx
import jax

from study.algebra.reads import reading, reads_of, reads_of_program

#: Options of XLA for CPUs. The first uses the full width of vector registers, which speeds up ensembles. The second
#: selects the older generator of loops: the newer generator takes one and a half to two times as long to compile a
#: march. The marches of both generators give the same numbers, and their speeds differ by less than a sixth. The third
#: compiles a program as a whole: parts for several threads take a tenth more processor time, and a march is too small
#: to gain from them.
_OPTIONS = {
    "xla_cpu_prefer_vector_width": 512,
    "xla_cpu_use_fusion_emitters": False,
    "xla_cpu_parallel_codegen_split_count": 1,
}


@functools.cache
def _known_options() -> dict[str, Any]:
    """The options that the installed XLA accepts; with an unknown option XLA refuses to compile."""

    def are_known(options: dict[str, Any]) -> bool:
        try:
            jax.jit(lambda: 0, compiler_options=options)()
        except jax.errors.JaxRuntimeError:
            return False
        return True

    # all options in one trial first, because each trial takes a hundredth of a second
    return _OPTIONS if are_known(_OPTIONS) else {n: value for n, value in _OPTIONS.items() if are_known({n: value})}


def jit(function: Callable, compiler: Callable = jax.jit, **arguments: Any) -> Callable:
    """``compiler(function, **arguments)`` with the options for marches.

    Where the search of :mod:`study.algebra.reads` cannot see what is read, the function is traced at each call, and
    compiled only if the trace is new.

    JAX accepts options of XLA only for the outermost compiled function, so the result must not be called within another
    compiled function.

    Parameters
    ----------
    compiler
        ``jax.jit`` or ``equinox.filter_jit``.
    """
    # compiled at the first call and not at import, because the trial of the options compiles a function
    compiled = functools.cache(lambda: compiler(function, compiler_options=_known_options(), **arguments))

    @functools.wraps(function)
    def called(*args, **kwargs):
        reads = reads_of(function, *args, *kwargs.values())
        if not reads.certain:
            with suppress(Exception), reading(reads):  # a function that JAX cannot trace raises below, too
                reads = reads_of_program(eqx.filter_make_jaxpr(function)(*args, **kwargs)[0])
        with reading(reads):
            return compiled()(*args, **kwargs)

    return called
