"""Which cases of a test are quick: `@pytest.mark.quick("a-*", "b")` names them, and the others are full."""

from __future__ import annotations

import fnmatch

import pytest


def part(items) -> list[str]:
    """Mark as full what is not named quick; the tests of which no case is left, by their ids."""
    left = {}
    for item in items:
        mark, case = item.get_closest_marker("quick"), getattr(item, "callspec", None)
        if mark is None or case is None:
            continue
        chosen = any(fnmatch.fnmatchcase(case.id, pattern) for pattern in mark.args)
        name = item.nodeid.partition("[")[0]
        left[name] = left.get(name, False) or chosen
        if not chosen:
            item.add_marker(pytest.mark.full)
    return [name for name, some in left.items() if not some]
