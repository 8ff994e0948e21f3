"""The operations of CasADi's SX functions: their names here, and what one number each of them gives.

`scalar` is the definition that the machine code of one lane follows to the last bit; CasADi's own are in its
calculus.hpp. Comparisons with NaN are false, but !=; a condition is true when it is not 0, so NaN is true; fmin and
fmax let a number win over NaN, which is why a clip is never made of them.
"""

from __future__ import annotations

import ctypes
import functools

import casadi as ca
import numpy as np

NULLARY = {ca.OP_CONST: "const", ca.OP_INPUT: "input", ca.OP_OUTPUT: "output"}
ALIAS = {ca.OP_ASSIGN, ca.OP_LIFT}

UNARY = {
    ca.OP_NEG: "neg", ca.OP_SQ: "sq", ca.OP_TWICE: "twice", ca.OP_INV: "inv", ca.OP_SQRT: "sqrt", ca.OP_FABS: "fabs",
    ca.OP_FLOOR: "floor", ca.OP_CEIL: "ceil", ca.OP_SIGN: "sign", ca.OP_NOT: "not",
    ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_EXPM1: "expm1", ca.OP_LOG1P: "log1p", ca.OP_ERF: "erf",
    ca.OP_SIN: "sin", ca.OP_COS: "cos", ca.OP_TAN: "tan", ca.OP_ASIN: "asin", ca.OP_ACOS: "acos", ca.OP_ATAN: "atan",
    ca.OP_SINH: "sinh", ca.OP_COSH: "cosh", ca.OP_TANH: "tanh",
    ca.OP_ASINH: "asinh", ca.OP_ACOSH: "acosh", ca.OP_ATANH: "atanh",
}  # fmt: skip
BINARY = {
    ca.OP_ADD: "add", ca.OP_SUB: "sub", ca.OP_MUL: "mul", ca.OP_DIV: "div",
    ca.OP_LT: "lt", ca.OP_LE: "le", ca.OP_EQ: "eq", ca.OP_NE: "ne", ca.OP_AND: "and", ca.OP_OR: "or",
    ca.OP_IF_ELSE_ZERO: "if_else_zero", ca.OP_FMIN: "fmin", ca.OP_FMAX: "fmax", ca.OP_COPYSIGN: "copysign",
    ca.OP_POW: "pow", ca.OP_CONSTPOW: "pow", ca.OP_ATAN2: "atan2", ca.OP_HYPOT: "hypot",
    ca.OP_FMOD: "fmod", ca.OP_REMAINDER: "remainder",
}  # fmt: skip

# x op y == y op x to the last bit.  fmin and fmax are not among them: fmin(0, -0) is its first argument, as in glibc.
COMMUTATIVE = {"add", "mul", "eq", "ne", "and", "or", "hypot"}
LOGICAL = {"lt", "le", "eq", "ne", "not", "and", "or"}  # the result is 0 or 1

# what the C library computes; all else is arithmetic, a comparison or a choice
LIBM = {
    "exp": 1, "log": 1, "expm1": 1, "log1p": 1, "erf": 1, "sin": 1, "cos": 1, "tan": 1, "asin": 1, "acos": 1, "atan": 1,
    "sinh": 1, "cosh": 1, "tanh": 1, "asinh": 1, "acosh": 1, "atanh": 1,
    "pow": 2, "atan2": 2, "hypot": 2, "fmod": 2, "remainder": 2,
}  # fmt: skip


def opcode_name(opcode: int) -> str:
    """CasADi's own name of an opcode, for messages."""
    return next(
        (name for name in dir(ca) if name.startswith("OP_") and getattr(ca, name) == opcode), f"opcode {opcode}"
    )


@functools.cache
def _library(name: str | None):
    try:
        return ctypes.CDLL(name)
    except OSError:
        return None


@functools.cache
def address(symbol: str) -> int | None:
    """Where a function of the C library, its libm or its libmvec is, or None."""
    for name in ("libm.so.6", "libmvec.so.1", None):  # None: what this process has loaded
        library = _library(name)
        if library is not None and hasattr(library, symbol):
            return ctypes.cast(getattr(library, symbol), ctypes.c_void_p).value
    return None


@functools.cache
def libm(name: str):
    """The function of the C library of this name, double -> double."""
    return ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * LIBM[name])(address(name))


_ARITHMETIC = {
    "neg": lambda x: -x,
    "sq": lambda x: x * x,
    "twice": lambda x: x + x,
    "inv": lambda x: np.float64(1.0) / x,
    "sqrt": np.sqrt,
    "fabs": np.fabs,
    "floor": np.floor,
    "ceil": np.ceil,
    "sign": lambda x: np.float64(-1.0) if x < 0 else np.float64(1.0) if x > 0 else x,
    "not": lambda x: np.float64(x == 0),
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
    "lt": lambda x, y: np.float64(x < y),
    "le": lambda x, y: np.float64(x <= y),
    "eq": lambda x, y: np.float64(x == y),
    "ne": lambda x, y: np.float64(x != y),
    "and": lambda x, y: np.float64(x != 0 and y != 0),
    "or": lambda x, y: np.float64(x != 0 or y != 0),
    "if_else_zero": lambda x, y: np.float64(0.0) if x == 0 else y,
    "fmin": lambda x, y: y if y < x or x != x else x,
    "fmax": lambda x, y: y if y > x or x != x else x,
    "copysign": np.copysign,
}


def scalar(op: str):
    """The operation on np.float64 numbers."""
    return _ARITHMETIC[op] if op in _ARITHMETIC else lambda *x: np.float64(libm(op)(*x))
