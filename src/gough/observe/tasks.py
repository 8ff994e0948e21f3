"""An observer as one function on columns: for the tick of a run, for recorded rows, for export."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca

from ..control.base import Measurement
from ..declare import Shape
from ..kernel.pack import fields, flatten, symbols, unflatten
from .base import Observer


def function_of(observer: Observer) -> ca.Function:
    """(theta, state, q, u, good) -> (found, state after), columns; `good` is 0 where there is no such sample."""
    return _built(Shape(observer))[0]


def fields_of(observer: Observer) -> dict[str, slice]:
    """Where each thing that the observer finds lies in the column."""
    return _built(Shape(observer))[1]


@lru_cache(maxsize=64)
def _built(shape: Shape) -> tuple[ca.Function, dict[str, Any]]:
    observer = shape.part
    n, state = observer.machine.joints_count, observer.init(observer.machine.home)
    theta, s = ca.SX.sym("theta", len(observer.theta)), symbols(state)
    q, u, good = ca.SX.sym("q", n), ca.SX.sym("u", n), ca.SX.sym("good")
    found, after = observer.step(s, Measurement(q, u), good, theta)
    after = unflatten(state, ca.SX(flatten(after)))
    outputs = [ca.SX(flatten(found)), ca.SX(flatten(after))]
    return ca.Function("observe", [theta, flatten(s), q, u, good], outputs), fields(found)
