"""What functions read: the key under which JAX keeps their programs.

JAX keeps a traced or compiled program by the identity of its function. The function may read globals, closures,
attributes, dictionaries and arrays, which may have changed since it was traced: a force that reads a global stiffness
would be marched with the old one. :func:`reading` adds everything that functions read to the key of all programs, also
of the functions inside, such as the branches of ``lax.cond``.

A function reads the globals that its code names, its closure, its defaults, and all that these values hold. Where this
search cannot see what is read, as with a file or an iterator, the reads are not ``certain``. They then equal no other
reads, and a program is compiled at each call.
"""

import builtins
import dis
import functools
import hashlib
import itertools
import re
import sys
import sysconfig
import types
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import jax
import numpy as np
from jax.extend.core import ClosedJaxpr
from jax.tree_util import default_registry

#: Packages whose functions and classes do not change, and read only their arguments and closures.
CONSTANT = frozenset(
    "abc builtins cmath collections dataclasses diffrax enum equinox functools itertools jax jaxlib jaxtyping lineax "
    "math numpy operator optimistix reference scipy study types typing".split()
)

#: Names in these packages that read a file or a hidden state.
CHANGING = frozenset(
    "DataSource ctypeslib fromfile fromregex genfromtxt io load loadtxt memmap open_memmap random".split()
)

#: Built-in functions that read their arguments only, and no attribute by a computed name.
PURE = frozenset(
    "abs all any bool bytes callable complex dict divmod enumerate filter float frozenset int isinstance issubclass "
    "len list map max min object pow print property range repr reversed round set slice sorted str sum super tuple "
    "type zip NotImplemented Ellipsis".split()
)

#: Operations of Python that read or change values which the names in the code do not show.
HIDDEN = frozenset(("DELETE_GLOBAL", "IMPORT_NAME", "LOAD_BUILD_CLASS", "STORE_GLOBAL", "YIELD_VALUE"))

#: Largest size of an array of JAX whose values are compared; larger ones, which do not change, are compared by address.
COMPARED = 1000

_LITERALS = frozenset((type(None), bool, int, float, complex, str, bytes, slice, range, type(Ellipsis)))
_BUILT_IN = (types.BuiltinFunctionType, types.MethodDescriptorType, types.WrapperDescriptorType, np.ufunc)
_NUMBERS_AND_TEXTS = (int, float, complex, str, bytes, bytearray)
#: Kinds of objects of C whose values the search adds.
_KNOWN = (*_NUMBERS_AND_TEXTS, tuple, list, set, frozenset, dict, deque, np.ndarray, np.generic)
#: Descriptors of fields, whose values are those of the object.
_FIELDS = (types.MemberDescriptorType, types.GetSetDescriptorType, type(dis.Positions.lineno))
_numbers = itertools.count()
_context = jax.make_user_context(None)


class Reads:
    """The values that functions read, as a digest; equal if the same values were read.

    Attributes
    ----------
    certain
        Whether all values were found; otherwise the reads equal no others.
    traced
        Whether JAX traces one of the values, or may trace one that was not found.
    """

    def __init__(self, digest: bytes, certain: bool = True, held: Iterable[Any] = (), traced: bool = False):
        self._digest, self.certain, self.traced = digest, certain, traced
        self._held = tuple(held)  # objects that the digest knows by their addresses, which no others may take

    @classmethod
    def unique(cls) -> "Reads":
        """Reads that equal no others."""
        return cls(f"unique {next(_numbers)}".encode(), certain=False, traced=True)

    def __hash__(self) -> int:
        return hash(self._digest)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Reads) and self._digest == other._digest

    def __repr__(self) -> str:
        return f"Reads({self._digest.hex()})"


@contextmanager
def reading(reads: Reads) -> Iterator[None]:
    """Within this context, JAX traces and compiles again what it has not yet traced or compiled for these reads."""
    with _context(reads):
        yield


def reads_of(*parts: Any) -> Reads:
    """What the functions in ``parts`` read now.

    Parameters
    ----------
    parts
        Arguments of a compiled function. The arrays in them, also in containers and modules, are arguments of the
        program and are not read.
    """
    search = _Search()
    for part in parts:
        search.argument(part)
    return search.result()


def reads_of_program(program: ClosedJaxpr) -> Reads:
    """What a traced program holds: its operations, numbers and arrays."""
    search = _Search()
    search.program(program)
    return search.result()


class _Names(NamedTuple):
    """Names in the code of a function and of the functions that it defines.

    Attributes
    ----------
    globals
        Globals that the code reads.
    opened
        Those of them of which the code reads an attribute with a name in ``CHANGING``.
    shown
        Whether the names show all that is read.
    """

    globals: frozenset[str]
    opened: frozenset[str]
    shown: bool


@functools.cache
def _names(code: types.CodeType) -> _Names:
    read, opened, shown, base = set[str](), set[str](), True, ""
    for instruction in dis.get_instructions(code):
        if "GLOBAL" in instruction.opname or instruction.opname == "LOAD_NAME":
            read.add(instruction.argval)
            base = instruction.argval
        elif instruction.opname in ("LOAD_ATTR", "LOAD_METHOD"):
            opened |= {base} if base and instruction.argval in CHANGING else set()
        elif instruction.opname not in ("CACHE", "PRECALL", "PUSH_NULL", "EXTENDED_ARG"):
            base = ""
        shown &= instruction.opname not in HIDDEN
    for inner in code.co_consts:
        if isinstance(inner, types.CodeType):
            nested = _names(inner)
            read, opened, shown = read | nested.globals, opened | nested.opened, shown and nested.shown
    return _Names(frozenset(read), frozenset(opened), shown)


@functools.cache
def _is_constant(module: str | None) -> bool:
    return (module or "").partition(".")[0] in CONSTANT


@functools.cache
def _may_change(module: str | None) -> bool:
    """Whether a module of a constant package reads files or has a state, as ``scipy.io`` does."""
    package, *inner = (module or "").split(".")
    return package in ("numpy", "scipy") and not CHANGING.isdisjoint(inner)


@functools.cache
def _is_installed(module: str | None) -> bool:
    """Whether a module belongs to Python or to an installed package."""
    root = (module or "").partition(".")[0]
    file = getattr(sys.modules.get(root), "__file__", None) or ""
    folders = sysconfig.get_path("purelib"), sysconfig.get_path("platlib")
    return root in sys.stdlib_module_names or file.startswith(folders)


class _Search:
    """A search for the values that functions read, each of which is added to a hash."""

    def __init__(self) -> None:
        self._hash = hashlib.blake2b(digest_size=16)
        self._seen: dict[int, int] = {}
        self._classes: set[type] = set()
        self._held: list[Any] = []
        self._certain, self._traced = True, False

    def result(self) -> Reads:
        if not self._certain:
            return Reads.unique()
        return Reads(self._hash.digest(), self._certain, self._held, self._traced)

    def argument(self, x: Any) -> None:
        """Add what an argument of a compiled function reads."""
        if isinstance(x, jax.Array | np.ndarray | np.generic):
            return
        if isinstance(x, Reads) or (_attribute(x, "__wrapped__") and not _attribute(x, "__self__")):
            self.value(x)
        elif isinstance(reads := _attribute(x, "reads"), Reads):
            self.value(reads)
        elif (parts := default_registry.flatten_one_level(x)) is not None:
            self._class(type(x))
            for child in parts[0]:
                self.argument(child)
            self.value(parts[1])
        else:
            self.value(x)

    def value(self, x: Any) -> None:
        """Add a value that is part of the program, and all that it holds."""
        if type(x) in _LITERALS:
            self._add(type(x).__name__, x)
        elif isinstance(x, jax.core.Tracer):
            self._traced = True
            self._add(x.aval)
        elif type(x) is np.ndarray or isinstance(x, np.generic):
            self._array(x)
        elif id(x) in self._seen:
            self._add("again", self._seen[id(x)])
        else:
            self._hold(x)
            self._object(x)

    def program(self, program: ClosedJaxpr) -> None:
        """Add a traced program and those inside it."""
        self._add(re.sub(" at 0x[0-9a-f]+", "", str(program.jaxpr)))
        for array in program.consts:
            self.value(np.asarray(array))
        for equation in program.jaxpr.eqns:
            for inner in jax.tree.leaves(list(equation.params.values()), is_leaf=lambda x: isinstance(x, ClosedJaxpr)):
                if isinstance(inner, ClosedJaxpr):
                    self.program(inner)

    def _add(self, *words: Any) -> None:
        self._hash.update(repr(words).encode())

    def _hold(self, x: Any) -> None:
        self._seen[id(x)] = len(self._seen)
        self._held.append(x)

    def _address(self, x: Any) -> None:
        """Add an object that does not change."""
        self._add(id(x))
        self._held.append(x)

    def _all(self, kind: str, values: Iterable[Any]) -> None:
        self._add(kind)
        for value in values:
            self.value(value)

    def _array(self, x: np.ndarray | np.generic) -> None:
        self._add(x.shape, x.dtype.str)
        if x.dtype.hasobject:
            self._all("objects", np.ravel(x).tolist())
        else:
            self._hash.update(x.tobytes())

    def _object(self, x: Any) -> None:
        if isinstance(x, Reads):
            self._traced |= x.traced
            self._add(x)
        elif isinstance(x, types.FunctionType):
            self._function(x)
        elif isinstance(x, types.MethodType):
            self._all("method", (x.__func__, x.__self__))
        elif isinstance(x, functools.partial):
            self._all("partial", (x.func, x.args, x.keywords))
        elif isinstance(x, staticmethod | classmethod):
            self.value(x.__func__)
        elif isinstance(x, property | functools.cached_property):
            self.value(x.fget if isinstance(x, property) else x.func)
        elif isinstance(x, type):
            self._add(x.__module__, x.__qualname__)
            self._class(x)
        elif isinstance(x, types.ModuleType):
            self._module(x)
        elif isinstance(x, jax.Array) and x.size <= COMPARED and isinstance(x.dtype, np.dtype):
            self._array(np.asarray(x))
        elif isinstance(x, jax.Array | types.CodeType):
            self._address(x)
        elif isinstance(x, np.dtype):
            self._add(x.str)
        elif isinstance(x, _BUILT_IN):
            self._certain &= x.__name__ not in CHANGING
            self._address(x)
            owner = getattr(x, "__self__", None)
            self.value(None if isinstance(owner, types.ModuleType) else owner)
        elif callable(x) and (wrapped := _attribute(x, "__wrapped__")) is not None:
            rules = (_attribute(x, name) for name in ("jvp", "fwd", "bwd"))  # of a function with its own derivative
            self._all("wrapped", (type(x), wrapped, *rules))
        elif isinstance(x, np.ndarray | np.generic):
            self._array(x)
            self._instance(x)
        elif isinstance(x, _NUMBERS_AND_TEXTS):
            kind = next(kind for kind in _NUMBERS_AND_TEXTS if isinstance(x, kind))
            self._add(kind.__repr__(x))
            self._instance(x)
        elif isinstance(x, types.MappingProxyType):
            self._all("mapping", itertools.chain.from_iterable(x.items()))
        elif isinstance(x, tuple | list | set | frozenset | dict | deque):
            items = x.items() if isinstance(x, dict) else sorted(x, key=repr) if isinstance(x, set | frozenset) else x
            self._all(type(x).__name__, itertools.chain.from_iterable(items) if isinstance(x, dict) else items)
            self._instance(x)
        else:
            self._instance(x)

    def _module(self, module: types.ModuleType) -> None:
        self._add(module.__name__)
        self._certain &= not _may_change(module.__name__)
        if not _is_constant(module.__name__):
            self._certain &= not _is_installed(module.__name__)
            if self._certain:
                self._all("module", itertools.chain.from_iterable(_without_dunders(vars(module))))

    def _function(self, f: types.FunctionType) -> None:
        self._address(f.__code__)
        for cell in f.__closure__ or ():
            try:
                self.value(cell.cell_contents)
            except ValueError:  # the cell has no value yet
                self._add("empty")
        self._all("defaults", (f.__defaults__, f.__kwdefaults__, *f.__dict__.values()))
        module = f.__globals__.get("__name__")
        if _is_constant(module) or _is_constant(f.__module__):
            self._certain &= f.__name__ not in CHANGING and not _may_change(f.__module__)
            return
        names = _names(f.__code__)
        self._certain &= names.shown and not _is_installed(module)
        if not self._certain:
            return
        for name in sorted(names.globals):
            if name in f.__globals__:
                value = f.__globals__[name]
                self._certain &= not (name in names.opened and isinstance(value, types.ModuleType))
                self._add(name)
                self.value(value)
            elif hasattr(builtins, name):
                known = getattr(builtins, name)
                self._certain &= name in PURE or (isinstance(known, type) and issubclass(known, BaseException))

    def _class(self, kind: type) -> None:
        """Add the methods and attributes of a class, its bases and its metaclass, except those of constant packages."""
        self._address(kind)
        for base in itertools.chain(kind.__mro__, type(kind).__mro__):  # type: ignore[arg-type]
            if not _is_constant(base.__module__) and base not in self._classes:
                self._certain &= not _is_installed(base.__module__)
                self._classes.add(base)
                for name, value in _without_dunders(vars(base)):
                    if self._certain and not isinstance(value, _FIELDS):
                        self._add(name)
                        self.value(value)

    def _instance(self, x: Any) -> None:
        """Add an object's class and attributes."""
        kind = type(x)
        slots = [n for base in kind.__mro__ for n, v in vars(base).items() if isinstance(v, types.MemberDescriptorType)]
        if not hasattr(x, "__dict__") and not slots and not isinstance(x, _KNOWN):
            # objects of C may hold anything; those of JAX and Equinox, such as a sentinel, do not change
            self._certain &= (kind.__module__ or "").partition(".")[0] in ("jax", "jaxlib", "equinox") or kind is object
            self._address(x)
        self._class(kind)
        self._all("attributes", itertools.chain.from_iterable(_attribute(x, "__dict__", {}).items()))
        self._all("slots", (_attribute(x, name) for name in slots))


def _attribute(x: Any, name: str, default: Any = None) -> Any:
    """An attribute, or the default if the object has none or raises any exception."""
    try:
        return getattr(x, name, default)
    except Exception:  # an object's own look-up of attributes may raise anything
        return default


def _without_dunders(attributes: Any) -> list[tuple[str, Any]]:
    """Names and values of a class or module, without those that Python and decorators of classes write."""
    return [
        (name, value)
        for name, value in attributes.items()
        if not name.startswith("_abc_") and (isinstance(value, types.FunctionType) or not name.startswith("__"))
    ]
