"""The equation of motion as a symbolic first order system, translated from the functions of a problem.

The routes through heyoka and SciPy solve this system, and so does CVODE if the problem can be translated.
"""

from collections.abc import Callable

import heyoka as hy
import jax
import jax.extend.core  # JAX may change this module, but has no other way to read a traced program
import numpy as np
import sympy
from sympy.printing.pycode import PythonCodePrinter

from study.mechanics.definition import Problem


def _whole_power(a, exponent: int):
    """Power of ``a`` by products: heyoka's series of powers above the second divides by ``a``, which may be zero."""
    if exponent <= 2:
        return a**exponent
    half = _whole_power(a, exponent // 2)
    return half * half * a if exponent % 2 else half * half


_OPERATIONS: dict[str, Callable] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
    "pow": lambda a, b: a**b,
    "integer_pow": _whole_power,
    "square": lambda a: a * a,
    "sqrt": hy.sqrt,
    "exp": hy.exp,
    "log": hy.log,
    "sin": hy.sin,
    "cos": hy.cos,
    "tanh": hy.tanh,
    "sinh": hy.sinh,
    "cosh": hy.cosh,
    "tan": hy.tan,
    "asin": hy.asin,
    "acos": hy.acos,
    "atan": hy.atan,
    "asinh": hy.asinh,
    "acosh": hy.acosh,
    "atanh": hy.atanh,
    "erf": hy.erf,
    "log1p": lambda a: hy.log(1.0 + a),
    "expm1": lambda a: hy.exp(a) - 1.0,
    "convert_element_type": lambda a: a,
    "copy": lambda a: a,
}


class Untranslatable(ValueError):
    """A function contains an operation that has no Taylor series here, such as a branch or a table."""


def expression(function: Callable, argument: hy.expression) -> hy.expression:
    """Translate a smooth scalar JAX function into an expression of heyoka.

    Constants keep the values that they have in double precision, also in arithmetic of more digits.

    Raises
    ------
    Untranslatable
        If the function contains an operation without translation, such as a branch.
    """

    def evaluate(jaxpr, constants, arguments):
        values = dict(zip(jaxpr.constvars, constants, strict=True)) | dict(zip(jaxpr.invars, arguments, strict=True))

        def read(atom):
            return float(atom.val) if isinstance(atom, jax.extend.core.Literal) else values[atom]

        for equation in jaxpr.eqns:
            inputs = [read(atom) for atom in equation.invars]
            name = equation.primitive.name
            if name in ("jit", "pjit", "custom_jvp_call"):
                inner = equation.params["call_jaxpr" if name == "custom_jvp_call" else "jaxpr"]
                results = evaluate(inner.jaxpr, inner.consts, inputs)
            elif name in _OPERATIONS:
                exponent = [equation.params["y"]] if name == "integer_pow" else []
                results = [_OPERATIONS[name](*inputs, *exponent)]
            else:
                raise Untranslatable(
                    f"'{name}' has no translation into a Taylor series; known are {', '.join(_OPERATIONS)}."
                )
            values |= dict(zip(equation.outvars, results, strict=True))
        return [read(atom) for atom in jaxpr.outvars]

    closed = jax.make_jaxpr(function)(1.0)
    if any(np.ndim(constant) for constant in closed.consts):
        raise Untranslatable("a table has no translation into a Taylor series.")
    (result,) = evaluate(closed.jaxpr, [float(c) for c in closed.consts], [argument])
    return result


def _acceleration(problem: Problem, internal_force, v) -> hy.expression:
    """v̇ = (f(t) − C v − p) / M for a given expression of the internal force p."""
    result = -internal_force
    if problem.damping is not None:
        result = result - float(problem.damping) * v
    if problem.load is not None:
        result = result + expression(problem.load, hy.time)
    return result if problem.mass is None else result / float(problem.mass)


def _check_depends_on_displacement(problem: Problem) -> None:
    if problem.dissipative:
        raise Untranslatable(f"the force of '{problem.title}' depends on more than the displacement.")


def first_order(problem: Problem) -> list[tuple[hy.expression, hy.expression]]:
    r"""The equation of motion of a problem with one unknown as a system of first order.

    .. math::

        \dot u = v, \quad \dot v = (f(t) - C v - p(u))/M

    Raises
    ------
    ValueError
        If the problem has more than one unknown, or a function without translation.
    """
    if np.ndim(problem.u0):
        raise ValueError(f"'{problem.title}' has {len(problem.u0)} unknowns; this route takes one.")
    _check_depends_on_displacement(problem)
    u, v = hy.make_vars("u", "v")
    return [(u, v), (v, _acceleration(problem, expression(problem.static_force, u), v))]


class _ToTheBit(PythonCodePrinter):
    """Printer that writes constants with all their digits; SymPy writes fifteen by default."""

    def _print_Float(self, expr):
        return repr(float(expr))


def as_python(problem: Problem) -> Callable[[float, float, float], float]:
    """The acceleration v̇(t, u, v) as a function of plain floats, the fastest form of a right side in Python.

    Raises
    ------
    ValueError
        If the problem has more than one unknown, or a function without translation.
    """
    (u, _), (v, acceleration) = first_order(problem)
    arguments = hy.to_sympy(hy.time), hy.to_sympy(u), hy.to_sympy(v)
    printer = _ToTheBit({"fully_qualified_modules": False})
    return sympy.lambdify(arguments, hy.to_sympy(acceleration), "math", printer=printer, cse=True)


def with_force_as_state(problem: Problem) -> list[tuple[hy.expression, hy.expression]]:
    r"""The equation of motion as a system of first order in which the internal force w = p(u) is a state.

    .. math::

        \dot u = v, \quad \dot v = (f(t) - C v - w)/M, \quad \dot w = p'(u)\,v

    The Taylor coefficients follow from other recurrences than in :func:`first_order`, so an error in one formulation
    does not repeat in the other.

    Raises
    ------
    ValueError
        If a function of the problem has no translation.
    """
    _check_depends_on_displacement(problem)
    u, v, w = hy.make_vars("u", "v", "w")
    return [(u, v), (v, _acceleration(problem, w, v)), (w, hy.diff(expression(problem.static_force, u), u) * v)]
