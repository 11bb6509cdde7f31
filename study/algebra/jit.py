"""Compilation by XLA, with the options for marches."""

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
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

#: Additional option of programs for short runs: LLVM does not optimise them.
_UNOPTIMISED = {"xla_backend_optimization_level": 0}
_short = False


@contextmanager
def short_runs() -> Iterator[None]:
    """Compile without optimisation, for runs of few steps; also a decorator.

    Programs compile in about half the time, and a step takes up to ten times as long, so that a run with less than some
    ten thousand steps gains. Its results equal those of an optimised program to round-off. The functions called within
    this context must not run in several threads of which some are outside of it.
    """
    global _short
    previous, _short = _short, True
    try:
        yield
    finally:
        _short = previous


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

    # at the first call and not at import, because the trial of the options compiles a function
    @functools.cache
    def compiled(short: bool):
        options = _known_options() | (_UNOPTIMISED if short else {})
        return compiler(function, compiler_options=options, **arguments)

    @functools.wraps(function)
    def called(*args, **kwargs):
        reads = reads_of(function, *args, *kwargs.values())
        if not reads.certain:
            with suppress(Exception), reading(reads):  # a function that JAX cannot trace raises below, too
                reads = reads_of_program(eqx.filter_make_jaxpr(function)(*args, **kwargs)[0])
        with reading(reads):
            return compiled(_short)(*args, **kwargs)

    return called
