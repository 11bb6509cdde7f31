"""Lanes of few unknowns, component by component.

``jax.vmap`` turns each array (n,) of one run into an array (lanes, n), and XLA computes it element by element: a loop
over three unknowns does not fill the vector registers, and most arrays pass through memory. :func:`each` takes the
other way round. The traced program of one lane is evaluated with every small array as n *components*, each of them one
array (lanes,). A rearrangement, such as a slice, a stack or a gather with known indices, then only renames components
while it is traced. A sum or a product of matrices becomes a few additions and multiplications. XLA fuses what remains
into loops over lanes, which fill the vector registers. The formulas of schemes, problems and observers are unchanged.

A loop of few turns is written out, so that its indices are known: the elimination of a band becomes additions and
multiplications too. In a loop or a branch whose condition differs from lane to lane, all lanes take each turn, and
those that have ended keep their values, as with ``jax.vmap``.

What does not depend on the lane, such as a load at the time that all lanes share, is computed once for all lanes. An
operation on more than ``MOST_ENTRIES`` entries, or at an index that depends on the lane, and a sort are computed for
arrays of all lanes. A program with an operation that has no rule here, such as a call of LAPACK, is mapped by
``jax.vmap``; one line in the log (``logging``, level ``INFO``) names the operation.

The operations of a lane, and their order, are those of a single run. XLA may merge a multiplication and an addition in
one program and not in the other, so that results agree with single runs to round-off.
"""

import functools
import logging
import math
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.extend import core

from study.mechanics.newton import any_lane

#: Largest number of unknowns of lanes that are marched by components. With 16 unknowns a step would be up to a third
#: faster, but would take three times as long to compile.
MOST_UNKNOWNS = 8

#: Largest number of entries of an array that is divided into components.
MOST_ENTRIES = 64

#: Logger of operations without a rule.
LOG = logging.getLogger(__name__)

#: Operations that contain a program, each with the name of its parameter that holds the program.
CALLS = {
    "closed_call": "call_jaxpr",
    "core_call": "call_jaxpr",
    "custom_jvp_call": "call_jaxpr",
    "custom_vjp_call": "call_jaxpr",
    "custom_vmap_call": "call",
    "checkpoint": "jaxpr",
    "remat2": "jaxpr",
    "jit": "jaxpr",
    "pjit": "jaxpr",
}

#: Operations that compute each entry of their result from one entry of each operand.
ELEMENTWISE = frozenset(
    "abs acos acosh add add_any and asin asinh atan atan2 atanh bitcast_convert_type cbrt ceil clamp "
    "convert_element_type copy cos cosh digamma div eq erf erf_inv erfc exp exp2 expm1 floor ge gt integer_pow "
    "is_finite le le_to lgamma log log1p logistic lt lt_to max min mul ne neg nextafter not one_minus_square or pow "
    "reduce_precision rem round rsqrt select_n shift_left shift_right_arithmetic shift_right_logical sign sin "
    "sinh sqrt square stop_gradient sub tan tanh xor".split()
)

#: Operations on arrays of all lanes only, which are seldom in a step.
TOGETHER = frozenset("argmax argmin cumlogsumexp cummax cummin cumprod sort top_k".split())

#: Operations that join all entries along some axes, each with the operation of two entries.
REDUCTIONS = {
    "reduce_sum": lax.add_p,
    "reduce_prod": lax.mul_p,
    "reduce_max": lax.max_p,
    "reduce_min": lax.min_p,
    "reduce_and": lax.and_p,
    "reduce_or": lax.or_p,
}


@jax.tree_util.register_pytree_node_class
class Components:
    """An array of one lane in all lanes: ``entries`` is an array of objects, each an array (lanes,)."""

    def __init__(self, entries: np.ndarray):
        self.entries = entries

    def tree_flatten(self) -> tuple[tuple, tuple[int, ...]]:
        """Entries and shape, for JAX."""
        return tuple(self.entries.flat), self.entries.shape

    @classmethod
    def tree_unflatten(cls, shape: tuple[int, ...], entries: Sequence) -> "Components":
        """The inverse of :meth:`tree_flatten`, for JAX."""
        return cls(objects(entries, shape))


class NoRule(NotImplementedError):
    """There is no rule for an operation of this name."""


class Whole:
    """An array of one lane in all lanes, undivided: ``array`` has an axis of lanes in front."""

    def __init__(self, array: jax.Array):
        self.array = array


def each(function: Callable) -> Callable:
    """``function``, which takes and returns arrays of one lane, as a function of arrays of all lanes.

    An argument is a tree of arrays with an axis of lanes in front, of :class:`Components` and of numbers (), which all
    lanes share. An array with several entries, at most ``MOST_ENTRIES``, is returned as :class:`Components`.
    """

    def batched(*arguments):
        leaves, tree = jax.tree.flatten(arguments, is_leaf=_is_components)
        shapes = [_lane_shape(leaf) for leaf in leaves]
        program, result = jax.make_jaxpr(lambda *x: function(*jax.tree.unflatten(tree, x)), return_shape=True)(*shapes)
        lanes = Lanes(next(len(x) for x in jax.tree.leaves(arguments) if jnp.ndim(x)))
        try:
            results = lanes.results(program, [_value(leaf) for leaf in leaves])
        except NoRule as error:
            LOG.info("Lanes march as whole arrays, because components have no rule for the operation '%s'.", error)
            results = [_value(x) for x in jax.tree.leaves(together(function)(*arguments))]
        packed = map(lanes.packed, results, program.out_avals)
        return jax.tree.unflatten(jax.tree.structure(result), list(packed))

    return batched


def across(shape: tuple[int, ...]) -> Callable[[Callable], Callable]:
    """The faster map over lanes for runs whose displacement has this shape: :func:`each` or :func:`together`."""
    few = shape and math.prod(shape) <= MOST_UNKNOWNS
    return each if few and jax.default_backend() == "cpu" else together


def together(function: Callable) -> Callable:
    """As :func:`each`, for whole arrays with an axis of lanes in front, by ``jax.vmap``."""

    def batched(*arguments):
        arguments = joined(arguments)
        return jax.vmap(function, jax.tree.map(lambda x: 0 if jnp.ndim(x) else None, arguments))(*arguments)

    return batched


def joined(tree: Any) -> Any:
    """The tree with all components joined to arrays with an axis of lanes in front."""
    return jax.tree.map(lambda x: _stacked(x.entries) if _is_components(x) else x, tree, is_leaf=_is_components)


def where(condition, value, other):
    """``value`` in the lanes where the condition (lanes,) holds, elsewhere ``other``."""
    return jnp.where(condition.reshape(condition.shape + (1,) * (jnp.ndim(value) - 1)), value, other)


class Lanes:
    """The evaluation of programs of one lane in a number of lanes.

    A *value* of a program is an array that all lanes share, or an array of objects with the components in all lanes, or
    a :class:`Whole`. A component is an array (lanes,), or a number that all lanes share.
    """

    #: Largest number of entries that a loop computes if it is written out. More would take long to compile.
    most_written_out = 1000

    def __init__(self, lanes: int):
        self._lanes = lanes

    def results(self, program: Any, values: Sequence) -> list:
        """Values that a program returns for the values of its arguments."""
        jaxpr, constants = (program.jaxpr, program.consts) if isinstance(program, core.ClosedJaxpr) else (program, ())
        known = dict(zip(jaxpr.invars, values, strict=True))
        known |= zip(jaxpr.constvars, map(self._constant, constants), strict=True)

        def value(variable):
            literal = isinstance(variable, core.Literal)
            return np.asarray(variable.val, variable.aval.dtype) if literal else known[variable]  # type: ignore[attr-defined]

        for operation in jaxpr.eqns:
            results = self._computed(operation, [value(variable) for variable in operation.invars])
            known |= zip(operation.outvars, results, strict=True)
        return [value(variable) for variable in jaxpr.outvars]

    def packed(self, value: Any, aval: Any) -> Any:
        """A value as arrays with an axis of lanes in front, or as :class:`Components` of such arrays."""
        if isinstance(value, Whole):
            return value.array
        if not _is_divisible(aval.shape):
            return self._whole(value, aval)
        entries = objects([self._full(x) for x in _entries(value).flat], aval.shape)
        return Components(entries) if aval.shape else entries[()]

    def _full(self, component: Any) -> jax.Array:
        """A component as an array (lanes,)."""
        return component if jnp.ndim(component) else lax.broadcast(component, (self._lanes,))

    def _whole(self, value: Any, aval: Any) -> jax.Array:
        """A value as one array with an axis of lanes in front."""
        if isinstance(value, Whole):
            return value.array
        if not _varies(value) or not value.size:
            shared = jnp.zeros(aval.shape, aval.dtype) if _varies(value) else jnp.asarray(value)
            return jnp.broadcast_to(shared, (self._lanes, *aval.shape))
        return _stacked(objects([self._full(x) for x in value.flat], value.shape))

    def _computed(self, operation: Any, values: list) -> list:
        """Results of one operation of a program."""
        name = operation.primitive.name
        if name in CALLS:
            return self.results(operation.params[CALLS[name]], values)
        if name == "call_hi_primitive":  # an operation of JAX since version 0.12 that consists of others
            expanded = functools.partial(operation.primitive.to_lojax, **operation.params)
            return self.results(jax.make_jaxpr(expanded)(*(variable.aval for variable in operation.invars)), values)
        if not any(map(_varies, values)):
            return self._alone(operation, values)
        if name in _LOOPS:
            return _LOOPS[name](self, operation, values)
        shapes = [of.aval.shape for of in operation.invars]
        if all(map(_is_small, (*shapes, *(of.aval.shape for of in operation.outvars)))):
            if name in _SUMS or (
                name in ELEMENTWISE and np.broadcast_shapes(*shapes) == operation.outvars[0].aval.shape
            ):
                return [_SUMS.get(name, Lanes._elementwise)(self, operation, *map(_entries, values))]
            if name in _MOVES:
                moved = _MOVES[name](operation, *map(_entries, values))
                return moved if operation.primitive.multiple_results else [moved]
            if name in _AT_PLACES:
                rule, places = _AT_PLACES[name]
                if not any(isinstance(x, jax.core.Tracer) or _varies(x) for x in values[places]):
                    return [rule(operation, values)]
        if not any(name in known for known in (ELEMENTWISE, TOGETHER, _SUMS, _MOVES, _AT_PLACES)):
            raise NoRule(name)
        return self._together(operation, values)

    def _constant(self, array: Any) -> Any:
        """The value of an array that a program holds."""
        return array

    def _alone(self, operation: Any, values: list) -> list:
        """Results of an operation that all lanes share."""
        return _alone(operation, values)

    def _any(self, flags: jax.Array) -> jax.Array:
        return any_lane(flags)

    def _together(self, operation: Any, values: list) -> list:
        """Results of an operation on arrays of all lanes."""
        types = [variable.aval for variable in operation.invars]
        arrays = [self._whole(x, aval) if _varies(x) else x for x, aval in zip(values, types, strict=True)]
        axes = [0 if _varies(x) else None for x in values]
        return [_value(x) for x in jax.vmap(_function(operation), axes, axis_size=self._lanes)(*arrays)]

    def _bound(self, primitive: Any, *operands: Any, **params: Any) -> Any:
        """Component that an operation computes from components."""
        if any(map(jnp.ndim, operands)):
            operands = tuple(map(self._full, operands))
        return primitive.bind(*operands, **params)

    def _elementwise(self, operation: Any, *operands: np.ndarray) -> np.ndarray:
        shape = operation.outvars[0].aval.shape
        wide = zip(*(np.broadcast_to(x, shape).flat for x in operands), strict=True)
        return objects([self._bound(operation.primitive, *entries, **operation.params) for entries in wide], shape)

    def _joined(self, primitive: Any, terms: np.ndarray) -> np.ndarray:
        """The rows of an array joined one after the other by an operation of two entries."""

        def pair(x, y):
            return objects([self._bound(primitive, *entries) for entries in zip(x.flat, y.flat, strict=True)], x.shape)

        return functools.reduce(pair, [terms[k, ...] for k in range(len(terms))])

    def _reduced(self, operation: Any, x: np.ndarray) -> np.ndarray:
        axes = operation.params["axes"]
        rows = np.moveaxis(x, axes, range(len(axes))).reshape(-1, *operation.outvars[0].aval.shape)
        return self._joined(REDUCTIONS[operation.primitive.name], rows)

    def _accumulated(self, operation: Any, x: np.ndarray) -> np.ndarray:
        rows = np.moveaxis(x, operation.params["axis"], 0)
        rows = rows[::-1] if operation.params["reverse"] else rows
        sums = np.stack([self._joined(lax.add_p, rows[: k + 1]) for k in range(len(rows))])
        return np.moveaxis(sums[::-1] if operation.params["reverse"] else sums, 0, operation.params["axis"])

    def _dot(self, operation: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        (dims_x, dims_y), (shared_x, shared_y) = operation.params["dimension_numbers"]
        x = np.moveaxis(x, (*dims_x, *shared_x), range(len(dims_x) + len(shared_x)))
        y = np.moveaxis(y, (*dims_y, *shared_y), range(len(dims_y) + len(shared_y)))
        inner, shared = x.shape[: len(dims_x)], x.shape[len(dims_x) :][: len(shared_x)]
        left, right = (math.prod(_.shape[len(inner + shared) :]) for _ in (x, y))
        x = x.reshape(math.prod(inner), -1, left, 1)
        y = y.reshape(math.prod(inner), -1, 1, right)
        pairs = zip(*(np.broadcast_to(_, (*x.shape[:3], right)).flat for _ in (x, y)), strict=True)
        terms = objects([self._bound(lax.mul_p, *factors) for factors in pairs], (*x.shape[:3], right))
        return self._joined(lax.add_p, terms).reshape(operation.outvars[0].aval.shape)

    def _while(self, operation: Any, values: list) -> list:
        condition, body = (operation.params[f"{name}_jaxpr"] for name in ("cond", "body"))
        first, second = (operation.params[f"{name}_nconsts"] for name in ("cond", "body"))
        condition_values, body_values, begin = values[:first], values[first : first + second], values[first + second :]
        types = [variable.aval for variable in operation.outvars]
        varies, before = [_varies(x) for x in begin], None
        while varies != before:
            after = _depend(body.jaxpr, [*map(_varies, body_values), *varies])
            varies, before = [a or b for a, b in zip(varies, after, strict=True)], varies
        apart = any(_depend(condition.jaxpr, [*map(_varies, condition_values), *varies]))
        varies = [vary or apart for vary in varies]

        def packed(values):
            return [self.packed(x, aval) if v else x for x, aval, v in zip(values, types, varies, strict=True)]

        def unpacked(carry):
            return [_value(x) if v else x for x, v in zip(carry, varies, strict=True)]

        def goes_on(carry):
            (goes,) = self.results(condition, [*condition_values, *unpacked(carry)])
            return self._full(goes[()]) if apart else goes

        def turn(carry):
            return packed(self.results(body, [*body_values, *unpacked(carry)]))

        def turn_of_some(state):
            going, carry = state
            carry = jax.tree.map(functools.partial(where, going), turn(carry), carry)
            return goes_on(carry), carry

        begin = packed(begin)
        if apart:
            _, end = lax.while_loop(lambda state: self._any(state[0]), turn_of_some, (goes_on(begin), begin))
        else:
            end = lax.while_loop(goes_on, turn, begin)
        return unpacked(end)

    def _branch(self, operation: Any, values: list) -> list:
        choice, *operands = values
        types = [variable.aval for variable in operation.outvars]

        def results(branch):
            return [self.packed(x, aval) for x, aval in zip(self.results(branch, operands), types, strict=True)]

        def chosen(*cases):
            return functools.reduce(lambda x, k: where(choice[()] == k, cases[k], x), range(1, len(cases)), cases[0])

        branches = operation.params["branches"]
        if _varies(choice):
            outcome = jax.tree.map(chosen, *map(results, branches))
        else:
            outcome = lax.switch(choice, [functools.partial(results, branch) for branch in branches])
        return [_value(x) for x in outcome]

    def _scan(self, operation: Any, values: list) -> list:
        params = operation.params
        length, turn = params["length"], params["jaxpr"]
        if "num_consts" in params:
            first, carried = params["num_consts"], params["num_carry"]
        else:  # since version 0.12 of JAX
            first, carried, _ = (len(list(part)) for part in params["ft_in"].unpack())
        if not length or length * _entries_computed(turn.jaxpr) > self.most_written_out:
            return self._together(operation, values)
        constants, carry, rows = values[:first], values[first : first + carried], values[first + carried :]
        stored: list[list] = []
        for k in reversed(range(length)) if params["reverse"] else range(length):
            results = self.results(turn, [*constants, *carry, *(_row(x, k) for x in rows)])
            carry = results[:carried]
            stored.append(results[carried:])
        if params["reverse"]:
            stored.reverse()
        types = [variable.aval for variable in operation.outvars[carried:]]
        return carry + [self._rows(column, aval) for column, aval in zip(zip(*stored, strict=True), types, strict=True)]

    def _rows(self, values: Sequence, aval: Any) -> Any:
        """The values, one below the other, as one value."""
        if not any(map(_varies, values)):
            return jnp.stack([jnp.asarray(x) for x in values])
        if any(isinstance(x, Whole) for x in values):
            row = jax.ShapeDtypeStruct(aval.shape[1:], aval.dtype)
            return Whole(jnp.stack([self._whole(x, row) for x in values], 1))
        return np.stack([_entries(x) for x in values])


#: Operations that add or multiply entries of one operand, or of two.
_SUMS: dict[str, Callable] = dict.fromkeys(REDUCTIONS, Lanes._reduced)
_SUMS |= {"cumsum": Lanes._accumulated, "dot_general": Lanes._dot}

#: Operations with programs that depend on a condition or are repeated.
_LOOPS: dict[str, Callable] = {"while": Lanes._while, "cond": Lanes._branch, "scan": Lanes._scan}


def _is_components(x: Any) -> bool:
    return isinstance(x, Components)


def _lane_shape(leaf: Any) -> jax.ShapeDtypeStruct:
    if _is_components(leaf):
        return jax.ShapeDtypeStruct(leaf.entries.shape, leaf.entries.flat[0].dtype)
    return jax.ShapeDtypeStruct(jnp.shape(leaf)[1:], jnp.result_type(leaf))


def _entries_computed(program: Any) -> int:
    """Number of entries that the operations of a program compute."""
    return sum(math.prod(of.aval.shape) for operation in program.eqns for of in operation.outvars)


def _is_small(shape: tuple[int, ...]) -> bool:
    return math.prod(shape) <= MOST_ENTRIES


def _is_divisible(shape: tuple[int, ...]) -> bool:
    return 0 < math.prod(shape) <= MOST_ENTRIES


def _varies(value: Any) -> bool:
    """Whether a value differs from lane to lane."""
    return isinstance(value, Whole) or (isinstance(value, np.ndarray) and value.dtype == object)


def objects(entries: Sequence, shape: tuple[int, ...]) -> np.ndarray:
    """An array of objects; NumPy would take the entries apart."""
    array = np.empty(len(entries), object)
    for place, entry in enumerate(entries):
        array[place] = entry
    return array.reshape(shape)


def _entries(value: Any) -> np.ndarray:
    """A value that is not whole as an array of objects."""
    if _varies(value):
        return value
    if not isinstance(value, jax.core.Tracer):
        value = np.asarray(value)
        return objects([value[place] for place in np.ndindex(value.shape)], value.shape)
    flat = lax.reshape(value, (value.size,))
    return objects([lax.index_in_dim(flat, k, keepdims=False) for k in range(value.size)], value.shape)


def _value(array: Any) -> Any:
    """The value of an array with an axis of lanes in front, of :class:`Components`, or of a number."""
    if _is_components(array):
        return array.entries
    if not jnp.ndim(array):
        return array
    shape = array.shape[1:]
    if not shape:
        return objects([array], ())
    if not _is_divisible(shape):
        return Whole(array)
    flat = lax.reshape(array, (len(array), math.prod(shape)))
    return objects([lax.index_in_dim(flat, k, 1, keepdims=False) for k in range(math.prod(shape))], shape)


def _row(value: Any, k: int) -> Any:
    """Entry k of a value along its first axis."""
    if isinstance(value, Whole):
        return _value(value.array[:, k])
    return value[k, ...] if isinstance(value, np.ndarray) else lax.index_in_dim(value, k, keepdims=False)


def _stacked(entries: np.ndarray) -> jax.Array:
    """Components (lanes,) as one array with the axis of lanes in front."""
    return jnp.stack(list(entries.flat), axis=1).reshape(-1, *entries.shape)


def _depend(program: Any, depends: Sequence[bool]) -> list[bool]:
    """Which results of a program depend on the arguments for which ``depends`` is true."""
    dependence = dict(zip(program.invars, depends, strict=True))

    def is_dependent(variable):
        return not isinstance(variable, core.Literal) and dependence.get(variable, False)

    for operation in program.eqns:
        dependence |= dict.fromkeys(operation.outvars, any(map(is_dependent, operation.invars)))
    return [is_dependent(variable) for variable in program.outvars]


def _function(operation: Any) -> Callable:
    """An operation as a function that returns a list."""

    def function(*operands):
        results = operation.primitive.bind(*operands, **operation.params)
        return list(results) if operation.primitive.multiple_results else [results]

    return function


def _alone(operation: Any, values: list) -> list:
    """Results of an operation that all lanes share; indices are computed at once, so that they are known."""
    name, types = operation.primitive.name, [variable.aval for variable in operation.outvars]
    indices = all(jnp.issubdtype(aval.dtype, jnp.integer) or aval.dtype == bool for aval in types)
    if not indices or any(isinstance(x, jax.core.Tracer) for x in values):
        return _function(operation)(*values)
    if name in _INDEX_OPERATIONS:
        results = [_INDEX_OPERATIONS[name](operation.params, *values)]
    else:
        with jax.ensure_compile_time_eval():
            results = _function(operation)(*values)
    return [np.broadcast_to(np.asarray(x, aval.dtype), aval.shape) for x, aval in zip(results, types, strict=True)]


def _whole_numbers(params: dict) -> np.ndarray:
    numbers = np.arange(params["shape"][params["dimension"]])
    return numbers.reshape([-1 if d == params["dimension"] else 1 for d in range(len(params["shape"]))])


#: Operations on indices that NumPy computes, because JAX would compile a program for each of them.
_INDEX_OPERATIONS: dict[str, Callable] = {
    name: lambda params, *operands, numpy_function=numpy_function: numpy_function(*operands)
    for name, numpy_function in {
        "add": np.add,
        "and": np.bitwise_and,
        "eq": np.equal,
        "ge": np.greater_equal,
        "gt": np.greater,
        "le": np.less_equal,
        "lt": np.less,
        "max": np.maximum,
        "min": np.minimum,
        "mul": np.multiply,
        "ne": np.not_equal,
        "or": np.bitwise_or,
        "rem": np.fmod,
        "sub": np.subtract,
        "select_n": lambda which, *cases: np.choose(np.asarray(which, int), cases),
    }.items()
} | {
    "convert_element_type": lambda params, x: x,
    "iota": _whole_numbers,
}


def _repeated(entry: Any, shape: tuple[int, ...]) -> np.ndarray:
    return objects([entry] * math.prod(shape), shape)


def _spread(operation: Any, x: np.ndarray) -> np.ndarray:
    shape, axes = operation.params["shape"], operation.params["broadcast_dimensions"]
    aligned = x.reshape([x.shape[axes.index(d)] if d in axes else 1 for d in range(len(shape))])
    return np.broadcast_to(aligned, shape)


def _padded(operation: Any, x: np.ndarray, filler: np.ndarray) -> np.ndarray:
    for axis, (low, high, inner) in enumerate(operation.params["padding_config"]):
        rows = np.moveaxis(x, axis, 0)
        rest, n = rows.shape[1:], len(rows)
        apart = _repeated(filler[()], (max(n + inner * (n - 1), 0), *rest))
        apart[:: inner + 1] = rows
        ends = [_repeated(filler[()], (max(size, 0), *rest)) for size in (low, high)]
        kept = apart[max(-low, 0) : len(apart) - max(-high, 0)]
        x = np.moveaxis(np.concatenate([ends[0], kept, ends[1]]), 0, axis)
    return x


def _parts(operation: Any, x: np.ndarray) -> list[np.ndarray]:
    return np.split(x, np.cumsum(operation.params["sizes"])[:-1], operation.params["axis"])


def _sliced(operation: Any, x: np.ndarray) -> np.ndarray:
    begin, end, steps = (operation.params[name] for name in ("start_indices", "limit_indices", "strides"))
    return x[tuple(map(slice, begin, end, steps or [1] * x.ndim))]


def _same_shape(operation: Any, x: np.ndarray) -> np.ndarray:
    return x.reshape(operation.outvars[0].aval.shape)


def _unstacked(operation: Any, x: np.ndarray) -> list[np.ndarray]:
    rows = np.moveaxis(x, operation.params["axis"], 0)
    return [rows[k, ...] for k in range(len(rows))]


#: Operations that rearrange entries.
_MOVES: dict[str, Callable] = {
    "broadcast_in_dim": _spread,
    "concatenate": lambda operation, *parts: np.concatenate(parts, operation.params["dimension"]),
    "expand_dims": _same_shape,
    "pad": _padded,
    "reshape": _same_shape,
    "rev": lambda operation, x: np.flip(x, operation.params["dimensions"]),
    "slice": _sliced,
    "split": _parts,
    "squeeze": _same_shape,
    "stack": lambda operation, *parts: np.stack(parts, operation.params["axis"]),
    "transpose": lambda operation, x: x.transpose(operation.params["permutation"]),
    "unstack": _unstacked,
}


def _block(x: np.ndarray, starts: Sequence, sizes: Sequence[int]) -> tuple[slice, ...]:
    """The place of a block; one that exceeds the array is moved inside, as in JAX."""
    begin = (int(np.clip(at, 0, n - size)) for at, n, size in zip(starts, x.shape, sizes, strict=True))
    return tuple(slice(at, at + size) for at, size in zip(begin, sizes, strict=True))


def _block_of(operation: Any, values: list) -> np.ndarray:
    x, *starts = values
    return x[_block(x, starts, operation.params["slice_sizes"])]


def _with_block(operation: Any, values: list) -> np.ndarray:
    x, block, *starts = values
    new = _entries(x).copy()
    new[_block(new, starts, block.shape)] = _entries(block)
    return new


def _numbered(operation: Any, values: list, places: int = 1, **params: Any) -> tuple[np.ndarray, np.ndarray]:
    """All entries of the operands that are moved, and the numbers of those that the operation returns."""
    entries = [x if k == places else _entries(x) for k, x in enumerate(values)]
    moved = np.concatenate([x.ravel() for k, x in enumerate(entries) if k != places])
    numbers, end = list(values), 0
    for k, x in enumerate(entries):
        if k != places:
            numbers[k], end = np.arange(end, end + x.size).reshape(x.shape), end + x.size
    with jax.ensure_compile_time_eval():
        results = operation.primitive.bind(*map(jnp.asarray, numbers), **operation.params | params)
    return moved, np.asarray(results)


def _gathered(operation: Any, values: list) -> np.ndarray:
    moved, numbers = _numbered(operation, values, fill_value=-1)
    missing = operation.outvars[0].aval.dtype.type(np.nan) if (numbers < 0).any() else None
    return objects([moved[k] if k >= 0 else missing for k in numbers.flat], numbers.shape)


def _scattered(operation: Any, values: list) -> np.ndarray:
    moved, numbers = _numbered(operation, values)
    return objects([moved[k] for k in numbers.flat], numbers.shape)


#: Operations that rearrange entries at indices, each with its rule for known indices and the places of these among its
#: operands.
_AT_PLACES: dict[str, tuple[Callable, slice]] = {
    "dynamic_slice": (_block_of, slice(1, None)),
    "dynamic_update_slice": (_with_block, slice(2, None)),
    "gather": (_gathered, slice(1, None)),
    "scatter": (_scattered, slice(1, 2)),
}
