"""Named tuples and flat vectors: what has names outside is one column inside.

A tree is a NamedTuple whose fields are numbers, arrays, SX or further NamedTuples.  Its vector holds the fields in
order; matrices by columns, as CasADi has them.

    class State(NamedTuple):
        integral: ca.SX
        filter: Filter                      # a NamedTuple too

    flatten(State(...))                     # SX (n, 1), or a float64 array (n,) when no SX is in it
    unflatten(template, vector)             # the same tree, its leaves cut from the vector
    names(template)                         # ("integral[0]", "integral[1]", "filter.x")
    fields(template)                        # {"integral": slice(0, 2), "filter.x": slice(2, 3)}
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ..errors import InputError


def is_tree(x: Any) -> bool:
    """A NamedTuple."""
    return isinstance(x, tuple) and hasattr(x, "_fields")


def leaves(tree) -> dict[str, Any]:
    """The leaves by dotted name, in order.  InputError for what is neither a NamedTuple nor numbers."""
    if not is_tree(tree):
        raise InputError("must be a NamedTuple", value=type(tree).__name__)
    found = {}
    for name, value in zip(tree._fields, tree, strict=True):
        if is_tree(value):
            found.update({f"{name}.{inner}": leaf for inner, leaf in leaves(value).items()})
        else:
            found[name] = value
    return found


def shape(leaf) -> tuple[int, int]:
    """Rows and columns of a leaf; a number has one of each."""
    if isinstance(leaf, (ca.SX, ca.DM)):
        return leaf.shape
    if _hides_symbols(leaf):
        raise InputError("symbols in a list or an array become NaN", value=type(leaf).__name__, cure="use ca.vertcat")
    try:
        array = np.asarray(leaf, np.float64)
    except (TypeError, ValueError):
        raise InputError("a field must be a number, an array or SX", value=type(leaf).__name__) from None
    if array.ndim > 2:
        raise InputError("a field has at most two dimensions", value=str(array.shape))
    return (array.shape + (1, 1))[:2] if array.ndim else (1, 1)


def _hides_symbols(leaf) -> bool:
    """Whether SX stand inside a list, a tuple or an array of objects: NumPy would make NaN of them."""
    if isinstance(leaf, np.ndarray):
        return leaf.dtype == object and any(isinstance(entry, ca.SX) for entry in leaf.flat)
    return isinstance(leaf, (list, tuple)) and any(isinstance(e, ca.SX) or _hides_symbols(e) for e in leaf)


def fields(tree) -> dict[str, slice]:
    """Where each leaf lies in the vector."""
    found, start = {}, 0
    for name, leaf in leaves(tree).items():
        rows, columns = shape(leaf)
        found[name] = slice(start, start + rows * columns)
        start += rows * columns
    return found


def size(tree) -> int:
    """Entries of the vector."""
    return sum(s.stop - s.start for s in fields(tree).values())


def names(tree) -> tuple[str, ...]:
    """A name for each entry: "x" for a number, "x[2]" in a column, "x[1,2]" in a matrix."""
    found: list[str] = []
    for name, leaf in leaves(tree).items():
        rows, columns = shape(leaf)
        if columns == 1:
            found += [name] if rows == 1 else [f"{name}[{i}]" for i in range(rows)]
        else:
            found += [f"{name}[{i},{j}]" for j in range(columns) for i in range(rows)]
    return tuple(found)


def flatten(tree):
    """The vector: SX (n, 1) when a leaf is SX, else a float64 array (n,)."""
    parts = list(leaves(tree).values())
    if any(isinstance(leaf, ca.SX) for leaf in parts):
        columns = [ca.densify(ca.vec(leaf if isinstance(leaf, ca.SX) else ca.SX(_numbers(leaf)))) for leaf in parts]
        return ca.vertcat(ca.SX(0, 1), *columns)
    return np.concatenate([np.empty(0), *(_numbers(leaf).reshape(-1, order="F") for leaf in parts)])


def _numbers(leaf) -> np.ndarray:
    rows, columns = shape(leaf)
    return np.array(leaf, np.float64).reshape(rows, columns, order="F")


def unflatten(template, vector):
    """A tree shaped like `template`, its leaves cut from the vector.  InputError when the length differs.

    From SX come SX (rows, columns); from an array come arrays of the shapes the template has, numbers where it has
    numbers.
    """
    symbolic = isinstance(vector, (ca.SX, ca.DM))
    if not symbolic:
        vector = np.asarray(vector, np.float64).reshape(-1)
    length = vector.numel() if symbolic else vector.size
    expected = size(template)
    if length != expected:
        raise InputError(f"{type(template).__name__} has {expected} entries", value=str(length))
    return _cut(template, vector, 0, symbolic)[0]


def _cut(tree, vector, start: int, symbolic: bool):
    values = []
    for leaf in tree:
        if is_tree(leaf):
            value, start = _cut(leaf, vector, start, symbolic)
        else:
            rows, columns = shape(leaf)
            stop = start + rows * columns
            piece = vector[start:stop]
            value = ca.reshape(piece, rows, columns) if symbolic else piece.reshape(_shape_of(leaf), order="F")
            if not symbolic and value.ndim == 0:
                value = float(value)
            start = stop
        values.append(value)
    return type(tree)(*values), start


def _shape_of(leaf) -> tuple[int, ...]:
    return shape(leaf) if isinstance(leaf, (ca.SX, ca.DM)) else np.shape(leaf)


def symbols(template, prefix: str = ""):
    """A tree shaped like `template` of new SX symbols, named by their fields."""
    values = []
    for name, leaf in zip(template._fields, template, strict=True):
        label = f"{prefix}{name}"
        values.append(symbols(leaf, f"{label}.") if is_tree(leaf) else ca.SX.sym(label, *shape(leaf)))
    return type(template)(*values)
