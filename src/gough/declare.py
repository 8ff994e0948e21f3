"""Parts: immutable objects of checked numbers.  Each number is declared once, with its unit, bound and meaning.

    class Body(Part):
        mass:   float = quantity("kg", "mass", above=0)
        center: Array = quantity("m", "centre of mass, in T", shape=(3,))

Made in Python a part takes SI numbers; read from a file it takes strings with units (`Part.from_file`).  Numbers and
equations are kept apart: `part.theta` is the flat vector of all its numbers, `part.names` their names, and
`part.at(theta)` is the same part with entries of a symbolic theta in the places of its numbers.  Equations are
written on that view, so that one compiled kernel serves every value, and regressors and gradients are Jacobians by
theta.  A number that is absent (None) is structurally absent: it has no entry in theta.
"""

from __future__ import annotations

import hashlib
import importlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    field_validator,
)
from pydantic_core import PydanticUndefined

from . import units
from .complaints import part_of, problems, under
from .errors import ExperimentError, InputError, Problem, UnitError, did_you_mean
from .quantities import Quantity, brief, shape_text, written

Array = np.ndarray


def quantity(unit: str, meaning: str, *, default: Any = ..., theta: bool = True, **bounds: Any) -> Any:
    """Declare a number of a part: unit, meaning, bounds (above, at_least, below, at_most), shape.

    `default=None` makes it optional.  `theta=False` keeps it out of the equations (a budget, a report option).
    """
    spec = Quantity(unit, meaning, **bounds)
    if default is not ... and default is not None:
        default = spec.check(default, from_file=False)
    return Field(default, description=meaning, json_schema_extra={"quantity": spec, "theta": theta})


# whether values come from a file, where a number needs its unit; pydantic's own context does not reach through __init__
_FROM_FILE: ContextVar[bool] = ContextVar("from_file", default=False)


@contextmanager
def _rules(file: bool) -> Iterator[None]:
    token = _FROM_FILE.set(file)
    try:
        yield
    finally:
        _FROM_FILE.reset(token)


def si_numbers() -> Any:
    """A context in which parts are made of SI numbers, also while a file is read: for parts that follow from others."""
    return _rules(file=False)


def one_of(**kinds: str) -> BeforeValidator:
    """For `Annotated`: a table whose `kind` chooses the Part, one_of(pid="gough.control.pid:PID", ...)."""

    def choose(raw: Any) -> Any:
        if not isinstance(raw, Mapping):
            return raw
        chosen = raw.get("kind")
        if chosen not in kinds:
            rule = "is missing" if chosen is None else f"no such kind {brief(chosen)}"
            cure = f"there is {', '.join(kinds)}" if chosen is None else did_you_mean(str(chosen), kinds)
            raise InputError(rule, key="kind", cure=cure)
        module, _, name = kinds[chosen].partition(":")
        kind = getattr(importlib.import_module(module), name)
        return kind(**raw)

    return BeforeValidator(choose)


_SPECS: dict[type, dict[str, Quantity]] = {}  # of a class; parts are made by the thousand


class Part(BaseModel):
    """Base of machines, laws and programs: frozen, no unknown keys, no inf or nan, equal and hashed by content."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        arbitrary_types_allowed=True,
        allow_inf_nan=False,
        strict=True,
        validate_default=False,
    )
    input_error: ClassVar[type[InputError]] = ExperimentError

    def __init__(self, **data: Any):
        try:
            super().__init__(**data)
        except ValidationError as error:
            raise self.input_error(problems=problems(error, type(self))) from None
        for name in self.specs():  # pydantic copies a default, and the copy may be written to
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """The declared numbers become the last part of the docstring: `help(gk.PID)` tells what is asked for."""
        rows = [
            f"    {name} : {'number' if spec.unit == '1' else spec.unit}\n        {spec.meaning}" + _left_out(cls, name)
            for name, spec in cls.specs().items()
        ]
        if rows and cls.__doc__ and "Numbers\n" not in cls.__doc__:
            cls.__doc__ = f"{cls.__doc__.rstrip()}\n\n    Numbers\n    -------\n" + "\n".join(rows) + "\n    "

    @classmethod
    def from_file(cls, data: Mapping[str, Any]) -> Part:
        """The part that a file's table describes: quantities are strings with units.

        Raises
        ------
        InputError
            of the part's kind, with a problem for every wrong key.  `key` is set, file and line are not.
        """
        with _rules(file=True):
            return cls(**data)

    @field_validator("*", mode="before")
    @classmethod
    def _check_quantity(cls, raw: Any, info: ValidationInfo) -> Any:
        spec = cls.specs().get(info.field_name)
        if spec is None or (raw is None and cls.model_fields[info.field_name].default is None):
            return raw
        return spec.check(raw, from_file=_FROM_FILE.get())

    @classmethod
    def specs(cls) -> dict[str, Quantity]:
        """The declared quantities by field name."""
        known = _SPECS.get(cls)
        if known is None:
            extras = {name: field.json_schema_extra for name, field in cls.model_fields.items()}
            known = {name: e["quantity"] for name, e in extras.items() if isinstance(e, dict) and "quantity" in e}
            if cls.__pydantic_complete__:
                _SPECS[cls] = known
        return known

    # -- the numbers, flat ------------------------------------------------------------------------------------

    def _numbers(self) -> Iterator[tuple[str, Any, Quantity]]:
        """(dotted name, value, spec) of every number that stands in theta, in the order of declaration."""
        for name, spec in self.specs().items():
            value = getattr(self, name)
            if value is not None and type(self).model_fields[name].json_schema_extra["theta"]:
                yield name, value, spec
        for name in type(self).model_fields:
            value = getattr(self, name)
            if isinstance(value, Part):
                for inner, number, spec in value._numbers():
                    yield f"{name}.{inner}", number, spec

    @cached_property
    def theta(self) -> np.ndarray:
        """All numbers of the part, flat.  (n,), SI."""
        flat = [np.ravel(value) for _, value, _ in self._numbers()]
        joined = np.concatenate(flat) if flat else np.zeros(0)
        joined.setflags(write=False)
        return joined

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Name of each entry of theta: "platform.mass", "joints.base[0,2]"."""
        out = []
        for name, value, _ in self._numbers():
            if np.ndim(value) == 0:
                out.append(name)
            else:
                out += [f"{name}[{','.join(map(str, index))}]" for index in np.ndindex(np.shape(value))]
        return tuple(out)

    def at(self, theta: Any) -> View:
        """This part with entries of the column `theta` (SX or DM) in the places of its numbers."""
        count = len(self.theta)
        if theta.shape != (count, 1):
            raise ExperimentError(f"theta of {type(self).__name__} has {count} entries", value=str(theta.shape))
        view, used = _view(self, theta, 0)
        assert used == count
        return view

    # -- equality, change, text -------------------------------------------------------------------------------

    def __repr__(self) -> str:
        shown = []
        for name in type(self).model_fields:
            value = getattr(self, name)
            if isinstance(value, np.ndarray) and value.size > 6:
                shown.append(f"{name}=<{shape_text(value.shape)}>")
            elif not is_default(self, name) and not isinstance(value, dict):
                shown.append(f"{name}={value.tolist() if isinstance(value, np.ndarray) else value!r}")
        return f"{type(self).__name__}({', '.join(shown)})"

    __str__ = __repr__

    def _content(self) -> tuple:
        out: list = [type(self).__module__, type(self).__qualname__]
        for name in type(self).model_fields:
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                value = (value.shape, value.tobytes())
            elif isinstance(value, Part):
                value = value._content()
            elif _parts(value):
                value = tuple(one._content() for one in value)
            elif isinstance(value, dict | list):
                value = repr(value)
            out.append((name, value))
        return tuple(out)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Part) and self._content() == other._content()

    def __hash__(self) -> int:
        return int(self.digest()[:15], 16)

    def digest(self) -> str:
        """SHA-256 of the content, hex: equal parts have equal digests, in every process."""
        return hashlib.sha256(repr(self._content()).encode()).hexdigest()

    def structure(self) -> tuple:
        """All of the part but the values in theta: parts of one structure have the same equations."""
        return self._structure

    @cached_property
    def _structure(self) -> tuple:
        out: list = [type(self).__module__, type(self).__qualname__]
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            if isinstance(value, Part):
                value = value.structure()
            elif _parts(value):
                value = tuple(one.structure() for one in value)
            elif name in self.specs() and field.json_schema_extra["theta"]:
                value = None if value is None else np.shape(value)
            else:
                value = repr(value)
            out.append((name, value))
        return tuple(out)

    def replace(self, **changes: Any) -> Part:
        """A copy with other values; dotted names reach inside: `machine.replace(**{"platform.mass": 320})`.

        Raises
        ------
        ExperimentError
            for a name that is not there, with the nearest that is, or a value out of bounds.
        """
        return self._replaced(changes, from_file=False)

    def replace_from_file(self, changes: Mapping[str, Any]) -> Part:
        """`replace` with values as a file writes them; "1.2 x" multiplies the part's own number, "none" takes away
        what may be absent."""
        return self._replaced(changes, from_file=True)

    def _replaced(self, changes: Mapping[str, Any], from_file: bool) -> Part:
        data = {name: getattr(self, name) for name in type(self).model_fields}
        inner: dict[str, dict[str, Any]] = {}
        wrong = []
        for key, raw in changes.items():
            head, _, rest = key.partition(".")
            if head not in data or (rest and not isinstance(data[head], Part)):
                wrong.append(Problem("no such key", key=key, cure=did_you_mean(key, self._keys())))
            elif rest:
                inner.setdefault(head, {})[rest] = raw
            else:
                try:
                    data[head] = self._changed(head, data[head], raw, from_file)
                except InputError as error:
                    wrong += error.at(key=key).problems
        for head, group in inner.items():
            try:
                data[head] = data[head]._replaced(group, from_file)
            except InputError as error:
                wrong += [under(p, head) for p in error.problems]
        if wrong:
            raise self.input_error(problems=wrong)
        with _rules(file=False):  # what is left is SI
            return type(self)(**data)

    def _changed(self, name: str, old: Any, raw: Any, from_file: bool) -> Any:
        spec = self.specs().get(name)
        if from_file and isinstance(raw, str) and raw == "none" and type(self).model_fields[name].default is None:
            return None
        if spec is None:
            if name == "kind" and raw != old:
                raise InputError(
                    "another kind is another table", value=brief(raw), cure=f"write {{ kind = {raw!r}, ... }}"
                )
            if not isinstance(raw, Mapping):
                return raw
            if isinstance(old, Part) and raw.get("kind", getattr(old, "kind", None)) == getattr(old, "kind", None):
                return old._replaced({key: value for key, value in raw.items() if key != "kind"}, from_file)
            return self._made(name, raw, from_file)
        if isinstance(raw, str) and raw.strip().endswith("x"):
            times, dimension = units.parse(raw)
            if any(dimension):
                raise UnitError(f"{raw!r} is not a factor", cure='write e.g. "1.2 x"')
            if old is None:
                raise InputError("cannot be scaled: the machine has none", value=raw)
            return spec.check(np.asarray(old) * times, from_file=False)
        if raw is None and not from_file and type(self).model_fields[name].default is None:
            return None
        return spec.check(raw, from_file)

    def _made(self, name: str, raw: Mapping[str, Any], from_file: bool) -> Any:
        """A new part for the field `name`: one that was absent, or of another kind."""
        annotation = type(self).model_fields[name].annotation
        try:
            with _rules(file=from_file):
                return TypeAdapter(annotation).validate_python(dict(raw))
        except ValidationError as error:
            raise self.input_error(problems=problems(error, part_of(annotation) or type(self))) from None

    def _keys(self) -> list[str]:
        """All dotted keys that `replace` takes."""
        out = []
        for name in type(self).model_fields:
            value = getattr(self, name)
            out.append(name)
            if isinstance(value, Part):
                out += [f"{name}.{key}" for key in value._keys()]
        return out

    def to_file(self) -> dict[str, Any]:
        """The table that `from_file` reads back to an equal part: quantities as strings with SI units."""
        out: dict[str, Any] = {}
        specs = self.specs()
        for name in type(self).model_fields:
            value = getattr(self, name)
            if value is None:
                continue
            if name in specs:
                out[name] = written(value, specs[name])
            elif isinstance(value, Part):
                out[name] = value.to_file()
            elif _parts(value):
                out[name] = [one.to_file() for one in value]
            else:
                out[name] = value
        return out


def _parts(value: Any) -> bool:
    """Whether a value is a list of parts; their numbers are in no theta."""
    return isinstance(value, list) and bool(value) and all(isinstance(one, Part) for one in value)


class Shape:
    """A part as a key that is equal for parts of one structure: compiled equations are found by it."""

    def __init__(self, part: Part):
        self.part = part
        self._structure = part.structure()

        self._hash = hash(self._structure)

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Shape) and self._hash == other._hash and self._structure == other._structure


class View:
    """A part seen through theta: fields that are numbers are entries of theta, everything else is the part's."""

    def __init__(self, part: Part, values: dict[str, Any]):
        self._part = part
        self._values = values

    def __getattr__(self, name: str) -> Any:
        values = self.__dict__["_values"]
        return values[name] if name in values else getattr(self.__dict__["_part"], name)


def _view(part: Part, theta: Any, start: int) -> tuple[View, int]:
    values: dict[str, Any] = {}
    for name, spec in part.specs().items():
        value = getattr(part, name)
        if value is None or not type(part).model_fields[name].json_schema_extra["theta"]:
            continue
        size = int(np.size(value))
        piece = theta[start : start + size]
        # CasADi stores columns first, theta rows first
        values[name] = piece if len(spec.shape) < 2 else piece.reshape(np.shape(value)[::-1]).T
        start += size
    for name in type(part).model_fields:
        value = getattr(part, name)
        if isinstance(value, Part):
            values[name], start = _view(value, theta, start)
    return View(part, values), start


def _left_out(kind: type[Part], name: str) -> str:
    field = kind.model_fields[name]
    if field.is_required():
        return ""
    return "; may be left out" if field.default is None else f"; {np.asarray(field.default).tolist()} if left out"


def is_default(part: Part, name: str) -> bool:
    """Whether a field still has its declared default."""
    default = type(part).model_fields[name].default
    value = getattr(part, name)
    return default is not PydanticUndefined and bool(np.array_equal(value, default))
