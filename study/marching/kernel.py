"""Lanes on a GPU: the whole loop over the steps of a block of lanes in one kernel.

XLA runs each step on a GPU as several kernels, which pass the state of all lanes through memory, and a Newton iteration
adds more of them. Here the step of one lane is traced once and evaluated component by component
(:mod:`study.marching.components`), inside a kernel of ``jax.experimental.pallas`` that Triton compiles. A component is
an array of a block of lanes, so that a thread keeps the state of its lane in registers from the first step to the last.
The formulas of schemes, problems and observers are unchanged.

Arrays that all lanes share, such as a mass, are arguments of the kernel, and so are the arguments of each lane. A
*table* is an array of more than ``MOST_ENTRIES`` entries, such as a record of ground motion, that stays in memory. An
operation on it is delayed until one of its entries is needed, which then takes one load from each table that the entry
depends on.

Pallas is experimental and used in this module alone. If an operation has no rule here, if a kernel has too many
operations, or if Pallas or Triton refuse it, lanes march step by step, and one line in the log (``logging``, level
``INFO``) names the reason.

The operations of a lane, and their order, are those of a single run; the results agree to round-off. Triton takes the
larger of a number and NaN to be the number; a kernel takes it to be NaN, as everywhere else.
"""

import functools
import logging
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.extend import core

from study.marching.components import ELEMENTWISE, MOST_ENTRIES, MOST_UNKNOWNS, Lanes, NoRule, Whole, objects

#: Largest number of lanes of a block; a power of two. Each thread has one lane. A multiprocessor holds at most 32
#: blocks, and the lanes of a large block wait for each other in Newton's iteration.
BLOCK = 64

#: Largest number of operations of a kernel. Triton takes some 2 to 5 ms of CPU time to compile one of them.
MOST_OPERATIONS = 5000

#: Number of threads of a warp.
WARP = 32

#: Logger of lanes that march without a kernel.
LOG = logging.getLogger(__name__)

#: An entry of an array: its index along each axis, numbers or integer arrays of all lanes.
Place = tuple[Any, ...]


def is_chosen(unknowns: int) -> bool:
    """Whether lanes with this number of unknowns march in kernels."""
    if jax.default_backend() != "gpu":
        return False
    if unknowns > MOST_UNKNOWNS:
        report(f"takes at most {MOST_UNKNOWNS} unknowns")
    return unknowns <= MOST_UNKNOWNS


def report(reason: str) -> None:
    """Log why lanes march without a kernel."""
    LOG.info("Lanes march step by step on the GPU, because a kernel %s.", reason)


def advanced(step: Callable, lanes: Any, others: Any, begin: Any, end: Any, patience: int, interpret: bool) -> Any:
    """``lanes`` after the steps with the numbers from ``begin`` to ``end`` - 1, or None if a kernel is refused.

    Parameters
    ----------
    step
        Function of the number of a step, and of ``lanes`` and ``others`` of one lane. It returns ``lanes`` after the
        step, and whether the lane goes on.
    lanes, others
        Trees of arrays with an axis of lanes in front: those that a step may change, and constant ones.
    patience
        Number of steps of a block between two checks whether any of its lanes goes on.
    interpret
        Whether JAX interprets the kernel, for tests on a CPU, instead of compiling it.
    """
    leaves, tree = jax.tree.flatten((lanes, others))
    shapes = [jax.ShapeDtypeStruct(x.shape[1:], x.dtype) for x in leaves]
    program = jax.make_jaxpr(lambda k, *x: jax.tree.leaves(step(k, *jax.tree.unflatten(tree, x))))(begin, *shapes)
    count = len(leaves[0])
    kernel = _Kernel(
        program, [_filled(x, min(BLOCK, 1 << (count - 1).bit_length())) for x in leaves], patience, interpret
    )
    arguments, call = kernel.arguments(begin, end), jax.jit(kernel.call)
    try:
        traced = call.trace(*(jax.ShapeDtypeStruct(x.shape, x.dtype) for x in arguments))
        if (size := _size(traced.jaxpr)) > MOST_OPERATIONS:
            report(f"of {size} operations takes long to compile")
            return None
        if not interpret:
            traced.lower(lowering_platforms=("cuda",))
    except NoRule as error:
        report(f"has no rule for the operation '{error}'")
        return None
    except Exception as error:  # Pallas raises exceptions of any kind
        report_refusal(error)
        return None
    results = [leaf[:count] for leaf in kernel.results(call(*arguments))]
    return jax.tree.unflatten(jax.tree.structure(lanes), results)


def _filled(leaf: jax.Array, block: int) -> jax.Array:
    """A leaf of lanes in whole blocks: copies of the last lane fill the last block."""
    missing = -len(leaf) % block
    return jnp.concatenate([leaf, jnp.repeat(leaf[-1:], missing, axis=0)]) if missing else leaf


def report_refusal(error: Exception) -> None:
    """Log that Pallas or Triton refuse a kernel."""
    report(f"is refused: {type(error).__name__}: {(str(error).splitlines() or [''])[0]}")


class _Table(Whole):
    """An array of one lane in all lanes whose entries are computed or loaded where an operation needs them.

    ``at`` is a function of the place of an entry, which returns the component there.
    """

    def __init__(self, shape: tuple[int, ...], at: Callable[[Place], Any]):
        self.shape, self.at = shape, at

    @property
    def array(self):  # type: ignore[override]
        """A table has no array."""
        raise NoRule(f"array of {math.prod(self.shape)} entries")


class _Kernel:
    """The kernel of a program of one lane."""

    def __init__(self, program: Any, leaves: Sequence[jax.Array], patience: int, interpret: bool):
        self._program, self._leaves, self._patience, self._interpret = program, leaves, patience, interpret
        self._count = len(program.jaxpr.outvars) - 1
        self._lanes = len(leaves[0])
        self._block = math.gcd(self._lanes, BLOCK)
        _, *invars = program.jaxpr.invars
        *outvars, _ = program.jaxpr.outvars
        read = {id(x) for operation in program.eqns for x in operation.invars}
        #: Numbers of the leaves that a step changes, and of all that the kernel takes.
        self._changed = [k for k, (new, old) in enumerate(zip(outvars, invars, strict=False)) if new is not old]
        self._taken = [k for k, x in enumerate(invars) if k in self._changed or id(x) in read]
        #: Arrays that all lanes share and that are arguments of the kernel.
        self._shared = list({id(x): x for x in _constants(program) if _is_argument(x)}.values())

    def arguments(self, begin: Any, end: Any) -> list[jax.Array]:
        """The arguments of :meth:`call`."""
        columns = [column for k in self._taken for column in self._columns(self._leaves[k])]
        shared = [_number(jnp.ravel(x)) for x in self._shared]
        return [jnp.stack([jnp.asarray(x, int) for x in (begin, end)]), *shared, *columns]

    def results(self, columns: Sequence[jax.Array]) -> list[jax.Array]:
        """All changeable leaves, from the components that :meth:`call` returns."""
        new, rest = list(self._leaves[: self._count]), iter(columns)
        for k in self._changed:
            leaf = self._leaves[k]
            parts = [next(rest) for _ in range(math.prod(leaf.shape[1:]))]
            new[k] = jnp.stack(parts, axis=1).reshape(leaf.shape).astype(leaf.dtype)
        return new

    def call(self, *arguments: jax.Array) -> list[jax.Array]:
        """Components of the changed leaves after the steps."""
        from jax.experimental import pallas
        from jax.experimental.pallas import triton

        each = pallas.BlockSpec((self._block,), lambda block: (block,))
        columns = range(1 + len(self._shared), len(arguments))
        specs = [
            each if k in columns and x.size == self._lanes else pallas.BlockSpec(x.shape, lambda block: (0,))
            for k, x in enumerate(arguments)
        ]
        outputs = [
            jax.ShapeDtypeStruct((self._lanes,), _number_type(leaf.dtype))
            for leaf in map(self._leaves.__getitem__, self._changed)
            for _ in range(math.prod(leaf.shape[1:]))
        ]
        return pallas.pallas_call(
            self._body,
            out_shape=outputs,
            grid=(self._lanes // self._block,),
            in_specs=specs,
            out_specs=[each] * len(outputs),
            interpret=self._interpret,
            compiler_params=triton.CompilerParams(num_warps=max(1, self._block // WARP)),
        )(*arguments)

    def _body(self, *refs: Any) -> None:
        """The kernel: its arguments and results are references."""
        from jax.experimental import pallas

        jaxpr, rest = self._program.jaxpr, iter(refs)
        bounds = next(rest)
        begin, end = bounds[0], bounds[1]
        constants = {id(x): _shared(x, next(rest), self._block) for x in self._shared}
        lane = pallas.program_id(0) * self._block + jnp.arange(self._block, dtype=np.int32)
        values: list = [None] * len(self._leaves)
        for k in self._taken:
            values[k] = self._value(self._leaves[k], rest, lane)
        block = _Block(self._block, constants)
        types = [jaxpr.invars[k + 1].aval for k in self._changed]

        def turn(k, state):
            components, before = iter(state[0]), list(values)
            for place, of in zip(self._changed, types, strict=True):
                before[place] = objects([next(components) for _ in range(math.prod(of.shape))], of.shape)
            *after, goes_on = block.results(self._program, [objects([lax.broadcast(k, (self._block,))], ()), *before])
            changed = [block.components(after[place], of) for place, of in zip(self._changed, types, strict=True)]
            return [x for entries in changed for x in entries], block.components(goes_on, jaxpr.outvars[-1].aval)[0]

        def turns(progress):
            first, state = progress
            last = jnp.minimum(first + self._patience, end)
            return last, lax.fori_loop(first, last, turn, state)

        start = [x for k in self._changed for x in values[k].flat], jnp.ones(self._block, bool)
        _, (components, _) = lax.while_loop(lambda p: (p[0] < end) & _any(p[1][1]), turns, (begin, start))
        for ref, component in zip(rest, components, strict=True):
            ref[...] = _number(component)

    def _columns(self, leaf: jax.Array) -> list[jax.Array]:
        """A leaf as components, or as one table with the lanes along the last axis."""
        rows = _number(leaf).reshape(self._lanes, -1)
        if rows.shape[1] > MOST_ENTRIES:
            return [rows.T.ravel()]
        return [rows[:, k] for k in range(rows.shape[1])]

    def _value(self, leaf: jax.Array, refs: Iterator, lane: jax.Array) -> Any:
        shape = leaf.shape[1:]
        size = math.prod(shape)
        if size > MOST_ENTRIES:
            ref = next(refs)
            # neighbouring lanes that load entries of the same number load neighbouring numbers
            return _Table(shape, lambda place: _loaded(ref, _along(place, shape), size, leaf.dtype, self._lanes, lane))
        return objects([next(refs)[...].astype(leaf.dtype) for _ in range(size)], shape)


class _Block(Lanes):
    """The evaluation of programs of one lane in a block of lanes, within a kernel, where all loops are written out."""

    most_written_out = MOST_OPERATIONS

    def __init__(self, lanes: int, constants: dict[int, Any]):
        super().__init__(lanes)
        self._constants = constants

    def components(self, value: Any, of: Any) -> list[jax.Array]:
        """All components of a value, each an array (lanes,)."""
        entries = [self.entry(value, place) for place in np.ndindex(of.shape)]
        return [self._full(jnp.asarray(x, of.dtype)) for x in entries]

    def entry(self, value: Any, place: Place) -> Any:
        """The component of a value at a place."""
        if isinstance(value, _Table):
            return value.at(place)
        known = tuple(k if isinstance(k, int) else slice(None) for k in place)
        rest = [k for k in place if not isinstance(k, int)]
        entries = value[known]
        if not rest:
            return entries
        number = _along(tuple(rest), entries.shape)
        return functools.reduce(
            lambda x, k: jnp.where(number == k, entries.flat[k], x), range(1, entries.size), entries.flat[0]
        )

    def _constant(self, array: Any) -> Any:
        return self._constants[id(array)] if id(array) in self._constants else np.asarray(array)

    def _alone(self, operation: Any, values: list) -> list:
        if any(math.prod(of.aval.shape) > MOST_ENTRIES for of in operation.outvars):
            return self._together(operation, values)
        with jax.ensure_compile_time_eval():
            results = operation.primitive.bind(*values, **operation.params)
        return [np.asarray(x) for x in (results if operation.primitive.multiple_results else [results])]

    def _any(self, flags: jax.Array) -> jax.Array:
        return _any(flags)

    def _bound(self, primitive: Any, *operands: Any, **params: Any) -> Any:
        if any(isinstance(x, jax.core.Tracer) for x in operands):
            if primitive.name == "div" and _has_reciprocal(operands[1]):
                # a division takes some twenty times as long as a product
                return lax.mul(*map(self._full, (operands[0], 1 / operands[1])))
            operands = tuple(map(self._full, operands))
            if primitive.name in _WRITTEN_OUT:
                return _WRITTEN_OUT[primitive.name](*operands, **params)
            return primitive.bind(*operands, **params)
        with jax.ensure_compile_time_eval():
            return np.asarray(primitive.bind(*operands, **params))[()]

    def _branch(self, operation: Any, values: list) -> list:
        choice, *operands = values
        if choice.dtype != object:
            return self.results(operation.params["branches"][int(choice)], operands)
        return super()._branch(operation, values)

    def _together(self, operation: Any, values: list) -> list:
        name = operation.primitive.name
        entries: Any
        if name in ELEMENTWISE:
            entries = self._elementwise_at(operation, values)
        elif name in _AT:
            entries = _AT[name](self, operation, values)
        else:
            raise NoRule(name)
        results = entries if operation.primitive.multiple_results else [entries]
        return [self._table(of.aval, at) for of, at in zip(operation.outvars, results, strict=True)]

    def _table(self, of: Any, at: Callable[[Place], Any]) -> Any:
        """The entries that a function returns; delayed if there are many."""
        if math.prod(of.shape) > MOST_ENTRIES:
            return _Table(of.shape, at)
        return objects([at(place) for place in np.ndindex(of.shape)], of.shape)

    def _elementwise_at(self, operation: Any, values: list) -> Callable[[Place], Any]:
        def at(place):
            shapes = [of.aval.shape for of in operation.invars]
            places = [tuple(0 if n == 1 else k for k, n in zip(place, shape, strict=False)) for shape in shapes]
            return self._bound(operation.primitive, *map(self.entry, values, places), **operation.params)

        return at


def _any(flags: jax.Array) -> jax.Array:
    return jnp.max(flags.astype(np.int32)) > 0


def _within_program(program: Any) -> Iterator[Any]:
    """The program and all programs in its operations."""
    yield program
    for operation in program.eqns:
        for params in operation.params.values():
            for inner in params if isinstance(params, tuple | list) else [params]:
                if isinstance(inner, core.ClosedJaxpr | core.Jaxpr):
                    yield from _within_program(inner)


def _size(program: Any) -> int:
    """Number of operations."""
    return sum(len(inner.eqns) for inner in _within_program(program))


def _constants(program: Any) -> Iterator[Any]:
    """The arrays that a program and the programs in it hold."""
    return (x for inner in _within_program(program) for x in getattr(inner, "consts", ()))


def _is_argument(constant: Any) -> bool:
    return isinstance(constant, jax.core.Tracer) or np.size(constant) > MOST_ENTRIES


def _has_reciprocal(number: Any) -> bool:
    """Whether this is a known floating-point number whose reciprocal does not overflow."""
    if isinstance(number, jax.core.Tracer) or not np.issubdtype(np.result_type(number), np.floating):
        return False
    return bool(np.abs(number) >= np.finfo(np.result_type(number)).tiny)


def _number_type(dtype: Any) -> Any:
    return np.int32 if dtype == np.dtype(bool) else dtype


def _number(x: jax.Array) -> jax.Array:
    """An array of numbers, because a kernel neither takes nor returns flags."""
    return x.astype(_number_type(x.dtype))


def _shared(array: Any, ref: Any, lanes: int) -> Any:
    """The value of an array that all lanes share."""
    shape, size = np.shape(array), np.size(array)
    dtype = jnp.result_type(array)
    if size > MOST_ENTRIES:
        zero = jnp.zeros(lanes, np.int32)
        return _Table(shape, lambda place: _loaded(ref, _along(place, shape), size, dtype, 1, zero))
    return objects([lax.broadcast(ref[k].astype(dtype), (lanes,)) for k in range(size)], shape)


def _loaded(ref: Any, number: Any, size: int, dtype: Any, apart: int, first: jax.Array) -> jax.Array:
    """Entry of a table with this number, of entries that are ``apart`` from each other.

    A number beyond an end is that of the end.
    """
    wide = np.int64 if size * apart > np.iinfo(np.int32).max else np.int32
    return ref[jnp.asarray(_within(number, size - 1), wide) * apart + first].astype(dtype)


def _along(place: Place, shape: tuple[int, ...]) -> Any:
    """Number of the entry at a place, counted along the last axis first."""
    number: Any = 0
    for k, n in zip(place, shape, strict=True):
        number = k + number * n
    return number


def _split(number: Any, shape: tuple[int, ...]) -> Place:
    """The place of the entry with a number."""
    place: list = []
    for n in reversed(shape):
        if n == 1:
            place.insert(0, 0)
        elif isinstance(number, int):
            number, k = divmod(number, n)
            place.insert(0, k)
        else:
            place.insert(0, lax.rem(number, jnp.full_like(number, n)))
            number = lax.div(number, jnp.full_like(number, n))
    return tuple(place)


def _greater(x: jax.Array, y: jax.Array) -> jax.Array:
    return lax.select((x >= y) | (x != x), x, y)


def _less(x: jax.Array, y: jax.Array) -> jax.Array:
    return lax.select((x <= y) | (x != x), x, y)


def _in_total_order(x: jax.Array) -> jax.Array:
    """Integers in the order of floating-point numbers, with NaN at the ends."""
    bits = lax.bitcast_convert_type(x, f"int{8 * x.dtype.itemsize}")
    return lax.select(bits < 0, jnp.iinfo(bits.dtype).max ^ bits, bits)


def _selected(which: jax.Array, *cases: jax.Array) -> jax.Array:
    which = which.astype(np.int32)
    return functools.reduce(lambda x, k: lax.select(which == k, cases[k], x), range(1, len(cases)), cases[0])


#: Operations that Triton lacks or defines otherwise, in terms of others.
_WRITTEN_OUT: dict[str, Callable] = {
    "clamp": lambda low, x, high: _less(_greater(x, low), high),
    "copy": lambda x: x,
    "is_finite": lambda x: jnp.abs(x) < np.inf,
    "le_to": lambda x, y: _in_total_order(x) <= _in_total_order(y),
    "lt_to": lambda x, y: _in_total_order(x) < _in_total_order(y),
    "max": _greater,
    "min": _less,
    "select_n": _selected,
}


def _moved(place_in_operand: Callable[[Any, Place], Place]) -> Callable:
    """Rule of an operation that moves entries of one operand, from the place that an entry of the result has there."""

    def rule(block, operation, values):
        return lambda place: block.entry(values[0], place_in_operand(operation, place))

    return rule


def _spread(operation: Any, place: Place) -> Place:
    axes, shape = operation.params["broadcast_dimensions"], operation.invars[0].aval.shape
    return tuple(0 if n == 1 else place[axis] for axis, n in zip(axes, shape, strict=True))


def _same_number(operation: Any, place: Place) -> Place:
    return _split(_along(place, operation.outvars[0].aval.shape), operation.invars[0].aval.shape)


def _sliced(operation: Any, place: Place) -> Place:
    starts, steps = operation.params["start_indices"], operation.params["strides"] or [1] * len(place)
    return tuple(int(start) + int(step) * k for start, step, k in zip(starts, steps, place, strict=True))


def _reversed(operation: Any, place: Place) -> Place:
    shape = operation.outvars[0].aval.shape
    return tuple(shape[d] - 1 - k if d in operation.params["dimensions"] else k for d, k in enumerate(place))


def _transposed(operation: Any, place: Place) -> Place:
    back = np.argsort(operation.params["permutation"])
    return tuple(place[d] for d in back)


def _one_of(number: Any, ends: Sequence[int], part: Callable[[int, Any], Any]) -> Any:
    """``part(k, number - start)`` of the part k that contains the number; part k ends at ``ends[k]``."""
    starts = [0, *ends[:-1]]
    if isinstance(number, int):
        k = int(np.searchsorted(ends, number, side="right"))
        return part(k, number - starts[k])
    value = part(0, number)
    for k in range(1, len(ends)):
        value = jnp.where(number >= starts[k], part(k, number - starts[k]), value)
    return value


def _concatenated(block: _Block, operation: Any, values: list) -> Callable[[Place], Any]:
    axis = operation.params["dimension"]
    ends = np.cumsum([of.aval.shape[axis] for of in operation.invars]).tolist()

    def at(place):
        def part(k, number):
            return block.entry(values[k], (*place[:axis], number, *place[axis + 1 :]))

        return _one_of(place[axis], ends, part)

    return at


def _stacked(block: _Block, operation: Any, values: list) -> Callable[[Place], Any]:
    axis, ends = operation.params["axis"], list(range(1, len(values) + 1))

    def at(place):
        rest = (*place[:axis], *place[axis + 1 :])
        return _one_of(place[axis], ends, lambda k, number: block.entry(values[k], rest))

    return at


def _parts(block: _Block, operation: Any, values: list) -> list[Callable[[Place], Any]]:
    axis, starts = operation.params["axis"], np.cumsum([0, *operation.params["sizes"]]).tolist()

    def part(start):
        return lambda place: block.entry(values[0], (*place[:axis], place[axis] + start, *place[axis + 1 :]))

    return [part(start) for start in starts[:-1]]


def _unstacked(block: _Block, operation: Any, values: list) -> list[Callable[[Place], Any]]:
    axis = operation.params["axis"]

    def row(k):
        return lambda place: block.entry(values[0], (*place[:axis], k, *place[axis:]))

    return [row(k) for k in range(len(operation.outvars))]


def _is_within(place: Sequence, shape: tuple[int, ...]) -> Any:
    return functools.reduce(lambda x, y: x & y, [(k >= 0) & (k < n) for k, n in zip(place, shape, strict=True)])


def _padded(block: _Block, operation: Any, values: list) -> Callable[[Place], Any]:
    sides, shape = operation.params["padding_config"], operation.invars[0].aval.shape
    if any(inner for *_, inner in sides):
        raise NoRule("pad between entries")

    def at(place):
        inside = tuple(k - int(low) for k, (low, *_) in zip(place, sides, strict=True))
        is_inside = _is_within(inside, shape)
        filler = block.entry(values[1], ())
        if isinstance(is_inside, bool):
            return block.entry(values[0], inside) if is_inside else filler
        return jnp.where(is_inside, block.entry(values[0], inside), filler)

    return at


def _numbered(block: _Block, operation: Any, values: list) -> Callable[[Place], Any]:
    axis, dtype = operation.params["dimension"], operation.params["dtype"]

    def at(place):
        number = place[axis]
        return np.asarray(number, dtype)[()] if isinstance(number, int) else number.astype(dtype)

    return at


def _begin(block: _Block, starts: Sequence, shape: tuple[int, ...], sizes: tuple[int, ...]) -> list:
    """The place where a block of an array begins; one that exceeds the array is moved inside, as in JAX."""
    return [_within(block.entry(x, ()), n - size) for x, n, size in zip(starts, shape, sizes, strict=True)]


def _within(number: Any, last: int) -> Any:
    """The number, or the nearest one from 0 to ``last``."""
    if isinstance(number, jax.core.Tracer):
        return jnp.clip(number, 0, last).astype(np.int32)
    return int(np.clip(number, 0, last))


def _block_of(block: _Block, operation: Any, values: list) -> Callable[[Place], Any]:
    x, *starts = values
    begin = _begin(block, starts, operation.invars[0].aval.shape, operation.params["slice_sizes"])
    return lambda place: block.entry(x, tuple(start + k for start, k in zip(begin, place, strict=True)))


def _with_block(block: _Block, operation: Any, values: list) -> Callable[[Place], Any]:
    x, new, *starts = values
    shape = operation.invars[1].aval.shape
    begin = _begin(block, starts, operation.invars[0].aval.shape, shape)

    def at(place):
        inside = [k - start for k, start in zip(place, begin, strict=True)]
        is_inside = _is_within(inside, shape)
        nearest = tuple(_within(k, n - 1) for k, n in zip(inside, shape, strict=True))
        return jnp.where(is_inside, block.entry(new, nearest), block.entry(x, place))

    return at


def _gathered(block: _Block, operation: Any, values: list) -> Callable[[Place], Any]:
    x, starts = values
    shape_x, params = operation.invars[0].aval.shape, operation.params
    dims, sizes = params["dimension_numbers"], params["slice_sizes"]
    alone = {*dims.collapsed_slice_dims, *dims.operand_batching_dims}
    fills = params["mode"] == lax.GatherScatterMode.FILL_OR_DROP

    def at(place):
        offsets = iter([place[d] for d in dims.offset_dims])
        batch_dims = tuple(k for d, k in enumerate(place) if d not in dims.offset_dims)
        inside = [0 if d in alone else next(offsets) for d in range(len(shape_x))]
        for d, batch in zip(dims.operand_batching_dims, dims.start_indices_batching_dims, strict=True):
            inside[d] = batch_dims[batch]
        missing: Any = False
        for k, d in enumerate(dims.start_index_map):
            start, last = block.entry(starts, (*batch_dims, k)), shape_x[d] - sizes[d]
            missing = missing | (start < 0) | (start > last)
            inside[d] = inside[d] + _within(start, last)
        inner = block.entry(x, tuple(inside))
        if not fills:
            return inner
        filler = params["fill_value"]
        if filler is None:
            dtype = operation.outvars[0].aval.dtype
            filler = np.nan if jnp.issubdtype(dtype, jnp.inexact) else jnp.iinfo(dtype).min
        return jnp.where(missing, filler, inner)

    return at


def _number_of_largest(block: _Block, operation: Any, values: list) -> Callable[[Place], Any]:
    (axis,), of, result = operation.params["axes"], operation.invars[0].aval, operation.outvars[0].aval

    def at(place):
        number, largest = result.dtype.type(0), block.entry(values[0], (*place[:axis], 0, *place[axis:]))
        for k in range(1, of.shape[axis]):
            entry = block.entry(values[0], (*place[:axis], k, *place[axis:]))
            is_larger = jnp.logical_not(entry <= largest) & (largest == largest)
            number = jnp.where(is_larger, result.dtype.type(k), number)
            largest = jnp.where(is_larger, entry, largest)
        return number

    return at


#: Operations that move or number entries, each with its rule for the entry at a place of the result.
_AT: dict[str, Callable] = {
    "argmax": _number_of_largest,
    "broadcast_in_dim": _moved(_spread),
    "concatenate": _concatenated,
    "dynamic_slice": _block_of,
    "dynamic_update_slice": _with_block,
    "expand_dims": _moved(_same_number),
    "gather": _gathered,
    "iota": _numbered,
    "pad": _padded,
    "reshape": _moved(_same_number),
    "rev": _moved(_reversed),
    "slice": _moved(_sliced),
    "split": _parts,
    "squeeze": _moved(_same_number),
    "stack": _stacked,
    "transpose": _moved(_transposed),
    "unstack": _unstacked,
}
