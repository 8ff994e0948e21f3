"""Whether parts differ in numbers only: then one program serves them all, and their runs go side by side."""

from __future__ import annotations

from ..declare import Shape
from ..errors import ExperimentError


def same_structure(key: str, parts: list, number: int | None = None) -> None:
    """Refuse parts of which not only numbers differ: they have other equations, so another program.

    `number` is that of the last part among the runs, where it is not its place in the list.
    """
    first = Shape(parts[0])
    for place, part in enumerate(parts):
        i = place if number is None else number
        if part is not parts[0] and Shape(part) != first:
            where, old, new = _difference(parts[0].structure(), part.structure())
            raise ExperimentError(
                "runs of a batch may differ in numbers only",
                key=f"{key}.{i}{'.' if where else ''}{where}",
                value=f"{new}; run 0 has {old}",
                cure="run those of one structure together",
            )


def _difference(a, b) -> tuple[str, str, str]:
    """Where two structures differ first, and what each has there."""
    if a is None or b is None or not (isinstance(a, tuple) and isinstance(b, tuple)) or a[:2] != b[:2]:
        return "", _shown(a), _shown(b)
    for (name, x), (_, y) in zip(a[2:], b[2:], strict=True):
        if x == y:
            continue
        if all(isinstance(v, tuple) and v and isinstance(v[0], str) for v in (x, y)):
            where, old, new = _difference(x, y)
            return f"{name}.{where}" if where else name, old, new
        return name, _shown(x), _shown(y)
    return "", _shown(a), _shown(b)


def _shown(value) -> str:
    if value is None or value == "None":
        return "none"
    if isinstance(value, tuple):
        if value and isinstance(value[0], str):
            return str(value[1])  # the class
        return "a number" if not value else f"an array {'x'.join(map(str, value))}"
    return str(value)
