"""Names in C: what may be one, and that no two meet."""

from __future__ import annotations

import re
from collections.abc import Iterable

from ...errors import ExperimentError

LONGEST = 31  # of the base; words are added to it, and compilers tell 63 letters apart
_KEYWORDS = frozenset(
    """auto break case char const continue default do double else enum extern float for goto if inline int long register
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while asm typeof
    class delete new private public protected this throw try catch template operator namespace using virtual bool
    true false and or not xor main math core test index time""".split()  # noqa: SIM905, of C, of C++, of what is included
)


def identifier(name: str, key: str = "name") -> str:
    """`name`, which all functions of an export begin with.

    Raises
    ------
    ExperimentError
        it is no C identifier, a word of the language, or too long; the cure is a name that is near and may be.
    """
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) and name.lower() not in _KEYWORDS and len(name) <= LONGEST:
        return name
    if len(name) > LONGEST:
        rule = f"a name in C has at most {LONGEST} letters here"
    elif name.lower() in _KEYWORDS:
        rule = "the name is a word of the language C, or of its library"
    else:
        rule = "a name in C has letters, digits and _ only, and begins with a letter"
    raise ExperimentError(rule, key=key, value=ascii(name)[:60], cure=f"write --name {suggested(name)}")


def suggested(name: str) -> str:
    """A C identifier that reads like `name`."""
    near = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_").lower()[:LONGEST].rstrip("_")
    if not near or not near[0].isalpha():
        near = f"m_{near}".rstrip("_")[:LONGEST]
    return f"{near}_1" if near in _KEYWORDS else near


def distinct(names: Iterable[str]) -> list[str]:
    """C identifiers of labels, in order; those that would be the same get a number."""
    out: list[str] = []
    for name in names:
        base = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_").lower() or "x"
        base = base if base[0].isalpha() else f"x{base}"
        found, k = base, 2
        while found in out:
            found, k = f"{base}_{k}", k + 1
        out.append(found)
    return out
