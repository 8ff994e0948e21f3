"""What pydantic finds wrong with a part, in the words of this house."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from .errors import InputError, Problem, did_you_mean, nearest
from .quantities import Quantity, brief

if TYPE_CHECKING:
    from .declare import Part


def beside(kind: Any, kinds: Iterable[str], read: Callable[[str], Any]) -> tuple[Problem, ...]:
    """What else is wrong in a table of the unknown `kind`, when `read` takes it for the nearest one there is.

    What is missing depends on the kind, and that is not known.
    """
    near = nearest(kind, kinds) if isinstance(kind, str) else None
    if near is None:
        return ()
    try:
        read(near)
    except InputError as error:
        return tuple(p for p in error.problems if p.rule != "is missing")
    return ()


# pydantic's kinds of error in the words of this house
_RULES = {
    "model_type": "must be a table",
    "dict_type": "must be a table",
    "string_type": "must be a text",
    "string_too_long": "is too long a name",
    "string_pattern_mismatch": "must be of letters, digits and . _ -, letters or digits first",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "list_type": "must be a list",
    "is_instance_of": "must be a table",
    "literal_error": "is none of the words allowed here",
    "greater_than": "must be above {gt}",
    "greater_than_equal": "must be at least {ge}",
    "less_than": "must be below {lt}",
    "less_than_equal": "must be at most {le}",
}


def problems(error: ValidationError, kind: type[Part]) -> list[Problem]:
    """What pydantic found, as problems with dotted keys and the nearest right key."""
    out: list[Problem] = []
    for item in error.errors():
        path = _path(item["loc"])
        key = ".".join(map(str, path)) or None
        inner = item.get("ctx", {}).get("error")
        if isinstance(inner, InputError):
            told = [_from_above(p, kind, path) for p in inner.problems]
            found = [under(p, key) if key else p for p in told]
        elif item["type"] == "missing":
            spec = _spec_at(kind, path)
            cure = f"give {spec.meaning} in {spec.unit}" if spec else _table(kind, path)
            found = [Problem("is missing", key=key, cure=cure)]
        elif item["type"] == "extra_forbidden":
            found = [Problem("no such key", key=key, cure=did_you_mean(str(path[-1]), _fields_at(kind, path[:-1])))]
        else:
            told = item.get("ctx", {})
            rule = (_RULES.get(item["type"]) or item["msg"][:1].lower() + item["msg"][1:]).format(**told)
            if told.get("class") == "ndarray":
                rule = "must be an array"
            allowed = told.get("expected")
            found = [
                Problem(rule, key=key, value=brief(item.get("input")), cure=f"write {allowed}" if allowed else None)
            ]
        out += [p for p in found if p not in out]  # the branches of a union say the same twice
    return out


def _path(loc: tuple) -> tuple:
    """The keys of a pydantic location: what names a branch of a union or a validator is no key, but may not be last."""
    inner = (step for step in loc[:-1] if isinstance(step, int) or re.fullmatch(r"[a-z_][a-z0-9_]*", str(step)))
    return (*inner, *(step for step in loc[-1:] if "function-" not in str(step)))


def under(problem: Problem, key: str) -> Problem:
    """The problem with its key below `key`."""
    inner = f"{key}.{problem.key}" if problem.key else key
    return Problem(**{**problem.__dict__, "key": inner})


def _table(kind: type, path: tuple) -> str | None:
    """The cure for a table that is missing: what it must have."""
    inner = _part_at(kind, path)
    if inner is None:
        return None
    needed = [name for name, field in inner.model_fields.items() if field.is_required()]
    return f"give a table with {', '.join(needed)}" if needed else "give the table"


def _from_above(problem: Problem, kind: type, path: tuple) -> Problem:
    """The problem of a table at `path` as the part around it knows better: what may be left out, and where a key is
    that another table has."""
    if problem.key is None or "." in problem.key or not path or not hasattr(kind, "model_fields"):
        return problem
    field = kind.model_fields.get(path[0])
    if problem.rule == "is missing" and problem.cure and len(path) == 1 and field and not field.is_required():
        return dataclasses.replace(problem, cure=f"{problem.cure}, or leave {path[0]} out")
    if problem.rule == "no such key" and str(problem.cure).startswith("there is "):
        places = [(name, found) for name in kind.model_fields for found in _fields_at(kind, (name,))]
        word = problem.key
        for tail in (word, *(word[at + 1 :] for at, letter in enumerate(word) if letter == "_")):  # max_speed: speed
            inside = [f"{path[0]}.{sub}.{tail}" for sub in _fields_at(kind, path[:1]) if tail in _fields_at(
                kind, (path[0], sub)
            )]  # fmt: skip
            if inside:
                return dataclasses.replace(problem, cure=f"did you mean {' or '.join(inside)}?")
            found = [name for name, field in places if field == tail and name != path[0]]
            if len(found) == 1:
                return dataclasses.replace(problem, cure=f"did you mean {found[0]}.{tail}, in [{found[0]}]?")
    return problem


def _part_at(kind: type, path: tuple) -> type[Part] | None:
    for step in path:
        field = kind.model_fields.get(step) if isinstance(kind, type) else None
        kind = part_of(field.annotation) if field else None
        if kind is None:
            return None
    return kind


def _fields_at(kind: type, path: tuple) -> list[str]:
    for step in path:
        kind = (
            part_of(kind.model_fields[step].annotation)
            if isinstance(kind, type) and step in kind.model_fields
            else None
        )
        if kind is None:
            return []
    return list(kind.model_fields)


def part_of(annotation: Any) -> type[Part] | None:
    """The Part an annotation names, in a union the first."""
    options = getattr(annotation, "__args__", None) or (annotation,)
    parts = [option for option in options if isinstance(option, type) and hasattr(option, "specs")]
    return parts[0] if parts else None


def _spec_at(kind: type, path: tuple) -> Quantity | None:
    for step in path[:-1]:
        field = kind.model_fields.get(step) if isinstance(kind, type) else None
        kind = part_of(field.annotation) if field else None
        if kind is None:
            return None
    return kind.specs().get(path[-1]) if isinstance(kind, type) and hasattr(kind, "specs") else None
